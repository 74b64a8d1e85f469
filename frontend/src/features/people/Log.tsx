import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useInfiniteQuery } from "@tanstack/react-query";

import { auditQuery } from "@/api/people";
import { Button } from "@/components/controls/Button";
import { Failed, Loading } from "@/components/feedback/States";
import { moment } from "@/lib/format";

import styles from "./PeoplePage.module.css";
import { actionOf, detailsOf } from "./words";

/** Who did what, newest first, page by page. */
export function Log() {
  const { data, error, refetch, hasNextPage, fetchNextPage, isFetchingNextPage } =
    useInfiniteQuery(auditQuery);
  if (error && !data) {
    return <Failed what={t`The log`} error={error} onRetry={() => void refetch()} />;
  }
  if (!data) return <Loading what={t`the log`} rows={3} height="2rem" />;
  return (
    <>
      <ol className={styles.log}>
        {data.pages.flat().map((entry) => (
          <li key={entry.id}>
            <time dateTime={entry.at}>{moment(entry.at)}</time>{" "}
            <strong>{entry.player ?? t`Terminal`}</strong> {actionOf(entry)}
            {detailsOf(entry) && ` (${detailsOf(entry)})`}
          </li>
        ))}
      </ol>
      {hasNextPage && (
        <p>
          <Button disabled={isFetchingNextPage} onClick={() => void fetchNextPage()}>
            <Trans>Show older entries</Trans>
          </Button>
        </p>
      )}
    </>
  );
}

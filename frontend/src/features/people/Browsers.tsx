import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQuery } from "@tanstack/react-query";

import { messageOf } from "@/api/client";
import { browsersQuery, signBrowserOut } from "@/api/people";
import { Button } from "@/components/controls/Button";
import { Failed, Loading, Notice } from "@/components/feedback/States";
import { moment } from "@/lib/format";

import styles from "./PeoplePage.module.css";
import { roleName } from "./words";

/** The browsers that are signed in, each with a button that signs it out. */
export function Browsers() {
  const { data: browsers, error, refetch } = useQuery(browsersQuery);
  const end = useMutation({ mutationFn: signBrowserOut, onSettled: () => void refetch() });
  if (error && !browsers) {
    return <Failed what={t`The browsers`} error={error} onRetry={() => void refetch()} />;
  }
  if (!browsers) return <Loading what={t`the browsers`} rows={2} height="3rem" />;
  return (
    <>
      {end.error && (
        <Notice tone="bad" live>
          {messageOf(end.error)}
        </Notice>
      )}
      <ul className={styles.rows}>
        {browsers.map(({ id, name, player, role, seen_at: seen, created_at: created, present }) => (
          <li key={id}>
            <span className={styles.what}>
              <strong>{player}</strong> ({roleName(role)}), {name}
              <small>{present ? t`This browser` : t`Last used ${moment(seen ?? created)}`}</small>
            </span>
            {!present && (
              <Button
                aria-label={t`Sign out ${player}, ${name}`}
                disabled={end.isPending}
                onClick={() => end.mutate(id)}
              >
                <Trans>Sign out</Trans>
              </Button>
            )}
          </li>
        ))}
      </ul>
    </>
  );
}

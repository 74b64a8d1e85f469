import { t } from "@lingui/core/macro";
import { useMutation, useQuery } from "@tanstack/react-query";

import { messageOf } from "@/api/client";
import { browsersQuery, signBrowserOut } from "@/api/people";
import { Failed, Loading, Notice } from "@/components/feedback/States";
import { useFirst } from "@/components/list/use-first";
import { moment } from "@/lib/format";

import { Credential } from "./Credential";
import styles from "./PeoplePage.module.css";
import { roleName } from "./words";

/** The browsers that are signed in, each with a button that signs it out. */
export function Browsers() {
  const { data: browsers, error, refetch } = useQuery(browsersQuery);
  const [shown, more] = useFirst(browsers ?? []);
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
        {shown.map(({ id, name, player, role, seen_at: seen, created_at: created, present }) => (
          <Credential
            key={id}
            note={present ? t`This browser` : t`Last used ${moment(seen ?? created)}`}
            end={
              present
                ? undefined
                : {
                    label: t`Sign out`,
                    name: t`Sign out ${player}, ${name}`,
                    disabled: end.isPending,
                    onClick: () => end.mutate(id),
                  }
            }
          >
            <strong>{player}</strong> ({roleName(role)}), {name}
          </Credential>
        ))}
      </ul>
      {more}
    </>
  );
}

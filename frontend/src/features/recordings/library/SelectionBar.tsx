import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { exportUrl } from "@/api/recordings";
import type { Behaviour, Recording } from "@/api/types";
import { Button, DownloadLink } from "@/components/controls/Button";
import { usePerfectMark } from "@/components/recording/use-perfect-mark";
import { useRecordingActions } from "@/components/recording/use-recording-actions";
import { classes } from "@/lib/classes";

import styles from "./SelectionBar.module.css";

/** The server's limit on recordings changed or exported at once. */
const MOST = 500;

/** Actions on the selected recordings. */
export function SelectionBar({
  behaviour,
  shown,
  selected,
  onSelect,
}: {
  behaviour: Behaviour;
  shown: readonly Recording[];
  selected: readonly Recording[];
  onSelect: (recordings: readonly Recording[]) => void;
}) {
  const actions = useRecordingActions(behaviour.id);
  const any = selected.length > 0;
  const deleted = selected.some((one) => one.deleted);
  const allPerfect = any && selected.every((one) => one.perfect);
  const { mark, question } = usePerfectMark(behaviour);
  function change(what: Parameters<typeof actions.changeAll>[1]) {
    actions.changeAll(selected, what);
    if (what === "delete" || what === "restore") onSelect([]);
  }
  return (
    <div
      className={classes(styles.selection, any && styles.some)}
      role="group"
      aria-label={t`Selected recordings`}
    >
      <span role="status" className={styles.count}>
        {any
          ? plural(selected.length, { one: "# recording selected", other: "# recordings selected" })
          : t`${shown.length} shown`}
      </span>
      {selected.length < Math.min(shown.length, MOST) && (
        <Button kind="quiet" onClick={() => onSelect(shown.slice(0, MOST))}>
          {shown.length > MOST ? t`Select the first ${MOST}` : t`Select all shown`}
        </Button>
      )}
      {any && (
        <>
          <Button kind="quiet" onClick={() => onSelect([])}>
            <Trans>Select none</Trans>
          </Button>
          {selected.length > MOST ? (
            <span className={styles.count}>
              <Trans>At most {MOST} can be changed at once.</Trans>
            </span>
          ) : deleted ? (
            <Button icon="undo" onClick={() => change("restore")}>
              <Trans>Restore</Trans>
            </Button>
          ) : (
            <>
              <Button
                icon="star"
                onClick={() => {
                  if (allPerfect) change("unmark_perfect");
                  else {
                    const unmarked = selected.filter((one) => !one.perfect);
                    mark(unmarked, () => change("mark_perfect"));
                  }
                }}
              >
                {allPerfect ? t`Remove the perfect marks` : t`Mark as perfect`}
              </Button>
              <DownloadLink
                href={exportUrl(
                  behaviour.id,
                  selected.map(({ id }) => id),
                )}
              >
                <Trans>Export selected</Trans>
              </DownloadLink>
              {question}
              <Button icon="trash" onClick={() => change("delete")}>
                <Trans>Delete</Trans>
              </Button>
            </>
          )}
        </>
      )}
    </div>
  );
}

import { exportUrl } from "@/api/recordings";
import type { Behaviour, Recording } from "@/api/types";
import { Button, DownloadLink } from "@/components/controls/Button";
import { usePerfectMark } from "@/components/recording/use-perfect-mark";
import { useRecordingActions } from "@/components/recording/use-recording-actions";
import { classes } from "@/lib/classes";
import { count } from "@/lib/format";

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
      aria-label="Selected recordings"
    >
      <span role="status" className={styles.count}>
        {any ? `${count(selected.length, "recording")} selected` : `${shown.length} shown`}
      </span>
      {selected.length < Math.min(shown.length, MOST) && (
        <Button kind="quiet" onClick={() => onSelect(shown.slice(0, MOST))}>
          {shown.length > MOST ? `Select the first ${MOST}` : "Select all shown"}
        </Button>
      )}
      {any && (
        <>
          <Button kind="quiet" onClick={() => onSelect([])}>
            Select none
          </Button>
          {selected.length > MOST ? (
            <span className={styles.count}>At most {MOST} can be changed at once.</span>
          ) : deleted ? (
            <Button icon="undo" onClick={() => change("restore")}>
              Restore
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
                {allPerfect ? "Remove the perfect marks" : "Mark as perfect"}
              </Button>
              <DownloadLink
                href={exportUrl(
                  behaviour.id,
                  selected.map(({ id }) => id),
                )}
              >
                Export selected
              </DownloadLink>
              {question}
              <Button icon="trash" onClick={() => change("delete")}>
                Delete
              </Button>
            </>
          )}
        </>
      )}
    </div>
  );
}

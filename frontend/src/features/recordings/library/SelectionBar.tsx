import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { useMutation } from "@tanstack/react-query";

import { messageOf } from "@/api/client";
import { exportUrl, fetchExport, MOST_IN_URL } from "@/api/recordings";
import type { Behaviour, LibraryEntry } from "@/api/types";
import { Button, DownloadLink } from "@/components/controls/Button";
import { useToast } from "@/components/feedback/Toasts";
import { usePerfectMark } from "@/components/recording/use-perfect-mark";
import { useRecordingActions } from "@/components/recording/use-recording-actions";
import { classes } from "@/lib/classes";
import { whole } from "@/lib/format";
import { saveFile } from "@/lib/browser/save-file";

import styles from "./SelectionBar.module.css";

/** Actions on the selected recordings. */
export function SelectionBar({
  behaviour,
  shown,
  total,
  isWhole,
  selected,
  onSelect,
}: {
  behaviour: Behaviour;
  shown: readonly LibraryEntry[];
  /** Number of recordings before filtering, which the page's heading has. */
  total: number;
  /** Whether these are all that are shown. */
  isWhole: boolean;
  selected: readonly LibraryEntry[];
  onSelect: (ids: readonly number[]) => void;
}) {
  const actions = useRecordingActions(behaviour.id);
  const ids = selected.map(({ id }) => id);
  const any = ids.length > 0;
  const deleted = selected.some((one) => one.deleted);
  const allPerfect = any && selected.every((one) => one.perfect);
  const { mark, question } = usePerfectMark(behaviour);
  function change(what: Parameters<typeof actions.changeAll>[1]) {
    actions.changeAll(ids, what);
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
          : !isWhole
            ? t`Loading the others…`
            : shown.length < total && t`${whole(shown.length)} of ${whole(total)} shown`}
      </span>
      {isWhole && selected.length < shown.length && (
        <Button kind="quiet" onClick={() => onSelect(shown.map(({ id }) => id))}>
          <Trans>Select all shown</Trans>
        </Button>
      )}
      {any && (
        <>
          <Button kind="quiet" onClick={() => onSelect([])}>
            <Trans>Select none</Trans>
          </Button>
          {deleted ? (
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
              <ExportSelected behaviour={behaviour} ids={ids} />
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

/** Exports the selected recordings: by an address, or, if they are too many for it, by a request. */
function ExportSelected({ behaviour, ids }: { behaviour: Behaviour; ids: readonly number[] }) {
  const toast = useToast();
  const load = useMutation({
    mutationFn: () => fetchExport(behaviour.id, ids),
    onSuccess: (file) => saveFile(file, `${behaviour.slug}.jsonl`),
    onError: (error) => toast(messageOf(error)),
  });
  if (ids.length <= MOST_IN_URL) {
    return (
      <DownloadLink href={exportUrl(behaviour.id, ids)}>
        <Trans>Export selected</Trans>
      </DownloadLink>
    );
  }
  return (
    <Button
      icon="download"
      // Not `disabled`, which would lose the focus.
      aria-disabled={load.isPending}
      onClick={() => {
        if (!load.isPending) load.mutate();
      }}
    >
      {load.isPending ? t`Exporting…` : t`Export selected`}
    </Button>
  );
}

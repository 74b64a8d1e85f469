import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useMutation, useQueryClient } from "@tanstack/react-query";
import { type DragEvent, useEffect, useRef, useState } from "react";

import { messageOf } from "@/api/client";
import { importRecordings } from "@/api/recordings";
import type { ImportResult } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { Checkbox } from "@/components/controls/Field";
import { Notice } from "@/components/feedback/States";
import { useToast } from "@/components/feedback/Toasts";
import { classes } from "@/lib/classes";
import { bytes } from "@/lib/format";

import styles from "./ImportDialog.module.css";

/** Imports recordings from a file and reports which were refused and why. */
export function ImportDialog({
  behaviourId,
  dropped,
  onClose,
}: {
  behaviourId: number;
  /** The file that was dropped on the page, if any. */
  dropped: File | null;
  onClose: () => void;
}) {
  const client = useQueryClient();
  const [file, setFile] = useState<File | null>(dropped);
  const [rank, setRank] = useState(false);
  const [perfect, setPerfect] = useState(false);
  const [over, setOver] = useState(false);
  const toast = useToast();
  const isOpen = useRef(true);
  useEffect(() => {
    isOpen.current = true;
    return () => {
      isOpen.current = false;
    };
  }, []);
  const send = useMutation({
    mutationFn: (chosen: File) => importRecordings(behaviourId, chosen, { rank, perfect }),
    onError: (error) => {
      // It was closed meanwhile, which does not stop what is being sent.
      if (!isOpen.current) toast(messageOf(error));
    },
    onSettled: () => {
      void client.invalidateQueries({ queryKey: ["recordings", behaviourId] });
      void client.invalidateQueries({ queryKey: ["ranking", behaviourId] });
      void client.invalidateQueries({ queryKey: ["behaviours"] });
    },
  });

  function drop(event: DragEvent) {
    event.preventDefault();
    setOver(false);
    const [first] = event.dataTransfer.files;
    if (first) choose(first);
  }

  function choose(chosen: File) {
    setFile(chosen);
    send.reset();
  }

  return (
    <Dialog title={t`Import recordings`} onClose={onClose}>
      <form
        className={styles.form}
        onSubmit={(event) => {
          event.preventDefault();
          if (file) send.mutate(file);
        }}
      >
        {/* Dropping has a keyboard equivalent, the file input. */}
        <div
          className={classes(styles.drop, over && styles.over)}
          onDragOver={(event) => {
            event.preventDefault();
            setOver(true);
          }}
          onDragLeave={() => setOver(false)}
          onDrop={drop}
        >
          <span>
            {file ? `${file.name}, ${bytes(file.size)}` : t`Drop a file here, or choose one.`}
          </span>
          <input
            type="file"
            aria-label={t`File of recordings`}
            accept=".json,.jsonl,.ndjson,application/json"
            onChange={(event) => {
              const chosen = event.currentTarget.files?.[0];
              if (chosen) choose(chosen);
            }}
          />
          <span>
            <Trans>
              One JSON object, or one per line, as the export writes them; or games from elsewhere
              as lists of actions.
            </Trans>
          </span>
        </div>
        <Checkbox
          label={t`The order is a ranking, best first`}
          hint={t`They are put on the board in this order, below what is already ranked.`}
          checked={rank}
          onChange={setRank}
        />
        <Checkbox
          label={t`All of them are perfect`}
          hint={t`The clone is learned from perfect recordings.`}
          checked={perfect}
          onChange={setPerfect}
        />
        {send.error && (
          <Notice tone="bad" live>
            <p>{messageOf(send.error)}</p>
          </Notice>
        )}
        {send.data && <Report result={send.data} />}
        <div className={styles.actions}>
          {send.data ? (
            <Button kind="primary" onClick={onClose}>
              <Trans>Close</Trans>
            </Button>
          ) : (
            <Button kind="primary" type="submit" disabled={!file || send.isPending}>
              {send.isPending ? t`Replaying…` : t`Import`}
            </Button>
          )}
        </div>
      </form>
    </Dialog>
  );
}

function Report({ result }: { result: ImportResult }) {
  const lines = [
    ...result.refusals.map((one) => ({ ...one, refused: true })),
    ...result.notices.map((one) => ({ ...one, refused: false })),
  ].sort((a, b) => a.line - b.line);
  const hidden = result.n_refused + result.n_notices - lines.length;
  return (
    <div className={styles.report} role="status">
      <p>
        <strong>
          <Trans>
            <Plural value={result.imported.length} one="# recording" other="# recordings" />{" "}
            imported
          </Trans>
        </strong>
        {result.already_there.length > 0 && (
          <>
            , <Trans>{result.already_there.length} already there and not imported again</Trans>
          </>
        )}
        {result.n_refused > 0 && (
          <>
            , <Trans>{result.n_refused} refused</Trans>
          </>
        )}
        .
      </p>
      {lines.length > 0 && (
        <table>
          <thead>
            <tr>
              <th scope="col">
                <Trans>Line</Trans>
              </th>
              <th scope="col">
                <Trans>What happened</Trans>
              </th>
            </tr>
          </thead>
          <tbody>
            {lines.map((one, index) => (
              <tr key={`${one.line}-${index}`}>
                <td className={styles.line}>{one.line}</td>
                <td>{one.refused ? t`Refused: ${one.reason}` : t`Imported, but: ${one.reason}`}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {hidden > 0 && (
        <p>
          <Plural value={hidden} one="And # more line." other="And # more lines." />
        </p>
      )}
    </div>
  );
}

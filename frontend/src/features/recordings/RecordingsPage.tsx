import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { type DragEvent, useState } from "react";
import { Link, useSearchParams } from "react-router";

import { useLibrary } from "@/api/library";
import type { Behaviour, Recording } from "@/api/types";
import { Button, ButtonLink } from "@/components/controls/Button";
import { Empty, Failed, Loading } from "@/components/feedback/States";
import { WatchDialog } from "@/components/recording/WatchDialog";
import { useOnlyPlays } from "@/components/people/use-only-plays";
import { readFilter } from "@/features/recordings/library/filter";
import { ImportDialog } from "@/features/recordings/library/ImportDialog";
import { Library } from "@/features/recordings/library/Library";
import { useGame } from "@/games/game";

/** The recordings of a behaviour: watch, mark, annotate, delete, import, export. */
export function RecordingsPage({ behaviour }: { behaviour: Behaviour }) {
  const { entries, isWhole, error, refetch } = useLibrary(behaviour.id);
  const [search] = useSearchParams();
  const asksForDeleted = readFilter(search).show === "deleted";
  const [watched, setWatched] = useState<Recording | null>(null);
  const [importing, setImporting] = useState<{ dropped: File | null } | null>(null);

  const onImport = useOnlyPlays() ? undefined : () => setImporting({ dropped: null });

  function drop(event: DragEvent) {
    const [file] = event.dataTransfer.files;
    if (!file || !onImport) return;
    event.preventDefault();
    setImporting({ dropped: file });
  }

  if (error && !isWhole) {
    return <Failed what={t`The recordings`} error={error} onRetry={() => void refetch()} />;
  }
  if (!entries) return <Loading what={t`the recordings`} rows={2} height="18rem" />;
  return (
    // Dropping a file has a keyboard equivalent, the Import button.
    <div onDragOver={(event) => event.preventDefault()} onDrop={drop}>
      {entries.length === 0 && !asksForDeleted ? (
        <NoRecordings behaviour={behaviour} onImport={onImport} />
      ) : (
        <Library
          recordings={entries}
          isWhole={isWhole}
          behaviour={behaviour}
          onWatch={setWatched}
          onImport={onImport}
        />
      )}
      {watched && (
        <WatchDialog recording={watched} behaviour={behaviour} onClose={() => setWatched(null)} />
      )}
      {importing && (
        <ImportDialog
          behaviourId={behaviour.id}
          dropped={importing.dropped}
          onClose={() => setImporting(null)}
        />
      )}
    </div>
  );
}

function NoRecordings({
  behaviour,
  onImport,
}: {
  behaviour: Behaviour;
  onImport: (() => void) | undefined;
}) {
  const { picture_url: picture } = useGame();
  return (
    <Empty
      title={t`No recordings yet`}
      picture={picture}
      actions={
        <>
          <ButtonLink kind="primary" to={`/behaviours/${behaviour.id}/play`}>
            <Trans>Play a game</Trans>
          </ButtonLink>
          {onImport && (
            <Button icon="upload" onClick={onImport}>
              <Trans>Import recordings</Trans>
            </Button>
          )}
        </>
      }
    >
      <p>
        <Trans>
          Games that you play and keep are collected here. The imitator learns from the differences
          between them, so play bad ones too.
        </Trans>
      </p>
      <p>
        <Link to="?show=deleted">
          <Trans>Deleted recordings</Trans>
        </Link>
      </p>
    </Empty>
  );
}

import { useQuery } from "@tanstack/react-query";
import { type DragEvent, useState } from "react";

import { ImportDialog } from "./ImportDialog";
import { RecordingCard } from "./RecordingCard";
import styles from "./RecordingsPage.module.css";

import { exportUrl, recordingsQuery } from "@/api/recordings";
import type { Behaviour, Recording } from "@/api/types";
import buttonStyles from "@/components/Button.module.css";
import { Button, ButtonLink } from "@/components/Button";
import { Icon } from "@/components/Icon";
import { Empty, Failed, Loading } from "@/components/States";
import { WatchDialog } from "@/components/WatchDialog";
import { count } from "@/lib/format";

const FILTERS = {
  all: { name: "All", fits: () => true },
  perfect: { name: "Perfect ones", fits: (one: Recording) => one.perfect },
  unranked: { name: "Not ranked yet", fits: (one: Recording) => !one.ranked },
  person: { name: "Played by a person", fits: (one: Recording) => one.source === "person" },
  unverified: {
    name: "Not verified",
    fits: (one: Recording) => one.verification !== "verified",
  },
} as const;
type FilterName = keyof typeof FILTERS;

/** All recordings of a behaviour: watch, mark, note, delete, import, export. */
export function RecordingsPage({ behaviour }: { behaviour: Behaviour }) {
  const { data, error, refetch } = useQuery(recordingsQuery(behaviour.id));
  const [watched, setWatched] = useState<Recording | null>(null);
  const [importing, setImporting] = useState<{ dropped: File | null } | null>(null);

  function drop(event: DragEvent) {
    const [file] = event.dataTransfer.files;
    if (!file) return;
    event.preventDefault();
    setImporting({ dropped: file });
  }

  if (error && !data) {
    return <Failed what="The recordings" error={error} onRetry={() => void refetch()} />;
  }
  if (!data) return <Loading what="the recordings" rows={2} height="18rem" />;
  return (
    // Dropping a file anywhere is beside the Import button, which does the same by key.
     
    <div onDragOver={(event) => event.preventDefault()} onDrop={drop}>
      {data.length === 0 ? (
        <NoRecordings behaviour={behaviour} onImport={() => setImporting({ dropped: null })} />
      ) : (
        <Library
          recordings={data}
          behaviour={behaviour}
          onWatch={setWatched}
          onImport={() => setImporting({ dropped: null })}
        />
      )}
      {watched && (
        <WatchDialog
          recording={watched}
          nTargets={behaviour.target?.length ?? null}
          onClose={() => setWatched(null)}
        />
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

function Library({
  recordings,
  behaviour,
  onWatch,
  onImport,
}: {
  recordings: readonly Recording[];
  behaviour: Behaviour;
  onWatch: (recording: Recording) => void;
  onImport: () => void;
}) {
  const [filter, setFilter] = useState<FilterName>("all");
  const shown = recordings.filter(FILTERS[filter].fits);
  return (
    <>
      <div className={styles.bar}>
        <h2>{count(recordings.length, "recording")}</h2>
        <label>
          <span className="visually-hidden">Show</span>
          <select
            className={styles.filter}
            value={filter}
            onChange={(event) => setFilter(event.currentTarget.value as FilterName)}
          >
            {Object.entries(FILTERS).map(([key, { name }]) => (
              <option key={key} value={key}>
                {name}
              </option>
            ))}
          </select>
        </label>
        <Button icon="upload" onClick={onImport}>
          Import
        </Button>
        <a className={buttonStyles.button} href={exportUrl(behaviour.id)} download>
          <Icon name="download" />
          Export
        </a>
      </div>
      {shown.length === 0 ? (
        <p>None of the recordings is like that.</p>
      ) : (
        <ul className={styles.cards}>
          {shown.map((recording) => (
            <li key={recording.id}>
              <RecordingCard recording={recording} behaviour={behaviour} onWatch={onWatch} />
            </li>
          ))}
        </ul>
      )}
    </>
  );
}

function NoRecordings({ behaviour, onImport }: { behaviour: Behaviour; onImport: () => void }) {
  return (
    <Empty
      title="No recordings yet"
      actions={
        <>
          <ButtonLink kind="primary" to={`/behaviours/${behaviour.id}/play`}>
            Play a game
          </ButtonLink>
          <Button icon="upload" onClick={onImport}>
            Import recordings
          </Button>
        </>
      }
    >
      <p>
        Games that you play and keep are collected here. An agent learns from the differences
        between them, so play bad ones too.
      </p>
    </Empty>
  );
}

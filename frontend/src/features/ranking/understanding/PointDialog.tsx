import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useLayoutEffect, useRef, useState } from "react";

import type { Meaning, NamedThing, NamedThings } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { Failed, Loading } from "@/components/feedback/States";
import { classes } from "@/lib/classes";
import { useRecordingName } from "@/features/ranking/recording-names";

import styles from "./PointDialog.module.css";
import { Sight } from "./Sight";
import { ThingNameForm } from "./ThingNameForm";
import { thingsQuery } from "./things";

interface PointDialogProps {
  behaviourId: number;
  /** The ranked games, best first. */
  recordingIds: readonly number[];
  onMean: (meaning: Meaning) => void;
  onClose: () => void;
}

/** Lets a person point at a thing in a game, and say what of it makes a game better. */
export function PointDialog({ behaviourId, recordingIds, onMean, onClose }: PointDialogProps) {
  const { data, error, refetch } = useQuery(thingsQuery(behaviourId));
  return (
    <Dialog title={t`Point at what you mean`} onClose={onClose} width="60rem">
      {data ? (
        <Pointing
          behaviourId={behaviourId}
          recordingIds={recordingIds}
          named={data}
          onMean={onMean}
        />
      ) : error ? (
        <Failed
          what={t`What Tril sees in this game`}
          error={error}
          onRetry={() => void refetch()}
        />
      ) : (
        <Loading what={t`what Tril sees in this game`} rows={1} height="20rem" />
      )}
    </Dialog>
  );
}

interface PointingProps extends Omit<PointDialogProps, "onClose"> {
  named: NamedThings;
}

function Pointing({ behaviourId, recordingIds, named, onMean }: PointingProps) {
  const [recordingId, setRecordingId] = useState(recordingIds[0] ?? 0);
  const [pointed, setPointed] = useState<number | null>(null);
  const [chosen, setChosen] = useState<number | null>(null);
  const nameOf = useRecordingName();
  const thing = named.things.find(({ kind }) => kind === chosen);
  return (
    <div className={styles.pointing}>
      <div className={styles.game}>
        <label className={styles.choice}>
          <Trans>Game</Trans>
          <select
            value={recordingId}
            onChange={(event) => setRecordingId(Number(event.currentTarget.value))}
          >
            {recordingIds.map((id) => (
              <option key={id} value={id}>
                {nameOf(id)}
              </option>
            ))}
          </select>
        </label>
        <Sight
          key={recordingId}
          behaviourId={behaviourId}
          recordingId={recordingId}
          things={named.things}
          marked={pointed ?? chosen}
          onPoint={setPointed}
          onChoose={setChosen}
        />
      </div>
      {thing ? (
        <Meanings
          key={thing.kind}
          behaviourId={behaviourId}
          thing={thing}
          onMean={onMean}
          onBack={() => setChosen(null)}
        />
      ) : (
        <Things
          named={named}
          marked={pointed}
          onPoint={setPointed}
          onChoose={setChosen}
          onMean={onMean}
        />
      )}
    </div>
  );
}

interface ThingsProps {
  named: NamedThings;
  marked: number | null;
  onPoint: (kind: number | null) => void;
  onChoose: (kind: number) => void;
  onMean: (meaning: Meaning) => void;
}

function Things({ named, marked, onPoint, onChoose, onMean }: ThingsProps) {
  return (
    <div className={styles.words}>
      <p>
        <Trans>
          Point at a thing in the picture, or choose it here. You can give it a name, too.
        </Trans>
      </p>
      <ul className={styles.things} aria-label={t`Things in the game`}>
        {named.things.map(({ kind, name, picture }) => (
          <li key={kind}>
            <button
              type="button"
              className={classes(styles.thing, kind === marked && styles.marked)}
              onMouseEnter={() => onPoint(kind)}
              onMouseLeave={() => onPoint(null)}
              onFocus={() => onPoint(kind)}
              onBlur={() => onPoint(null)}
              onClick={() => onChoose(kind)}
            >
              {picture ? <img src={picture} alt="" /> : <span className={styles.unseen} />}
              {name}
            </button>
          </li>
        ))}
      </ul>
      <h3>
        <Trans>Something else</Trans>
      </h3>
      <MeaningList label={t`Something else`} meanings={named.others} onMean={onMean} />
    </div>
  );
}

interface MeaningsProps {
  behaviourId: number;
  thing: NamedThing;
  onMean: (meaning: Meaning) => void;
  onBack: () => void;
}

/** What of a thing may be meant. */
function Meanings({ behaviourId, thing, onMean, onBack }: MeaningsProps) {
  const { name, picture, meanings } = thing;
  const title = useRef<HTMLHeadingElement>(null);
  const [naming, setNaming] = useState(false);
  // What had the focus is gone.
  useLayoutEffect(() => title.current?.focus(), []);
  return (
    <div className={styles.words}>
      <div>
        <Button kind="quiet" icon="arrowLeft" onClick={onBack}>
          <Trans>Another thing</Trans>
        </Button>
      </div>
      <div className={styles.chosen}>
        {picture && <img src={picture} alt="" />}
        <h3 ref={title} tabIndex={-1}>
          {name}
        </h3>
        {!naming && (
          <Button kind="quiet" icon="edit" onClick={() => setNaming(true)}>
            {thing.given === null ? <Trans>Give it a name</Trans> : <Trans>Rename</Trans>}
          </Button>
        )}
      </div>
      {naming && (
        <ThingNameForm
          behaviourId={behaviourId}
          thing={thing}
          onClose={() => {
            setNaming(false);
            title.current?.focus();
          }}
        />
      )}
      <p>
        <Trans>What about it makes a game better? Your order says in which direction.</Trans>
      </p>
      <MeaningList label={t`What you mean about it`} meanings={meanings} onMean={onMean} />
    </div>
  );
}

interface MeaningListProps {
  label: string;
  meanings: readonly Meaning[];
  onMean: (meaning: Meaning) => void;
}

function MeaningList({ label, meanings, onMean }: MeaningListProps) {
  return (
    <ul className={styles.meanings} aria-label={label}>
      {meanings.map((meaning) => (
        <li key={meaning.subjects.join()}>
          <Button onClick={() => onMean(meaning)}>{meaning.sentence}</Button>
        </li>
      ))}
    </ul>
  );
}

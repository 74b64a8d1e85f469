import type { ReactNode } from "react";

import type { Behaviour, Recording } from "@/api/types";
import { IconButton } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { AlienGrid } from "@/components/game/AlienGrid";
import { RecordingScreen, useLookedAt } from "@/components/recording/RecordingScreen";
import { SourceBadge } from "@/components/recording/SourceBadge";
import { classes } from "@/lib/classes";
import { courseInWords, hitCells, recordingName, scoreInWords } from "@/lib/recordings";

import { useDragItem } from "./DragBoard";
import styles from "./RankCard.module.css";

export type Move = "up" | "down" | "join" | "new" | "tray";

interface RankCardProps {
  recording: Recording;
  behaviour: Behaviour;
  /** The place it is in, for the arrow keys to begin at. */
  place: string;
  ranked: boolean;
  looked: boolean;
  /** Whether it plays in the card itself, where there is no room for a preview beside. */
  unfolded: boolean;
  /** Moves that would change something. */
  possible: ReadonlySet<Move>;
  onMove: (move: Move) => void;
  onPerfect: () => void;
  onLook: () => void;
}

const SCREEN = { width: 320, height: 210 } as const;

/** A recording on the board: dragged, or moved by its buttons. */
export function RankCard(props: RankCardProps) {
  const { recording, behaviour, place, looked, unfolded, onLook } = props;
  const { setItem, setHandle, listeners, descriptionId, isDragging } = useDragItem(
    String(recording.id),
    place,
  );
  const [, look] = useLookedAt(onLook);
  const name = recordingName(recording);
  return (
    // A finger's tap shows it in the preview, as the focus of its buttons does by key.
    // eslint-disable-next-line jsx-a11y/click-events-have-key-events, jsx-a11y/no-noninteractive-element-interactions
    <article
      ref={setItem}
      aria-label={name}
      data-recording={recording.id}
      className={classes(styles.card, looked && styles.looked, isDragging && styles.lifted)}
      onClick={onLook}
      {...look}
      {...listeners}
    >
      <button
        type="button"
        className={styles.handle}
        aria-label={`Move ${name}`}
        title="Drag, or press space and use the arrow keys"
        ref={setHandle}
        aria-describedby={descriptionId}
        aria-roledescription="movable"
      >
        <Icon name="grip" />
      </button>
      <Facts recording={recording} behaviour={behaviour} />
      <Buttons {...props} name={name} />
      {unfolded && (
        <div className={styles.screen}>
          <RecordingScreen recording={recording} playing {...SCREEN} />
        </div>
      )}
    </article>
  );
}

/** What a card says, also while it is dragged. */
export function CardBody({ recording, behaviour }: { recording: Recording; behaviour: Behaviour }) {
  return (
    <div className={styles.card}>
      <span className={styles.handle}>
        <Icon name="grip" />
      </span>
      <Facts recording={recording} behaviour={behaviour} />
    </div>
  );
}

function Facts({
  recording,
  behaviour,
}: {
  recording: Recording;
  behaviour: Behaviour;
}): ReactNode {
  return (
    <>
      <AlienGrid hits={hitCells(recording)} target={behaviour.target} label="" />
      <div className={styles.words}>
        <div className={styles.title}>
          <h3>{recordingName(recording)}</h3>
          <SourceBadge recording={recording} />
        </div>
        <span>{scoreInWords(recording, behaviour.target?.length ?? null)}</span>
        <span className={styles.quiet}>{courseInWords(recording)}</span>
      </div>
    </>
  );
}

function Buttons({
  recording,
  ranked,
  possible,
  onMove,
  onPerfect,
  name,
}: RankCardProps & { name: string }) {
  const moves = ranked
    ? ([
        ["up", "up", "Up"],
        ["down", "down", "Down"],
        ["join", "equal", "Tie with the tier above"],
        ["new", "newTier", "Own tier"],
        ["tray", "tray", "Back to unranked"],
      ] as const)
    : ([
        ["up", "up", "Rank as best"],
        ["new", "down", "Rank as worst"],
      ] as const);
  return (
    <div className={styles.buttons} role="group" aria-label={`Moves of ${name}`}>
      <IconButton
        icon="star"
        filled={recording.perfect}
        className={styles.star}
        label={
          recording.perfect ? `${name} is perfect. Take the mark off` : `Mark ${name} as perfect`
        }
        aria-pressed={recording.perfect}
        onClick={onPerfect}
      />
      {moves.map(([move, icon, label]) => (
        <IconButton
          key={move}
          icon={icon}
          data-move={move}
          label={`${label}: ${name}`}
          // Stays focusable when it has nothing more to do: the focus must not get lost.
          aria-disabled={!possible.has(move)}
          onClick={() => {
            if (possible.has(move)) onMove(move);
          }}
        />
      ))}
    </div>
  );
}

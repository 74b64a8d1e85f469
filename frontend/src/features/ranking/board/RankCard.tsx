import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import type { ReactNode, SyntheticEvent } from "react";

import type { Behaviour, Recording } from "@/api/types";
import { IconButton } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { Badge } from "@/components/feedback/Badge";
import { ItemGrid } from "@/components/game/ItemGrid";
import { GamePicture, LOOPS } from "@/components/recording/GamePicture";
import { SourceBadge } from "@/components/recording/SourceBadge";
import { RunName } from "@/components/RunName";
import { RecordingScreen, useHover } from "@/features/ranking/RecordingScreen";
import { useGame } from "@/games/game";
import { describeCourse, describeResult } from "@/games/outcomes";
import { classes } from "@/lib/classes";
import { takenCells } from "@/lib/game/items";
import { recordingName } from "@/lib/recordings";

import { useDragItem } from "./DragBoard";
import styles from "./RankCard.module.css";

export type Move = "up" | "down" | "join" | "new" | "tray";

interface RankCardProps {
  recording: Recording;
  behaviour: Behaviour;
  /** The place it is in, where the arrow keys start. */
  place: string;
  ranked: boolean;
  previewed: boolean;
  /** Whether it plays inside the card, for want of a preview beside the board. */
  unfolded: boolean;
  /** Moves that would change something. */
  possible: ReadonlySet<Move>;
  onMove: (move: Move) => void;
  selected: boolean;
  onSelect: (selected: boolean) => void;
  onPerfect: () => void;
  onGiveBack: () => void;
  onPreview: () => void;
  opinion: ReactNode;
}

const SCREEN = { width: 320, height: 210 } as const;

/** A recording on the board: dragged, or moved by its buttons. */
export function RankCard(props: RankCardProps) {
  const { recording, behaviour, place, selected, previewed, unfolded, onSelect, onPreview } = props;
  const { setItem, setHandle, listeners, descriptionId, isDragging } = useDragItem(
    String(recording.id),
    place,
  );
  const hover = useHover(onPreview);
  const name = recordingName(recording);
  return (
    // A tap shows it in the preview; focusing its buttons does the same by keyboard.
    // eslint-disable-next-line jsx-a11y/click-events-have-key-events, jsx-a11y/no-noninteractive-element-interactions
    <article
      ref={setItem}
      aria-label={name}
      data-recording={recording.id}
      className={classes(
        styles.card,
        previewed && styles.previewed,
        selected && styles.selected,
        isDragging && styles.lifted,
      )}
      {...hover}
      onClick={outsideDetails(onPreview)}
      onFocus={outsideDetails(hover.onFocus)}
      {...listeners}
      {...LOOPS}
    >
      <button
        type="button"
        className={styles.handle}
        aria-label={t`Move ${name}`}
        title={t`Drag, or press space and use the arrow keys`}
        ref={setHandle}
        aria-describedby={descriptionId}
        aria-roledescription={t`movable`}
      >
        <Icon name="grip" />
      </button>
      <Facts recording={recording} behaviour={behaviour}>
        <input
          type="checkbox"
          className={styles.select}
          aria-label={t`Select ${name}`}
          checked={selected}
          onChange={(event) => onSelect(event.currentTarget.checked)}
          // Selecting is not a wish to see it.
          onClick={(event) => event.stopPropagation()}
        />
      </Facts>
      {props.opinion}
      <Buttons {...props} name={name} />
      {unfolded && (
        <div className={styles.screen}>
          <RecordingScreen recording={recording} playing {...SCREEN} />
        </div>
      )}
    </article>
  );
}

/** Does nothing on events in what unfolds: to read a contradiction is not a wish to see the game. */
function outsideDetails(act: () => void): (event: SyntheticEvent) => void {
  return ({ target }) => {
    if (!(target instanceof Element && target.closest("details"))) act();
  };
}

/** The card as it is shown while dragged. */
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
  children,
}: {
  recording: Recording;
  behaviour: Behaviour;
  children?: ReactNode;
}): ReactNode {
  const game = useGame();
  const result = describeResult(recording, behaviour, game);
  return (
    <>
      <div className={styles.pictures}>
        <GamePicture recording={recording} />
        <ItemGrid hits={takenCells(recording)} target={behaviour.target} label="" />
      </div>
      <div className={styles.words}>
        <div className={styles.title}>
          {children}
          <h3>{recordingName({ ...recording, borrowed: false })}</h3>
          <SourceBadge recording={recording} />
          {recording.borrowed && <Origin recording={recording} />}
        </div>
        {result && <span>{result}</span>}
        <span className={styles.quiet}>{describeCourse(recording, game)}</span>
      </div>
    </>
  );
}

/** Where a borrowed game comes from: a run whose policy played it, or another behaviour. */
function Origin({ recording: { run_id: runId, behaviour_name: name } }: { recording: Recording }) {
  const title = runId
    ? t`A game of a run’s imitator or clone, borrowed for this ranking.`
    : t`A game of another behaviour, borrowed for this ranking.`;
  return (
    <Badge icon="tray" title={title}>
      {runId ? (
        <Trans>
          from <RunName id={runId} />
        </Trans>
      ) : (
        <Trans>from {name}</Trans>
      )}
    </Badge>
  );
}

function Buttons({
  recording,
  ranked,
  possible,
  onMove,
  onPerfect,
  onGiveBack,
  name,
}: RankCardProps & { name: string }) {
  const moves = ranked
    ? ([
        ["up", "up", t`Up`],
        ["down", "down", t`Down`],
        ["join", "equal", t`Tie with the tier above`],
        ["new", "newTier", t`Own tier`],
        ["tray", "tray", t`Back to unranked`],
      ] as const)
    : ([
        ["up", "up", t`Rank as best`],
        ["new", "down", t`Rank as worst`],
      ] as const);
  return (
    <div className={styles.buttons} role="group" aria-label={t`Moves of ${name}`}>
      {!recording.borrowed && (
        <IconButton
          icon="star"
          filled={recording.perfect}
          className={styles.star}
          label={
            recording.perfect ? t`${name} is perfect. Remove the mark` : t`Mark ${name} as perfect`
          }
          aria-pressed={recording.perfect}
          onClick={onPerfect}
        />
      )}
      {moves.map(([move, icon, label]) => (
        <IconButton
          key={move}
          icon={icon}
          data-move={move}
          label={`${label}: ${name}`}
          // Not `disabled`, which would lose the focus.
          aria-disabled={!possible.has(move)}
          onClick={() => {
            if (possible.has(move)) onMove(move);
          }}
        />
      ))}
      {recording.borrowed && !ranked && (
        <IconButton icon="close" label={t`Give back: ${name}`} onClick={onGiveBack} />
      )}
    </div>
  );
}

import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { type ReactNode } from "react";

import type { Behaviour, Recording } from "@/api/types";
import {
  isTied,
  joinAbove,
  moveDown,
  moveUp,
  newTier,
  place,
  tierOf,
  type Tiers,
} from "@/features/ranking/order/order";
import { classes } from "@/lib/classes";

import styles from "./Board.module.css";
import { useDropPlace } from "./DragBoard";
import { gapPlace, tierPlace, TRAY } from "./places";
import { type Move, RankCard } from "./RankCard";

interface BoardProps {
  tiers: Tiers;
  recordings: ReadonlyMap<number, Recording>;
  behaviour: Behaviour;
  previewed: number | null;
  /** Whether the page is too narrow for a preview beside the board. */
  narrow: boolean;
  onPreview: (id: number) => void;
  onMove: (id: number, move: Move) => void;
  selected: ReadonlySet<number>;
  onSelect: (id: number, selected: boolean) => void;
  onPerfect: (recording: Recording) => void;
  onGiveBack: (recording: Recording) => void;
  /** Shows what else there is to say of a recording. */
  renderOpinion: (id: number) => ReactNode;
}

/** Applies a card's button to the order. */
export function applyMove(tiers: Tiers, id: number, move: Move): Tiers {
  switch (move) {
    case "up":
      return tierOf(tiers, id) < 0
        ? place(tiers, id, { kind: "gap", before: 0 })
        : moveUp(tiers, id);
    case "down":
      return moveDown(tiers, id);
    case "join":
      return joinAbove(tiers, id);
    case "new":
      return newTier(tiers, id);
    case "tray":
      return place(tiers, id, { kind: "tray" });
  }
}

/** Returns the moves that would change something for a recording. */
function possibleMoves(tiers: Tiers, id: number): ReadonlySet<Move> {
  const at = tierOf(tiers, id);
  if (at < 0) return new Set<Move>(["up", "new"]);
  const tied = isTied(tiers, id);
  const moves: Move[] = ["tray"];
  if (tied || at > 0) moves.push("up");
  if (tied || at < tiers.length - 1) moves.push("down");
  if (at > 0) moves.push("join");
  if (tied) moves.push("new");
  return new Set(moves);
}

/** The tiers, best first. */
export function Board(props: BoardProps) {
  const { tiers } = props;
  if (tiers.length === 0) return <EmptyBoard />;
  return (
    <>
      <ol className={styles.tiers} aria-label={t`Tiers, best first`}>
        {tiers.map((tier, index) => (
          <li
            // Keyed by its content, so that cards keep the focus when the tier moves.
            key={`of-${Math.min(...tier)}`}
            aria-label={t`Tier ${index + 1} of ${tiers.length}, ${plural(tier.length, { one: "# recording", other: "# recordings" })}`}
          >
            <Gap below={tier} />
            <Tier {...props} tier={tier} index={index} />
          </li>
        ))}
      </ol>
      <LastGap />
    </>
  );
}

function EmptyBoard() {
  const { setPlace, isOver } = useDropPlace(gapPlace());
  return (
    <div ref={setPlace} className={classes(styles.empty, isOver && styles.over)}>
      <p>
        <Trans>
          Drag recordings here, the best to the top. Drop one on another to call it a tie, between
          two to put it between them.
        </Trans>
      </p>
    </div>
  );
}

/** Between a tier and the one above it. */
function Gap({ below }: { below: readonly number[] }) {
  const { setPlace, isOver } = useDropPlace(gapPlace(below));
  return <div ref={setPlace} className={classes(styles.gap, isOver && styles.gapOver)} />;
}

/** Below the last tier there is room to drop. */
function LastGap() {
  const { setPlace, isOver } = useDropPlace(gapPlace());
  return (
    <div ref={setPlace} className={classes(styles.lastGap, isOver && styles.over)}>
      <Trans>Drop below the last tier to make a new one</Trans>
    </div>
  );
}

function Tier(props: BoardProps & { tier: readonly number[]; index: number }) {
  const { tiers, tier, index } = props;
  const name = tierPlace(tier);
  const { setPlace, isOver } = useDropPlace(name);
  return (
    <div ref={setPlace} className={classes(styles.tier, isOver && styles.over)}>
      <span className={styles.number} aria-hidden="true">
        {index + 1}
        {index === 0 && (
          <small>
            <Trans>best</Trans>
          </small>
        )}
        {index === tiers.length - 1 && index > 0 && (
          <small>
            <Trans>worst</Trans>
          </small>
        )}
      </span>
      <div className={styles.cards}>{tier.map((id) => cardOf(props, id, name))}</div>
    </div>
  );
}

/** Leads to the unranked recordings, wherever on the page they are. */
export function focusTray(): void {
  document.querySelector<HTMLElement>("[data-tray]")?.focus();
}

/** The unranked recordings, between ways to place many of them and to get more. */
export function Tray(
  props: BoardProps & { unranked: readonly number[]; above: ReactNode; below: ReactNode },
) {
  const { unranked, above, below } = props;
  const { setPlace, isOver } = useDropPlace(TRAY);
  return (
    <section
      ref={setPlace}
      className={classes(styles.tray, isOver && styles.over)}
      aria-label={t`Unranked, ${plural(unranked.length, { one: "# recording", other: "# recordings" })}`}
    >
      <h3 data-tray tabIndex={-1}>
        <Trans>Unranked ({unranked.length})</Trans>
      </h3>
      {above}
      {unranked.length === 0 ? (
        <p className={styles.trayEmpty}>
          <Trans>All recordings are ranked.</Trans>
        </p>
      ) : (
        unranked.map((id) => cardOf(props, id, TRAY))
      )}
      {below}
    </section>
  );
}

function cardOf(props: BoardProps, id: number, placeName: string): ReactNode {
  const { tiers, recordings, behaviour, previewed, narrow, selected } = props;
  const { onPreview, onMove, onSelect, onPerfect, onGiveBack, renderOpinion } = props;
  const recording = recordings.get(id);
  if (!recording) return null;
  return (
    <div key={id}>
      <RankCard
        recording={recording}
        behaviour={behaviour}
        place={placeName}
        ranked={placeName !== TRAY}
        previewed={previewed === id}
        unfolded={previewed === id && narrow}
        possible={possibleMoves(tiers, id)}
        onMove={(move) => onMove(id, move)}
        selected={selected.has(id)}
        onSelect={(on) => onSelect(id, on)}
        onPerfect={() => onPerfect(recording)}
        onGiveBack={() => onGiveBack(recording)}
        onPreview={() => onPreview(id)}
        opinion={renderOpinion(id)}
      />
    </div>
  );
}

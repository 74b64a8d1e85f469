import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { memo, type ReactNode, useCallback, useMemo, useState } from "react";

import type { Behaviour, LibraryEntry, Recording } from "@/api/types";
import { ScrolledList } from "@/components/list/VirtualList";
import {
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
import { useDragged, useDropPlace } from "./DragBoard";
import { gapPlace, tierPlace, TRAY } from "./places";
import type { Move } from "./RankCard";
import { ShownCard } from "./ShownCard";

interface BoardProps {
  tiers: Tiers;
  recordings: ReadonlyMap<number, LibraryEntry>;
  /** Whether these are all. */
  isWhole: boolean;
  behaviour: Behaviour;
  previewed: number | null;
  /** The recording that was moved last. */
  moved: number | null;
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

/** The tiers, best first. */
export function Board(props: BoardProps) {
  const { tiers } = props;
  if (tiers.length === 0) return <EmptyBoard />;
  return (
    <>
      <ol className={styles.tiers} aria-label={t`Tiers, best first`}>
        {tiers.map((tier, index) => (
          // Keyed by its content, so that cards keep the focus when the tier moves.
          <Tier key={`of-${Math.min(...tier)}`} {...props} tier={tier} index={index} />
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
const Gap = memo(function Gap({ below }: { below: readonly number[] }) {
  const { setPlace, isOver } = useDropPlace(gapPlace(below));
  return <div ref={setPlace} className={classes(styles.gap, isOver && styles.gapOver)} />;
});

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
  const [n, of] = [tier.length, tiers.length];
  const label = useMemo(
    () =>
      t`Tier ${index + 1} of ${of}, ${plural(n, { one: "# recording", other: "# recordings" })}`,
    [index, of, n],
  );
  return (
    <li aria-label={label}>
      <Gap below={tier} />
      <div ref={setPlace} className={classes(styles.tier, isOver && styles.over)}>
        <span className={styles.number} aria-hidden="true">
          {index + 1}
          {index === 0 && (
            <small>
              <Trans>best</Trans>
            </small>
          )}
          {index === of - 1 && index > 0 && (
            <small>
              <Trans>worst</Trans>
            </small>
          )}
        </span>
        <div className={styles.cards}>{tier.map((id) => cardOf(props, id, name))}</div>
      </div>
    </li>
  );
}

/** Above so many unranked recordings, what stands below them would not be found. */
const LONG = 24;
/** About as high as a card is. */
const CARD_PX = 110;
const GAP_PX = 8;

/** Leads to the unranked recordings, wherever on the page they are. */
export function focusTray(): void {
  document.querySelector<HTMLElement>("[data-tray]")?.focus();
}

/** The unranked recordings, between ways to place many of them and to get more. */
export function Tray(
  props: BoardProps & {
    unranked: readonly number[];
    /** How many there are, more than those while these are the newest. */
    nUnranked: number;
    above: ReactNode;
    below: ReactNode;
  },
) {
  const { unranked, nUnranked, above, below, moved } = props;
  const { setPlace, isOver } = useDropPlace(TRAY);
  const [scroller, setScroller] = useState<HTMLElement | null>(null);
  const setTray = useCallback(
    (element: HTMLElement | null) => {
      setScroller(element);
      setPlace(element);
    },
    [setPlace],
  );
  const dragged = useDragged();
  const pinned = useMemo(() => [moved, dragged].filter((id) => id !== null), [moved, dragged]);
  const isLong = nUnranked > LONG;
  return (
    <section
      ref={setTray}
      className={classes(styles.tray, isLong && styles.long, isOver && styles.over)}
      aria-label={t`Unranked, ${plural(nUnranked, { one: "# recording", other: "# recordings" })}`}
    >
      <h3 data-tray tabIndex={-1}>
        <Trans>Unranked ({nUnranked})</Trans>
      </h3>
      {above}
      {isLong && below}
      {nUnranked === 0 ? (
        <p className={styles.trayEmpty}>
          <Trans>All recordings are ranked.</Trans>
        </p>
      ) : (
        <ScrolledList
          label={t`Unranked recordings`}
          ids={unranked}
          scroller={scroller}
          rowPx={CARD_PX}
          gapPx={GAP_PX}
          className={undefined}
          pinned={pinned}
          renderItem={(id) => cardOf(props, id, TRAY)}
        />
      )}
      {!isLong && below}
    </section>
  );
}

function cardOf(props: BoardProps, id: number, placeName: string): ReactNode {
  const { tiers, recordings, isWhole, behaviour, previewed, narrow, selected, moved } = props;
  const { onPreview, onMove, onSelect, onPerfect, onGiveBack, renderOpinion } = props;
  if (isWhole && !recordings.has(id)) return null;
  return (
    <div key={id} className={styles.item}>
      <ShownCard
        recordingId={id}
        pinned={moved === id || placeName === TRAY}
        behaviour={behaviour}
        place={placeName}
        ranked={placeName !== TRAY}
        previewed={previewed === id}
        unfolded={previewed === id && narrow}
        tiers={tiers}
        onMove={onMove}
        selected={selected.has(id)}
        onSelect={onSelect}
        onPerfect={onPerfect}
        onGiveBack={onGiveBack}
        onPreview={onPreview}
        renderOpinion={renderOpinion}
      />
    </div>
  );
}

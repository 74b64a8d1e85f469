import { useQuery } from "@tanstack/react-query";
import {
  type ComponentProps,
  memo,
  type ReactNode,
  type RefObject,
  useEffect,
  useRef,
  useState,
} from "react";

import { shownQuery } from "@/api/library";
import type { Behaviour, Recording } from "@/api/types";
import { Failed } from "@/components/feedback/States";
import { isTied, tierOf, type Tiers } from "@/features/ranking/order/order";
import { useRecordingName } from "@/features/ranking/recording-names";

import { useDragged } from "./DragBoard";
import { CardBody, type Move, RankCard } from "./RankCard";
import styles from "./ShownCard.module.css";

interface ShownCardProps extends Pick<
  ComponentProps<typeof RankCard>,
  "behaviour" | "place" | "ranked" | "previewed" | "unfolded" | "selected"
> {
  recordingId: number;
  tiers: Tiers;
  /** Whether it is laid out even out of sight. */
  pinned: boolean;
  onPreview: (id: number) => void;
  onMove: (id: number, move: Move) => void;
  onSelect: (id: number, selected: boolean) => void;
  onPerfect: (recording: Recording) => void;
  onGiveBack: (recording: Recording) => void;
  /** Shows what else there is to say of a recording. */
  renderOpinion: (id: number) => ReactNode;
}

/**
 * A card on the board; far out of sight only its place is kept. Memoized: a board has hundreds, of
 * which a selection or a preview changes one.
 */
export const ShownCard = memo(function ShownCard({ pinned, ...card }: ShownCardProps) {
  const { recordingId } = card;
  const place = useRef<HTMLDivElement>(null);
  const { near, height } = useNear(place);
  const [focused, setFocused] = useState(false);
  const dragged = useDragged();
  const isShown = near || pinned || focused || dragged === recordingId;
  return (
    <div ref={place} onFocus={() => setFocused(true)} onBlur={() => setFocused(false)}>
      {isShown ? (
        <FetchedCard {...card} height={height} />
      ) : (
        <Missing recordingId={recordingId} height={height} />
      )}
    </div>
  );
});

/** A card, once the recording is there. */
function FetchedCard(props: Omit<ShownCardProps, "pinned"> & { height: number | undefined }) {
  const { recordingId, tiers, height, onPreview, onMove, onSelect } = props;
  const { onPerfect, onGiveBack, renderOpinion, ...rest } = props;
  const { data, error, refetch } = useQuery(shownQuery(rest.behaviour.id, recordingId));
  const nameOf = useRecordingName();
  if (!data) {
    return (
      <Missing recordingId={recordingId} height={height} busy={!error}>
        {error && (
          <Failed what={nameOf(recordingId)} error={error} onRetry={() => void refetch()} />
        )}
      </Missing>
    );
  }
  return (
    <RankCard
      {...rest}
      recording={data}
      possible={possibleMoves(tiers, recordingId)}
      onPreview={() => onPreview(recordingId)}
      onMove={(move) => onMove(recordingId, move)}
      onSelect={(on) => onSelect(recordingId, on)}
      opinion={renderOpinion(recordingId)}
      onPerfect={() => onPerfect(data)}
      onGiveBack={() => onGiveBack(data)}
    />
  );
}

interface MissingProps {
  recordingId: number;
  height: number | undefined;
  busy?: boolean;
  children?: ReactNode;
}

/** The place of a card that is not laid out. */
function Missing({ recordingId, height, busy = false, children }: MissingProps) {
  const nameOf = useRecordingName();
  return (
    <div
      role="group"
      className={styles.missing}
      aria-label={nameOf(recordingId)}
      aria-busy={busy}
      style={{ minHeight: height }}
    >
      {children}
    </div>
  );
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

/** A card as it is shown while dragged. */
export function DraggedCard({
  recordingId,
  behaviour,
}: {
  recordingId: number;
  behaviour: Behaviour;
}) {
  const { data } = useQuery(shownQuery(behaviour.id, recordingId));
  return data && <CardBody recording={data} behaviour={behaviour} />;
}

/** How far out of sight a card is laid out, so that the Tab key finds what comes next. */
const MARGIN = "100% 0px";

/** Whether an element is in sight or nearly so, and how high it was when it was last. */
function useNear(of: RefObject<HTMLElement | null>) {
  const [seen, setSeen] = useState<{ near: boolean; height: number | undefined }>({
    near: !("IntersectionObserver" in globalThis),
    height: undefined,
  });
  useEffect(() => {
    const element = of.current;
    if (!element || !("IntersectionObserver" in globalThis)) return undefined;
    const observer = new IntersectionObserver(
      (entries) => {
        // A busy page gets several changes at once, the latest last.
        const entry = entries.at(-1);
        if (!entry) return;
        const { isIntersecting: near, boundingClientRect } = entry;
        setSeen({ near, height: boundingClientRect.height });
      },
      { rootMargin: MARGIN },
    );
    observer.observe(element);
    return () => observer.disconnect();
  }, [of]);
  return seen;
}

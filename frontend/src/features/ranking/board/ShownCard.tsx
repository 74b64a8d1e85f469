import { useQuery } from "@tanstack/react-query";
import { type ComponentProps, type RefObject, useEffect, useRef, useState } from "react";

import { shownQuery } from "@/api/library";
import type { Behaviour, Recording } from "@/api/types";
import { Failed } from "@/components/feedback/States";
import { recordingName } from "@/lib/recordings";

import { useDragged } from "./DragBoard";
import { CardBody, RankCard } from "./RankCard";
import styles from "./ShownCard.module.css";

interface ShownCardProps extends Omit<
  ComponentProps<typeof RankCard>,
  "recording" | "onPerfect" | "onGiveBack"
> {
  recordingId: number;
  /** Whether it is laid out even out of sight. */
  pinned: boolean;
  onPerfect: (recording: Recording) => void;
  onGiveBack: (recording: Recording) => void;
}

/** A card on the board, once the recording is there; far out of sight only its place is kept. */
export function ShownCard(props: ShownCardProps) {
  const { recordingId, pinned, onPerfect, onGiveBack, ...rest } = props;
  const place = useRef<HTMLDivElement>(null);
  const { near, height } = useNear(place);
  const [focused, setFocused] = useState(false);
  const dragged = useDragged();
  const isShown = near || pinned || focused || dragged === recordingId;
  const { data, error, refetch } = useQuery({
    ...shownQuery(rest.behaviour.id, recordingId),
    enabled: isShown,
  });
  const name = recordingName({ id: recordingId });
  return (
    <div ref={place} onFocus={() => setFocused(true)} onBlur={() => setFocused(false)}>
      {isShown && data ? (
        <RankCard
          {...rest}
          recording={data}
          onPerfect={() => onPerfect(data)}
          onGiveBack={() => onGiveBack(data)}
        />
      ) : (
        <div
          role="group"
          className={styles.missing}
          aria-label={name}
          aria-busy={isShown && !error}
          style={{ minHeight: height }}
        >
          {isShown && error && <Failed what={name} error={error} onRetry={() => void refetch()} />}
        </div>
      )}
    </div>
  );
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

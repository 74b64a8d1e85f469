import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useEffect, useState } from "react";

import type { GameStream } from "@/features/play/stream/game-stream";
import type { LatencySummary } from "@/features/play/stream/latency";
import { fixed, NONE, whole } from "@/lib/format";

import styles from "./LatencyDisplay.module.css";

const REFRESH_MS = 500;

/** Input latency and dropped frames, in a corner of the screen. */
export function LatencyDisplay({ stream }: { stream: GameStream }) {
  const [shown, setShown] = useState(() => stream.latencySummary());
  useEffect(() => {
    const timer = setInterval(() => setShown(stream.latencySummary()), REFRESH_MS);
    return () => clearInterval(timer);
  }, [stream]);
  return (
    <dl className={styles.latency} aria-label={t`Latency`}>
      <dt title={t`Median time from pressing a key to drawing the first frame that shows it`}>
        <Trans>key to draw, p50</Trans>
      </dt>
      <dd>{ms(shown.p50Ms)}</dd>
      <dt title={t`95 of 100 presses show within this time`}>p95</dt>
      <dd>{ms(shown.p95Ms)}</dd>
      <dt title={t`Frames of the game that were not drawn`}>
        <Trans>dropped</Trans>
      </dt>
      <dd>{droppedWords(shown)}</dd>
    </dl>
  );
}

function ms(value: number | null): string {
  return value === null ? NONE : t`${fixed(value, 0)} ms`;
}

function droppedWords({ dropped, drawn }: LatencySummary): string {
  return t`${whole(dropped)} of ${whole(dropped + drawn)}`;
}

import { useSyncExternalStore } from "react";

import { ago, moment } from "@/lib/format";

const REFRESH_MS = 20_000;

/** The current time, in coarse steps so that all components agree. */
function now(): number {
  return Math.floor(Date.now() / REFRESH_MS) * REFRESH_MS;
}

function everyStep(listener: () => void): () => void {
  const timer = setInterval(listener, REFRESH_MS);
  return () => clearInterval(timer);
}

/** A relative time; the exact one on hover. */
export function Ago({ time }: { time: string }) {
  const present = useSyncExternalStore(everyStep, now);
  return (
    <time dateTime={time} title={moment(time)}>
      {ago(time, present)}
    </time>
  );
}

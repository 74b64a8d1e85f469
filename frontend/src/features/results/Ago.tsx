import { useSyncExternalStore } from "react";

import { ago, moment } from "@/lib/format";

const REFRESH_MS = 20_000;

/** The present moment, in steps so that everything on the page that shows it agrees. */
function now(): number {
  return Math.floor(Date.now() / REFRESH_MS) * REFRESH_MS;
}

function everyStep(listener: () => void): () => void {
  const timer = setInterval(listener, REFRESH_MS);
  return () => clearInterval(timer);
}

/** How long ago something was; the exact time on hover. */
export function Ago({ time }: { time: string }) {
  const present = useSyncExternalStore(everyStep, now);
  return (
    <time dateTime={time} title={moment(time)}>
      {ago(time, present)}
    </time>
  );
}

import { useEffect } from "react";

import { SOUND } from "@/features/play/settings/settings";
import { useSetting } from "@/features/play/settings/stored";
import type { Frames } from "@/features/play/stage/use-screen";
import type { GameStream } from "@/features/play/stream/game-stream";

import { Sounds } from "./sounds";

/** Whether this browser can make sounds. */
export function canSound(): boolean {
  return "AudioContext" in globalThis;
}

/** Lets shots, hits and the end of a game be heard, if that is wanted. */
export function useSounds(stream: GameStream | null, frames: Frames): void {
  const [wanted] = useSetting(SOUND);
  useEffect(() => {
    if (!wanted || !stream || !canSound()) return undefined;
    const sounds = new Sounds(new AudioContext());
    let before = stream.snapshot();
    const stopHearing = stream.subscribe(() => {
      const now = stream.snapshot();
      const hit = now.hits.at(-1);
      const isOn = before.phase === "playing" || before.phase === "stepping";
      if (isOn && now.phase === "ended") sounds.play("end");
      else if (isOn && hit && now.hits.length > before.hits.length) {
        sounds.play(hit.on_target === false ? "stray" : "target");
      }
      before = now;
    });
    let isLive = false;
    const stopWatching = frames.watch(({ isShot }) => {
      // Not before the frame has been acknowledged: a sound may be late, a frame not.
      if (isLive && isShot) queueMicrotask(() => sounds.play("shot"));
    });
    isLive = true;
    return () => {
      stopHearing();
      stopWatching();
      sounds.close();
    };
  }, [wanted, stream, frames]);
}

import { useEffect } from "react";

import { SOUND } from "@/features/play/settings/settings";
import { useSetting } from "@/features/play/settings/stored";
import type { FrameSource } from "@/features/play/stage/use-screen";
import type { GameStream } from "@/features/play/stream/game-stream";

import { Sounds } from "./sounds";

/** Whether this browser supports Web Audio. */
export function canSound(): boolean {
  return "AudioContext" in globalThis;
}

/** Plays a sound for shots, hits and the end of a game, if sound is on. */
export function useSounds(stream: GameStream | null, frames: FrameSource): void {
  const [enabled] = useSetting(SOUND);
  useEffect(() => {
    if (!enabled || !stream || !canSound()) return undefined;
    const sounds = new Sounds(new AudioContext());
    let before = stream.snapshot();
    const unsubscribe = stream.subscribe(() => {
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
    const unwatch = frames.watch(({ hasCounted }) => {
      // After the frame is acknowledged: a sound may be late, a frame may not.
      if (isLive && hasCounted) queueMicrotask(() => sounds.play("shot"));
    });
    isLive = true;
    return () => {
      unsubscribe();
      unwatch();
      sounds.close();
    };
  }, [enabled, stream, frames]);
}

import { t } from "@lingui/core/macro";
import { useSyncExternalStore } from "react";

import { IconButton } from "@/components/controls/Button";
import { Scrubber } from "@/components/recording/Scrubber";
import { SpeedChoice } from "@/components/recording/SpeedChoice";
import { useGame } from "@/games/game";
import { seconds } from "@/lib/format";
import type { Playback } from "@/lib/game/playback";

import styles from "./Transport.module.css";

interface TransportProps {
  playback: Playback;
  last: number;
  onSpeed: (speed: number) => void;
}

/** Plays both games, at a speed and from a position that they share. */
export function Transport({ playback, last, onSpeed }: TransportProps) {
  const game = useGame();
  const { frame, playing } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  return (
    <div className={styles.transport}>
      <IconButton
        icon={playing ? "pause" : "play"}
        label={playing ? t`Pause` : t({ message: "Play", context: "playback" })}
        kind="secondary"
        onClick={() => playback.toggle()}
      />
      <IconButton
        icon="restart"
        label={t`From the beginning`}
        onClick={() => {
          playback.seek(0);
          playback.play();
        }}
      />
      <div className={styles.position}>
        <Scrubber playback={playback} last={last} />
      </div>
      <span className={styles.time}>{seconds(frame / game.frame_rate_hz)}</span>
      <SpeedChoice playback={playback} onChoose={onSpeed} />
    </div>
  );
}

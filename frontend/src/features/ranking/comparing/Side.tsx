import type { Behaviour, Recording } from "@/api/types";
import { ItemGrid } from "@/components/game/ItemGrid";
import type { Stage } from "@/components/in-step/ComparedGames";
import { ScreenInStep } from "@/components/in-step/ScreenInStep";
import { SourceBadge } from "@/components/recording/SourceBadge";
import { useGame } from "@/games/game";
import { describeCourse, describeResult } from "@/games/outcomes";
import { takenCells } from "@/lib/game/items";
import { recordingName } from "@/lib/recordings";

import styles from "./Side.module.css";

interface SideProps extends Stage {
  recording: Recording;
  behaviour: Behaviour;
  /** What it is in the comparison. */
  part: string;
}

/** One of two compared games: what it is, and its screen. */
export function Side({ recording, behaviour, part, screens, playback, screenHeight }: SideProps) {
  const game = useGame();
  const name = recordingName(recording);
  const result = describeResult(recording, behaviour, game);
  return (
    <section className={styles.side} aria-label={name}>
      <div className={styles.facts}>
        <ItemGrid hits={takenCells(recording)} target={behaviour.target} label="" />
        <div className={styles.words}>
          <div className={styles.title}>
            <h3>{name}</h3>
            <span className={styles.source}>
              <SourceBadge recording={recording} />
            </span>
            <span className={styles.part}>{part}</span>
          </div>
          {result && <p>{result}</p>}
          <p>{describeCourse(recording, game)}</p>
        </div>
      </div>
      <ScreenInStep
        game={recording}
        name={name}
        screens={screens}
        playback={playback}
        screenHeight={screenHeight}
      />
    </section>
  );
}

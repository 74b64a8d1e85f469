import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useEffect, useId, useRef, useState } from "react";

import { framesQuery } from "@/api/recordings";
import type { Recording, RewardState } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { GameCanvas } from "@/components/game/GameCanvas";
import { useGame } from "@/games/game";
import { ordinal } from "@/lib/format";
import type { ScreenPainter } from "@/lib/game/screen";
import { useFittingScreenSize } from "@/lib/game/use-screen-size";
import { recordingName } from "@/lib/recordings";
import { useSettled } from "@/lib/use-settled";

import styles from "./AnyPercentile.module.css";
import { momentPath } from "./moment";

interface AnyPercentileProps {
  /** At the percentiles 0, 1, ..., 100 of R. */
  states: readonly RewardState[];
  /** Writes R on the page's scale. */
  levelOf: (reward: number) => string;
  recordings: ReadonlyMap<number, Recording>;
  runId: string;
}

const FIRST = 75;
/** Recordings are replayed on demand, so not for each position that the slider passes. */
const SETTLED_MS = 150;

/** The state at any percentile of R among the states of the ranked recordings. */
export function AnyPercentile({ states, levelOf, recordings, runId }: AnyPercentileProps) {
  const id = useId();
  const [percentile, setPercentile] = useState(FIRST);
  const settled = useSettled(percentile, SETTLED_MS);
  const state = states[percentile];
  const shown = states[settled];
  const recording = shown && recordings.get(shown.recording_id);
  if (!state) return null;
  const name = percentileName(percentile);
  return (
    <section className={styles.any} aria-label={t`Any percentile of R`}>
      <div className={styles.choice}>
        <label htmlFor={id}>
          <Trans>Any percentile of R</Trans>
        </label>
        <input
          id={id}
          type="range"
          min={0}
          max={states.length - 1}
          value={percentile}
          aria-valuetext={`${name}, R ${levelOf(state.reward)}`}
          onChange={(event) => setPercentile(event.currentTarget.valueAsNumber)}
        />
        <p className={styles.facts}>
          <strong>{name}</strong>
          <span>R {levelOf(state.reward)}</span>
          <span>
            <Trans>
              {recordingName(recordings.get(state.recording_id))}, step {state.step}
            </Trans>
          </span>
        </p>
        <ButtonLink to={momentPath(state, runId)}>
          <Trans>Open this moment</Trans>
        </ButtonLink>
      </div>
      {recording && <Still recording={recording} step={shown.step} />}
    </section>
  );
}

function percentileName(percentile: number): string {
  if (percentile === 0) return t`minimum`;
  return percentile === 100 ? t`maximum` : t`${ordinal(percentile)} percentile`;
}

const stillHeight = () => 210;

/** The screen after a step of a recording. */
function Still({ recording, step }: { recording: Recording; step: number }) {
  const game = useGame();
  const box = useRef<HTMLDivElement>(null);
  const size = useFittingScreenSize(box, stillHeight, game);
  const { data: frames } = useQuery(framesQuery(recording));
  const [painter, setPainter] = useState<ScreenPainter | null>(null);
  useEffect(() => {
    if (!painter || !frames) return;
    painter.setFormat(frames.header);
    painter.draw(frames.show(Math.min(step * game.frames_per_step, frames.last)));
  }, [frames, painter, step, game]);
  return (
    <div ref={box} className={styles.still}>
      <GameCanvas
        size={size}
        label={t`Screen at step ${step} of ${recordingName(recording)}`}
        onPainter={setPainter}
      />
    </div>
  );
}

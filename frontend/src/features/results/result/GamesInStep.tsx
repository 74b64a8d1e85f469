import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { Link } from "react-router";

import type { Behaviour, EvaluationGame, Recording, Run } from "@/api/types";
import { ActorMark } from "@/components/game/ActorMark";
import { playByKey } from "@/components/in-step/playback-keys";
import { ScreenInStep } from "@/components/in-step/ScreenInStep";
import { Transport } from "@/components/in-step/Transport";
import { type Screens, usePlaybackInStep } from "@/components/in-step/use-playback-in-step";
import { useGame } from "@/games/game";
import { describeCourse, describeResult } from "@/games/outcomes";
import { actorNames, playedBy } from "@/lib/actors";
import { inSentence } from "@/lib/format";
import type { Playback } from "@/lib/game/playback";

import styles from "./GamesInStep.module.css";
import { RewardInStep } from "./RewardInStep";
import type { ShownGame } from "./shown-games";

interface GamesInStepProps {
  run: Run;
  behaviour: Behaviour;
  imitator: EvaluationGame;
  best: Recording | null;
}

/** The part of the window's height that the rest of the result needs. */
const CHROME_PX = 380;
const LEAST_PX = 210;
const screenHeight = (windowHeight: number) => Math.max(windowHeight - CHROME_PX, LEAST_PX);

/** The imitator's game beside the person's best one, with R under both, in step. */
export function GamesInStep({ run, behaviour, imitator, best }: GamesInStepProps) {
  const game = useGame();
  const games: ShownGame[] = [
    { actor: "imitator", name: actorNames().imitator, recording: imitator.recording },
  ];
  if (best) {
    const actor = playedBy(best.source);
    games.push({ actor, name: t`${actorNames()[actor]}, best game`, recording: best });
  }
  const { playback, last, screens, setSpeed } = usePlaybackInStep(
    games.map(({ recording }) => recording),
    1,
  );
  return (
    // Handles keys wherever the focus is inside; each has a control with the same effect.
    // eslint-disable-next-line jsx-a11y/no-noninteractive-element-interactions
    <div
      className={styles.player}
      role="group"
      aria-label={t`Games in step`}
      onKeyDown={(event) => {
        if (playback) playByKey(event, playback, last, game.frames_per_step);
      }}
    >
      <div className={styles.games}>
        {games.map((one, index) => (
          <Side
            key={one.recording.id}
            game={one}
            run={run}
            behaviour={behaviour}
            screens={screens[index]}
            playback={playback}
          />
        ))}
      </div>
      <div className={styles.below}>
        {playback && (
          <>
            <RewardInStep runId={run.id} games={games} playback={playback} last={last} />
            <Transport playback={playback} last={last} onSpeed={setSpeed} />
          </>
        )}
      </div>
    </div>
  );
}

interface SideProps {
  game: ShownGame;
  run: Run;
  behaviour: Behaviour;
  screens: Screens | undefined;
  playback: Playback | null;
}

function Side({ game: { actor, name, recording }, run, behaviour, screens, playback }: SideProps) {
  const game = useGame();
  const words = [describeResult(recording, behaviour, game), describeCourse(recording, game)];
  return (
    <figure className={styles.side}>
      <ScreenInStep
        game={recording}
        name={inSentence(name)}
        screens={screens}
        playback={playback}
        screenHeight={screenHeight}
      />
      <figcaption>
        <strong>
          <ActorMark actor={actor}>{name}</ActorMark>
        </strong>
        <span>
          {words.filter(Boolean).join(", ")}.{" "}
          <Link to={`/recordings/${recording.id}?run=${run.id}`}>
            <Trans>Frame by frame</Trans>
            <span className="visually-hidden">: {name}</span>
          </Link>
        </span>
      </figcaption>
    </figure>
  );
}

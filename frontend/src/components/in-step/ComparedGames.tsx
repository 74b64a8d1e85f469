import { t } from "@lingui/core/macro";
import { useQueries } from "@tanstack/react-query";
import { type ReactNode, useEffect, useRef } from "react";

import { framesQuery } from "@/api/recordings";
import { Button } from "@/components/controls/Button";
import { useMedia } from "@/lib/browser/use-media";
import type { Playback } from "@/lib/game/playback";

import { type AnswerAct, useAnswerKeys } from "./answer-keys";
import styles from "./ComparedGames.module.css";
import { Transport } from "./Transport";
import { type Played, type Screens, usePlaybackInStep } from "./use-playback-in-step";

/** What shows the screen of one of the games. */
export interface Stage {
  readonly screens: Screens | undefined;
  readonly playback: Playback | null;
  /** Height available for the screen, in CSS pixels; a stable reference. */
  readonly screenHeight: (windowHeight: number) => number;
}

/** Something else that can be done. */
interface FurtherAct {
  readonly label: string;
  /** The key that does the same, as it is printed. */
  readonly shortcut?: string;
  readonly onAct: () => void;
}

interface ComparedGamesProps {
  question: string;
  /** How much of it is done. */
  progress: ReactNode;
  games: readonly [Played, Played];
  /** The games that may be shown next. */
  upcoming: readonly Played[];
  /** One of the two games. */
  side: (place: 0 | 1, stage: Stage) => ReactNode;
  /** The words on the answers, beside each other or one above the other. */
  words: (stacked: boolean) => Readonly<Record<Answer, string>>;
  /** Whether nothing can be done at the moment. */
  busy: boolean;
  canUndo: boolean;
  onAnswer: (answer: Answer) => void;
  onUndo: () => void;
  further: readonly FurtherAct[];
}

export type Answer = "first" | "equal" | "second";

/** Fast, since most pairs are told apart by where they end. */
const FIRST_SPEED = 2;
/** Where the games don't fit side by side. */
const NARROW = "(max-width: 46rem)";
/** The part of the window's height that the rest of the dialog needs. */
const CHROME_PX = 300;
const LEAST_PX = 210;
const beside = (windowHeight: number) => Math.max(windowHeight - CHROME_PX, LEAST_PX);
const stackedHeight = () => LEAST_PX;

/** Two games side by side, playing in step, and the answers. */
export function ComparedGames(props: ComparedGamesProps) {
  const { question, progress, games, upcoming, side, busy, canUndo, further } = props;
  const root = useRef<HTMLDivElement>(null);
  const stacked = useMedia(NARROW);
  const { playback, last, screens, setSpeed } = usePlaybackInStep(games, FIRST_SPEED);
  useLoaded(upcoming, playback !== null);

  // The keys answer, not the first button.
  useEffect(() => root.current?.focus({ preventScroll: true }), []);

  const acts: Readonly<Record<AnswerAct, () => void>> = {
    first: () => props.onAnswer("first"),
    equal: () => props.onAnswer("equal"),
    second: () => props.onAnswer("second"),
    undo: props.onUndo,
    play: () => playback?.toggle(),
  };
  const keyed = further.map(({ shortcut = "", onAct }) => [shortcut.toLowerCase(), onAct] as const);
  useAnswerKeys(root, acts, Object.fromEntries(keyed.filter(([sign]) => sign !== "")));

  const words = props.words(stacked);
  const shortcuts = { first: stacked ? "1" : "←", equal: "=", second: stacked ? "2" : "→" };
  const stage = { playback, screenHeight: stacked ? stackedHeight : beside };
  return (
    <div
      ref={root}
      className={styles.comparison}
      role="group"
      aria-label={t`Comparison`}
      tabIndex={-1}
    >
      <p className={styles.progress}>{progress}</p>
      <div className={styles.games}>
        {side(0, { ...stage, screens: screens[0] })}
        {side(1, { ...stage, screens: screens[1] })}
      </div>
      <div className={styles.transport}>
        {playback && <Transport playback={playback} last={last} onSpeed={setSpeed} />}
      </div>
      <div role="group" aria-label={question} className={styles.answers}>
        {(["first", "equal", "second"] as const).map((answer) => (
          <ActButton
            key={answer}
            kind="secondary"
            label={words[answer]}
            shortcut={shortcuts[answer]}
            disabled={busy}
            onAct={acts[answer]}
          />
        ))}
      </div>
      <div className={styles.more}>
        <ActButton label={t`Undo`} shortcut="U" disabled={busy || !canUndo} onAct={acts.undo} />
        {further.map((act) => (
          <ActButton key={act.label} {...act} disabled={busy} />
        ))}
      </div>
    </div>
  );
}

interface ActButtonProps extends FurtherAct {
  kind?: "secondary" | "quiet";
  disabled: boolean;
}

function ActButton({ label, shortcut, kind = "quiet", disabled, onAct }: ActButtonProps) {
  return (
    <Button
      kind={kind}
      large={kind === "secondary"}
      // Not `disabled`, which would lose the focus.
      aria-disabled={disabled}
      onClick={() => {
        if (!disabled) onAct();
      }}
    >
      {label} {shortcut && <kbd aria-hidden="true">{shortcut}</kbd>}
    </Button>
  );
}

/** Loads what may be shown next, once what is shown is there. */
function useLoaded(games: readonly Played[], enabled: boolean): void {
  useQueries({
    queries: games.map((one) => ({
      ...framesQuery(one),
      enabled,
      // What could not be loaded is tried again when it is shown.
      retryOnMount: false,
      notifyOnChangeProps: [],
    })),
  });
}

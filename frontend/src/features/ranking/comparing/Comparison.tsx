import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useQueries } from "@tanstack/react-query";
import { useEffect, useRef } from "react";

import { framesQuery } from "@/api/recordings";
import type { Behaviour, Recording } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Transport } from "@/components/in-step/Transport";
import { usePlaybackInStep } from "@/components/in-step/use-playback-in-step";
import { useMedia } from "@/lib/browser/use-media";

import { type Act, useCompareKeys } from "./compare-keys";
import styles from "./Comparison.module.css";
import type { Question } from "./session";
import { Side } from "./Side";
import type { Comparing } from "./use-comparing";

interface ComparisonProps {
  comparing: Comparing;
  question: Question;
  /** The recording that is to be placed. */
  game: Recording;
  /** The ranked one that it is compared with. */
  opponent: Recording;
  /** The recordings that may be shown next. */
  upcoming: readonly Recording[];
  behaviour: Behaviour;
  nTiers: number;
  nGames: number;
}

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
export function Comparison(props: ComparisonProps) {
  const { comparing, question, game, opponent, upcoming, behaviour, nTiers, nGames } = props;
  const root = useRef<HTMLDivElement>(null);
  const stacked = useMedia(NARROW);
  const { playback, last, screens, setSpeed } = usePlaybackInStep([game, opponent], FIRST_SPEED);
  useLoaded(upcoming, playback !== null);

  // The keys answer, not the first button.
  useEffect(() => root.current?.focus({ preventScroll: true }), []);

  const acts: Readonly<Record<Act, () => void>> = {
    game: () => comparing.answer("better"),
    equal: () => comparing.answer("equal"),
    opponent: () => comparing.answer("worse"),
    skip: comparing.skip,
    worst: () => comparing.putBelow("this"),
    undo: comparing.undo,
    play: () => playback?.toggle(),
  };
  useCompareKeys(root, acts);

  const { number, looks, tier } = question;
  const [tierNumber, height] = [tier + 1, stacked ? stackedHeight : beside];
  const stage = { behaviour, playback, screenHeight: height };
  const { busy } = comparing;
  const answers = { kind: "secondary", disabled: busy } as const;
  return (
    <div
      ref={root}
      className={styles.comparison}
      role="group"
      aria-label={t`Comparison`}
      tabIndex={-1}
    >
      <p className={styles.progress}>
        <Trans>
          Game {number} of {nGames},{" "}
          <Plural value={looks} one="about # more look" other="about # more looks" />
        </Trans>
      </p>
      <div className={styles.games}>
        <Side {...stage} recording={game} part={t`to be placed`} screens={screens[0]} />
        <Side
          {...stage}
          recording={opponent}
          part={t`tier ${tierNumber} of ${nTiers}`}
          screens={screens[1]}
        />
      </div>
      <div className={styles.transport}>
        {playback && <Transport playback={playback} last={last} onSpeed={setSpeed} />}
      </div>
      <div role="group" aria-label={t`Which is better?`} className={styles.answers}>
        <ActButton
          {...answers}
          label={stacked ? t`Upper is better` : t`Left is better`}
          shortcut={stacked ? "1" : "←"}
          onAct={acts.game}
        />
        <ActButton {...answers} label={t`Equally good`} shortcut="=" onAct={acts.equal} />
        <ActButton
          {...answers}
          label={stacked ? t`Lower is better` : t`Right is better`}
          shortcut={stacked ? "2" : "→"}
          onAct={acts.opponent}
        />
      </div>
      <div className={styles.more}>
        <ActButton
          label={t`Undo`}
          shortcut="U"
          disabled={busy || !comparing.canUndo}
          onAct={acts.undo}
        />
        <ActButton label={t`Skip`} shortcut="S" disabled={busy} onAct={acts.skip} />
        <ActButton label={t`Below the worst`} shortcut="W" disabled={busy} onAct={acts.worst} />
        {comparing.nLeft > 1 && (
          <ActButton
            label={t`All ${comparing.nLeft} left below the worst`}
            disabled={busy}
            onAct={() => comparing.putBelow("all")}
          />
        )}
      </div>
    </div>
  );
}

interface ActButtonProps {
  label: string;
  /** The key that does the same. */
  shortcut?: string;
  kind?: "secondary" | "quiet";
  disabled: boolean;
  onAct: () => void;
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
function useLoaded(recordings: readonly Recording[], enabled: boolean): void {
  useQueries({
    queries: recordings.map((one) => ({
      ...framesQuery(one),
      enabled,
      // What could not be loaded is tried again when it is shown.
      retryOnMount: false,
      notifyOnChangeProps: [],
    })),
  });
}

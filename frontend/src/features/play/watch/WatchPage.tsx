import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { type RefObject, useCallback, useEffect, useRef, useState } from "react";
import { Link, useNavigate, useSearchParams } from "react-router";

import type { Behaviour, Run, TaughtGame } from "@/api/types";
import { OPACITY } from "@/components/attention/AttentionKey";
import { Button } from "@/components/controls/Button";
import { Notice } from "@/components/feedback/States";
import type { ClockHandle } from "@/features/play/hud/Clock";
import { dialogIsOpen } from "@/features/play/input/dialogs";
import { rememberGame } from "@/features/play/stream/use-played-game";
import { useGame } from "@/games/game";
import { seconds } from "@/lib/format";
import { runName } from "@/lib/runs";

import {
  type Choice,
  furtherPlayer,
  MAX_PLAYERS,
  newStart,
  nextStart,
  type Player,
  readChoice,
  writeChoice,
} from "./choice";
import { LaneView } from "./LaneView";
import { Transport } from "./Transport";
import { useWatch } from "./use-watch";
import { speedAfter, type WatchIntent, watchIntentOf } from "./watch-keys";
import { WatchedAttention } from "./WatchedAttention";
import styles from "./WatchPage.module.css";
import type { WatchState, WatchStream } from "./watch-stream";

/** Height of the header, the path, the title, and what stands below the screens. */
const CHROME_PX = 330;
const MIN_HEIGHT_PX = 210;
const heightOfOneRow = (windowHeight: number) => Math.max(windowHeight - CHROME_PX, MIN_HEIGHT_PX);
const heightOfTwoRows = (windowHeight: number) =>
  Math.max((windowHeight - CHROME_PX) / 2, MIN_HEIGHT_PX);

/** Watches policies of a run play, up to four side by side on the same start. */
export function WatchPage({ run, behaviour }: { run: Run; behaviour: Behaviour }) {
  const game = useGame();
  const [search, setSearch] = useSearchParams();
  const choice = readChoice(search);
  const { players } = choice;
  const { state, stream, relays, restart, attention, setAttention } = useWatch(run.id, choice);
  const [opacity, setOpacity] = useState(OPACITY);
  const clock = useRef<ClockHandle>(null);
  const onFrame = useCallback(
    (frame: number, maxFrames: number) => clock.current?.show(frame, maxFrames),
    [],
  );
  const choose = (change: Choice) => setSearch(writeChoice(change), { replace: true });
  const setPlayers = (changed: readonly Player[]) => choose({ ...choice, players: changed });

  const execute = (intent: WatchIntent) => {
    if (intent === "restart") restart();
    else if (intent === "next") choose(nextStart(choice));
    else if (stream) control(stream, intent);
  };
  useWatchKeys(execute, players.length);
  usePauseWhenHidden(stream);
  useTaken(state);

  const canTakeOver = ["playing", "waiting", "paused"].includes(state?.phase ?? "");
  return (
    <div className={styles.page}>
      <title>{t`Watch · ${runName(run)} · Tril`}</title>
      <div className={styles.title}>
        <h2>
          <Trans>
            <Link to={`/runs/${run.id}`}>{runName(run)}</Link> plays
          </Trans>
        </h2>
        <p>{describeBeginning(choice, state, game)}</p>
      </div>
      <Situation state={state} onAgain={restart} />
      <div className={styles.lanes} data-several={players.length > 1 || undefined}>
        {players.map((player, lane) => {
          const relay = relays[lane];
          return (
            relay && (
              <LaneView
                key={lane}
                lane={lane}
                nLanes={players.length}
                player={player}
                behaviour={behaviour}
                state={state?.lanes[lane]}
                relay={relay}
                attention={attention}
                opacity={opacity}
                onFrame={onFrame}
                heightFor={players.length > 2 ? heightOfTwoRows : heightOfOneRow}
                canTakeOver={canTakeOver}
                onPlayer={(chosen) =>
                  setPlayers(players.map((one, at) => (at === lane ? chosen : one)))
                }
                onRemove={() => setPlayers(players.filter((_, at) => at !== lane))}
                onTakeOver={() => stream?.takeOver(lane)}
              />
            )
          );
        })}
      </div>
      <Transport
        state={state}
        choice={choice}
        clock={clock}
        onToggle={() => execute("toggle")}
        onStep={() => execute("step")}
        onSpeed={(percent) => stream?.setSpeed(percent)}
        onRestart={() => execute("restart")}
        onNext={() => execute("next")}
        onStart={(start) => choose(start === null ? newStart(choice) : { ...choice, start })}
      />
      <div className={styles.more}>
        <WatchedAttention
          network={attention}
          onNetwork={setAttention}
          opacity={opacity}
          onOpacity={setOpacity}
        />
        {players.length < MAX_PLAYERS && (
          <Button icon="plus" onClick={() => setPlayers([...players, furtherPlayer(players)])}>
            <Plural
              value={players.length}
              one="Add another beside it"
              other="Add another beside them"
            />
          </Button>
        )}
      </div>
      <p className={styles.hint}>
        <Trans>
          All games begin at the same start and run in step. Nothing is kept unless you take over:
          the game then continues with your keys, and the whole of it becomes your recording.
        </Trans>
      </p>
    </div>
  );
}

/** What keeps the games from being played, and what to do. */
function Situation({ state, onAgain }: { state: WatchState | null; onAgain: () => void }) {
  const again = (
    <Button icon="restart" onClick={onAgain}>
      <Trans>Try again</Trans>
    </Button>
  );
  switch (state?.phase) {
    case "waiting":
      return (
        <Notice tone="calm" icon="clock" live>
          <p>
            <Trans>
              Waiting for the next decision. The machine is busy; the games wait meanwhile.
            </Trans>
          </p>
        </Notice>
      );
    case "paused":
      return state.why ? (
        <Notice live>
          <p>{state.why}</p>
        </Notice>
      ) : null;
    case "refused":
      return (
        <Notice tone="bad" live>
          <p>{state.why}</p>
          {again}
        </Notice>
      );
    case "closed":
      return (
        <Notice tone="calm" icon="clock" live>
          <p>
            <Trans>The games were paused for a long time and have been closed.</Trans>
          </p>
          {again}
        </Notice>
      );
    case "lost":
      return (
        <Notice tone="bad" live>
          <p>
            <Trans>The connection was lost, and the games with it.</Trans>
          </p>
          {again}
        </Notice>
      );
    default:
      return null;
  }
}

function describeBeginning({ start }: Choice, state: WatchState | null, game: TaughtGame): string {
  const where = start === null ? t`A start that no evaluation uses` : t`Evaluation start ${start}`;
  const opening = state?.openingFrames ?? 0;
  if (opening === 0) return where;
  return t`${where}, after an opening of ${seconds(opening / game.frame_rate_hz)}`;
}

function control(stream: WatchStream, intent: WatchIntent): void {
  if (typeof intent === "object") stream.takeOver(intent.takeOver);
  else if (intent === "toggle") stream.toggle();
  else if (intent === "step") stepOrPause(stream);
  else if (intent === "slower" || intent === "faster") {
    stream.setSpeed(speedAfter(stream.snapshot().speed, intent));
  }
}

/** Plays one step of paused games, and pauses running ones. */
function stepOrPause(stream: WatchStream): void {
  stream.command(stream.snapshot().phase === "paused" ? "step" : "pause");
}

/** Executes the intents of keys that belong to no control of the page. */
function useWatchKeys(execute: (intent: WatchIntent) => void, nLanes: number): void {
  const latest: RefObject<typeof execute> = useRef(execute);
  useEffect(() => {
    latest.current = execute;
  });
  useEffect(() => {
    const down = (event: KeyboardEvent) => {
      if (event.ctrlKey || event.metaKey || event.altKey || dialogIsOpen()) return;
      const { target } = event;
      const at = target instanceof HTMLElement ? target : null;
      if (at?.matches("input, textarea, select")) return;
      if (event.key === " " && at?.matches("button, a, summary")) return;
      const intent = watchIntentOf(event, nLanes);
      if (intent === null) return;
      event.preventDefault();
      latest.current(intent);
    };
    window.addEventListener("keydown", down);
    return () => window.removeEventListener("keydown", down);
  }, [nLanes]);
}

function usePauseWhenHidden(stream: WatchStream | null): void {
  useEffect(() => {
    if (!stream) return undefined;
    const pause = () => {
      if (document.hidden) stream.command("pause");
    };
    document.addEventListener("visibilitychange", pause);
    return () => document.removeEventListener("visibilitychange", pause);
  }, [stream]);
}

/** Goes on with a game that was taken over on the play page. */
function useTaken(state: WatchState | null): void {
  const navigate = useNavigate();
  const taken = state?.taken;
  useEffect(() => {
    if (!taken) return;
    rememberGame(taken.behaviour_id, taken.game_id);
    void navigate(`/behaviours/${taken.behaviour_id}/play`);
  }, [taken, navigate]);
}

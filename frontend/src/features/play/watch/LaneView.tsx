import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { type CSSProperties, useCallback, useEffect, useMemo, useRef, useState } from "react";

import type { Behaviour } from "@/api/types";
import { AttentionLayer } from "@/components/attention/AttentionLayer";
import { withUnit } from "@/components/attention/words";
import { Button, IconButton } from "@/components/controls/Button";
import { GameCanvas } from "@/components/game/GameCanvas";
import { ActorMark } from "@/components/game/ActorMark";
import { Score } from "@/features/play/hud/Score";
import { useGame } from "@/games/game";
import { describeResult, endSentence } from "@/games/outcomes";
import { classes } from "@/lib/classes";
import type { ScreenFormat, ScreenPainter } from "@/lib/game/screen";
import { inSentence } from "@/lib/format";
import { type ScreenSize, useFittingScreenSize } from "@/lib/game/use-screen-size";
import { actorNames, actorColour } from "@/lib/actors";

import { type Player, playerName, PLAYERS, policyOf, type LookingNetwork } from "./choice";
import { DecisionBars, type DecisionHandle } from "./DecisionBars";
import styles from "./LaneView.module.css";
import type { LaneRelay } from "./use-watch";
import { takeOverKey } from "./watch-keys";
import type { LaneAttention } from "./watch-messages";
import type { LaneState } from "./watch-stream";

interface LaneViewProps {
  /** Its place, from 0. */
  lane: number;
  nLanes: number;
  player: Player;
  behaviour: Behaviour;
  state: LaneState | undefined;
  relay: LaneRelay;
  /** Whose attention lies over the picture; null for none. */
  attention: LookingNetwork | null;
  opacity: number;
  /** Called with each frame, outside React. */
  onFrame: (frame: number, maxFrames: number) => void;
  heightFor: (windowHeight: number) => number;
  canTakeOver: boolean;
  onPlayer: (player: Player) => void;
  onRemove: () => void;
  onTakeOver: () => void;
}

/** One of the games that are watched: its screen, its score, and what its policy does next. */
export function LaneView(props: LaneViewProps) {
  const { lane, nLanes, player, behaviour, state, relay, onFrame, heightFor } = props;
  const game = useGame();
  const stage = useRef<HTMLDivElement>(null);
  const painter = useRef<ScreenPainter | null>(null);
  const format = useRef<ScreenFormat | null>(null);
  const decisions = useRef<DecisionHandle>(null);
  const size = useFittingScreenSize(stage, heightFor, game);
  const [shown, setShown] = useState<LaneAttention | null>(null);
  const setPainter = useCallback((ready: ScreenPainter) => {
    painter.current = ready;
    if (format.current) ready.setFormat(format.current);
  }, []);
  useEffect(
    () =>
      relay.attach({
        setFormat: (sent) => {
          format.current = sent;
          painter.current?.setFormat(sent);
        },
        show: (pixels, { frame }, maxFrames) => {
          painter.current?.draw(pixels);
          onFrame(frame, maxFrames);
        },
        decide: (decision) => decisions.current?.decide(decision),
        reward: (level, deviation) => decisions.current?.reward(level, deviation),
        attend: setShown,
      }),
    [relay, onFrame],
  );
  const actor = policyOf(player);
  const ended = state?.ended ?? null;
  const key = takeOverKey(lane, nLanes);
  return (
    <article
      className={styles.lane}
      aria-label={t`Game ${lane + 1}: ${playerName(player)}`}
      style={{ "--actor": actorColour(actor) } as CSSProperties}
    >
      <div className={classes(styles.body, nLanes === 2 && styles.below)}>
        <div ref={stage} className={styles.stage}>
          <GameCanvas size={size} label={t`Screen of game ${lane + 1}`} onPainter={setPainter} />
          {props.attention && shown && isOf(shown, props.attention) && (
            <AttentionOver actor={actor} shown={shown} size={size} opacity={props.opacity} />
          )}
          {ended && (
            <div className={styles.ended} role="status">
              <b>{endSentence(ended, game)}</b>
              <span>{describeResult(ended, behaviour, game)}</span>
            </div>
          )}
        </div>
        <div className={styles.side}>
          <Score hits={state?.hits ?? []} behaviour={behaviour} />
          <DecisionBars handle={decisions} />
        </div>
      </div>
      <div className={styles.head}>
        <ActorMark actor={actor}>
          <span className="visually-hidden">{actorNames()[actor]}</span>
        </ActorMark>
        <select
          aria-label={t`Who plays game ${lane + 1}`}
          value={player}
          onChange={(event) => {
            const chosen = PLAYERS.find((one) => one === event.currentTarget.value);
            if (chosen) props.onPlayer(chosen);
          }}
        >
          {PLAYERS.map((one) => (
            <option key={one} value={one}>
              {playerName(one)}
            </option>
          ))}
        </select>
        {nLanes > 1 && (
          <IconButton icon="close" label={t`Remove game ${lane + 1}`} onClick={props.onRemove} />
        )}
        <Button
          className={styles.takeOver}
          disabled={!props.canTakeOver || ended !== null}
          onClick={props.onTakeOver}
          title={t`From here on you play; the whole game becomes your recording`}
        >
          <Trans>
            Take over <kbd>{key}</kbd>
          </Trans>
        </Button>
      </div>
    </article>
  );
}

function AttentionOver({
  actor,
  shown,
  size,
  opacity,
}: {
  actor: "imitator" | "clone";
  shown: LaneAttention;
  size: ScreenSize;
  opacity: number;
}) {
  const values = useMemo(() => mapOf(shown.shares), [shown]);
  const most = withUnit(shown.most, shown.action === null);
  return (
    <>
      <AttentionLayer
        map={values}
        label={
          shown.action === null
            ? t`What the reward looks at`
            : t`What the ${inSentence(actorNames()[actor])} looks at`
        }
        size={size}
        opacity={opacity}
      />
      <span className={styles.most}>
        <Trans>up to {most}</Trans>
      </span>
    </>
  );
}

/** Whether a map is of what is asked for now, and not one that was on its way. */
function isOf(shown: LaneAttention, attention: LookingNetwork): boolean {
  return (shown.action === null) === (attention === "reward");
}

/** Returns the values of a map, of which only the proportions matter. */
function mapOf(shares: string): Float32Array {
  return Float32Array.from(atob(shares), (character) => character.charCodeAt(0));
}

/** What a map of attention shows, in words. */
import { t } from "@lingui/core/macro";

import { messageOf } from "@/api/client";
import type { AttentionMethod, AttentionNetwork } from "@/api/runs";
import type { TaughtGame } from "@/api/types";
import { measured } from "@/lib/format";
import { actionName } from "@/games/actions";

import type { Attention } from "./use-attention";

interface Option<Id extends string> {
  readonly id: Id;
  readonly name: string;
}

/** Whose attention can be shown. */
export const networks = (): readonly Option<AttentionNetwork>[] => [
  { id: "reward", name: t`Reward` },
  { id: "imitator", name: t`Imitator` },
  { id: "clone", name: t`Clone` },
];

/** How it can be mapped. */
export const methods = (): readonly Option<AttentionMethod>[] => [
  { id: "occlusion", name: t`3×3 pixels, as published` },
  { id: "patches", name: t`9×9 pixels, all four screens` },
  { id: "gradient", name: t`Gradient` },
];

/** Names what is shown: "What the reward looks at". */
export function lookedAt(network: AttentionNetwork): string {
  if (network === "imitator") return t`What the imitator looks at`;
  return network === "clone" ? t`What the clone looks at` : t`What the reward looks at`;
}

/** Names the map: "What the reward looks at in step 3". */
export function mapLabel({ network, step: shown }: Attention): string {
  const step = shown ?? 0;
  if (network === "imitator") return t`What the imitator looks at in step ${step}`;
  if (network === "clone") return t`What the clone looks at in step ${step}`;
  return t`What the reward looks at in step ${step}`;
}

/** Describes the state that is shown, and how its map was made. */
export function describe(attention: Attention, game: TaughtGame): string {
  const { playing, step, network, map, error } = attention;
  if (error) return t`The map can’t be shown: ${messageOf(error)}`;
  // The same while it plays, since a screen reader says what changes.
  if (playing) return whilePlaying(attention);
  if (step === null) return "";
  if (!map || attention.shown === null) return t`Looking at step ${step}…`;
  const chosen = network === "reward" || map.action === null ? null : actionName(map.action, game);
  if (chosen === null) return made(attention, step, "R");
  const explained = made(attention, step, t`the logit of “${chosen}”`);
  const choice =
    network === "imitator"
      ? t`The imitator chooses “${chosen}” here.`
      : t`The clone chooses “${chosen}” here.`;
  return `${explained} ${choice}`;
}

function made({ shown, method }: Attention, step: number, what: string): string {
  if (shown === "occlusion") {
    return t`Step ${step}, exact: how much ${what} changes where 3×3 pixels of one screen are occluded, summed over the patches on a pixel.`;
  }
  if (shown === "patches") {
    return t`Step ${step}, exact: how much ${what} changes where 9×9 pixels of all four screens are occluded, on average over the patches on a pixel.`;
  }
  return method === "gradient"
    ? t`Step ${step}, estimated by the gradient of ${what}.`
    : t`Step ${step}, estimated by the gradient of ${what}; the exact map follows.`;
}

/** Returns the range of the map's colours with its unit: "0.31 R". */
export function describeMost({ map, network }: Attention): string {
  if (!map) return t`most`;
  const most = map.values.reduce((high, value) => Math.max(high, value), 0);
  return withUnit(most, network === "reward");
}

/** Returns a value of a map with its unit, which is R's for the reward, else a logit. */
export function withUnit(value: number, isReward: boolean): string {
  const figure = measured(value);
  return isReward ? `${figure} R` : t`${figure} logits`;
}

function whilePlaying({ network, method }: Attention): string {
  const sentence = followsBy(network === "reward");
  return method === "gradient" ? sentence : `${sentence} ${t`Pause for the exact map.`}`;
}

/** Says how the maps are made that follow a game while it plays. */
export function followsBy(isReward: boolean): string {
  const what = isReward ? t`the learned reward R` : t`the logit of the chosen action`;
  return t`Estimated by the gradient of ${what}, several times a second.`;
}

/** What a map of attention shows, in words. */
import { messageOf } from "@/api/client";
import type { AttentionMethod, AttentionNetwork } from "@/api/runs";
import { measured } from "@/lib/format";
import { actionName } from "@/lib/game/actions";

import type { Attention } from "./use-attention";

export const NETWORKS: readonly { readonly id: AttentionNetwork; readonly name: string }[] = [
  { id: "reward", name: "Reward" },
  { id: "imitator", name: "Imitator" },
  { id: "clone", name: "Clone" },
];

export const METHODS: readonly { readonly id: AttentionMethod; readonly name: string }[] = [
  { id: "occlusion", name: "3×3 pixels, as published" },
  { id: "patches", name: "9×9 pixels, all four screens" },
  { id: "gradient", name: "Gradient" },
];

/** Names what the map shows: "What the reward looks at in step 3". */
export function mapLabel({ network, step }: Attention): string {
  return `What the ${network} looks at in step ${step}`;
}

/** Describes the state that is shown, and how its map was made. */
export function describe(attention: Attention): string {
  const { step, network, map, shown, error } = attention;
  if (step === null) return `Pause to see what the ${network} looks at.`;
  if (error) return `The map can’t be shown: ${messageOf(error)}`;
  if (!map || shown === null) return `Looking at step ${step}…`;
  const what = explained(attention);
  if (shown === "occlusion") {
    return `Step ${step}, exact: how much ${what} changes where 3×3 pixels of one screen are occluded, summed over the patches on a pixel.`;
  }
  if (shown === "patches") {
    return `Step ${step}, exact: how much ${what} changes where 9×9 pixels of all four screens are occluded, on average over the patches on a pixel.`;
  }
  const more = attention.method === "gradient" ? "" : "; the exact map follows";
  return `Step ${step}, estimated by the gradient of ${what}${more}.`;
}

/** Returns the range of the map's colours with its unit: "0.31 R". */
export function describeMost({ map, network }: Attention): string {
  if (!map) return "most";
  const most = map.values.reduce((high, value) => Math.max(high, value), 0);
  return `${measured(most)} ${network === "reward" ? "R" : "log odds"}`;
}

function explained({ network, map }: Attention): string {
  const action = map?.action ?? null;
  if (network === "reward" || action === null) return "R";
  return `the log odds of “${actionName(action)}”, which the ${network} chooses,`;
}

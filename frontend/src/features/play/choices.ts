/** What a player has chosen about playing; kept in this browser. */
import { DEFAULT_KEYS, type KeyMap, readKeyMap } from "@/lib/keys";
import { type Choice, onOff } from "@/lib/stored";

export const SHOW_LATENCY = onOff("tril.play.latency", false);

export const KEYS: Choice<KeyMap> = {
  key: "tril.play.keys",
  fallback: DEFAULT_KEYS,
  read: readKeyMap,
};

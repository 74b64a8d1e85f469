/** What a player has chosen about playing; kept in this browser. */
import { DEFAULT_KEYS, type KeyMap, readKeyMap } from "@/lib/keys";
import { type Choice, onOff } from "@/lib/stored";

export const SHOW_LATENCY = onOff("tril.play.latency", false);
export const SHOW_TARGETS = onOff("tril.play.targets", false);
export const SHOW_GHOST = onOff("tril.play.ghost", false);
export const SOUND = onOff("tril.play.sound", false);

export const KEYS: Choice<KeyMap> = {
  key: "tril.play.keys",
  fallback: DEFAULT_KEYS,
  read: readKeyMap,
};

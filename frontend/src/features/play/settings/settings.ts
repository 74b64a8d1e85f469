/** Switches of the play page, kept in this browser. */
import { onOff } from "./stored";

export const SHOW_LATENCY = onOff("tril.play.latency", false);
export const SHOW_TARGETS = onOff("tril.play.targets", false);
export const SHOW_GHOST = onOff("tril.play.ghost", false);
export const SOUND = onOff("tril.play.sound", false);

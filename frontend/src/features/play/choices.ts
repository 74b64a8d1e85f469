/** What a player has chosen about playing; kept in this browser. */
import { onOff } from "@/lib/stored";

export const SHOW_LATENCY = onOff("tril.play.latency", false);

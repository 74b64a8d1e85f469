/** Who or what plays, each with a fixed colour and mark on every page. */
import { t } from "@lingui/core/macro";

export const ACTORS = ["imitator", "clone", "person", "demonstrator", "varied"] as const;
export type Actor = (typeof ACTORS)[number];

export const actorNames = (): Readonly<Record<Actor, string>> => ({
  imitator: t`Imitator`,
  clone: t`Clone`,
  person: t`Person`,
  demonstrator: t`Demonstrator`,
  varied: t`Varied play`,
});

/** SVG paths of the marks, in a 10x10 box. */
export const ACTOR_SHAPES: Readonly<Record<Actor, string>> = {
  imitator: "M5 1a4 4 0 1 0 0 8 4 4 0 0 0 0-8",
  clone: "M5 .4 9.6 5 5 9.6.4 5z",
  person: "M5 .8 9.4 9H.6z",
  demonstrator: "M1.4 1.4h7.2v7.2H1.4z",
  varied: "M3.5.8h3v2.7h2.7v3H6.5v2.7h-3V6.5H.8v-3h2.7z",
};

/** Returns the CSS variable of an actor's colour. */
export function actorColour(actor: Actor): string {
  return `var(--${actor})`;
}

type Source = "person" | "scripted" | "policy" | "varied";

const PLAYED_BY: Readonly<Record<Source, Actor>> = {
  person: "person",
  scripted: "demonstrator",
  policy: "imitator",
  varied: "varied",
};

/** Returns who played a recording, by its source; a policy is shown as the imitator. */
export function playedBy(source: Source): Actor {
  return PLAYED_BY[source];
}

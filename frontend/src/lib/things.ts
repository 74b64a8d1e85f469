/** Who or what plays, each with a fixed colour and mark on every page. */

export const THINGS = ["imitator", "clone", "person", "demonstrator"] as const;
export type Thing = (typeof THINGS)[number];

export const THING_NAMES: Readonly<Record<Thing, string>> = {
  imitator: "Imitator",
  clone: "Clone",
  person: "Person",
  demonstrator: "Demonstrator",
};

/** SVG paths of the marks, in a 10x10 box. */
export const THING_SHAPES: Readonly<Record<Thing, string>> = {
  imitator: "M5 1a4 4 0 1 0 0 8 4 4 0 0 0 0-8",
  clone: "M5 .4 9.6 5 5 9.6.4 5z",
  person: "M5 .8 9.4 9H.6z",
  demonstrator: "M1.4 1.4h7.2v7.2H1.4z",
};

/** Returns the CSS variable of a thing's colour. */
export function thingColour(thing: Thing): string {
  return `var(--${thing})`;
}

/** Returns who played a recording, by its source; a policy is shown as the imitator. */
export function playedBy(source: "person" | "scripted" | "policy"): Thing {
  if (source === "person") return "person";
  return source === "scripted" ? "demonstrator" : "imitator";
}

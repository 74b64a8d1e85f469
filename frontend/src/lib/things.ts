/** The four who play, each with its own colour and mark on every page. */

export const THINGS = ["imitator", "clone", "person", "demonstrator"] as const;
export type Thing = (typeof THINGS)[number];

export const THING_NAMES: Readonly<Record<Thing, string>> = {
  imitator: "Imitator",
  clone: "Clone",
  person: "Person",
  demonstrator: "Demonstrator",
};

/** CSS variable of a thing's colour. */
export function thingColour(thing: Thing): string {
  return `var(--${thing})`;
}

/** Who played a recording, by its source. Which policy it was is known by the run alone. */
export function playedBy(source: "person" | "scripted" | "policy"): Thing {
  if (source === "person") return "person";
  return source === "scripted" ? "demonstrator" : "imitator";
}

/** The name of a source, as a badge shows it. */
export const SOURCE_NAMES = {
  person: "person",
  scripted: "scripted",
  policy: "policy",
} as const;

/**
 * Keys of keyboards that differ. Keys that are used for where they lie, such as those that steer, go
 * by `KeyboardEvent.code`; keys that stand for a word, by the sign that they type.
 */
export interface Pressed {
  /** The place on the keyboard, by the names of a US keyboard; "" if it is not known. */
  readonly code: string;
  /** What it types, or its name. */
  readonly key: string;
}

/** Signs of punctuation on a US keyboard. */
const PUNCTUATION: Readonly<Record<string, string>> = {
  Space: " ",
  Minus: "-",
  Equal: "=",
  Period: ".",
};

/** Whether a key types a sign of keyboards with Latin letters, or has a name such as "Enter". */
function isLatin(key: string): boolean {
  return /^(?:[\x20-\x7e]|\p{Script=Latin}|[A-Z]\w+)$/u.test(key) && !UNTYPED.has(key);
}

/** What a browser reports of keys that an input method takes, or that only change the next one. */
const UNTYPED: ReadonlySet<string> = new Set(["Dead", "Process", "Unidentified"]);

/**
 * Returns the signs or names that a key may be meant as, the likeliest first: what it types, in lower
 * case; the digit that is printed on it everywhere, which French keyboards type with Shift; and on
 * keyboards with other letters the sign at its place on a US keyboard.
 */
export function signsOf({ code, key }: Pressed): readonly string[] {
  const signs = isLatin(key) ? [key.length === 1 ? key.toLowerCase() : key] : [];
  const [, letter, digit] = /^(?:Key([A-Z])|(?:Digit|Numpad)(\d))$/.exec(code) ?? [];
  if (digit !== undefined) return [...signs, digit];
  if (signs.length > 0) return signs;
  const sign = letter?.toLowerCase() ?? PUNCTUATION[code];
  return sign === undefined ? [] : [sign];
}

/** Returns what is at a key's likeliest sign that a table has; undefined if it has none. */
export function ofSigns<T>(table: Readonly<Record<string, T>>, pressed: Pressed): T | undefined {
  const sign = signsOf(pressed).find((candidate) => Object.hasOwn(table, candidate));
  return sign === undefined ? undefined : table[sign];
}

/** Returns a key's place; on-screen and remote keyboards name only what it types. */
export function placeOf({ code, key }: Pressed): string {
  if (code !== "" && code !== "Unidentified") return code;
  if (key === " ") return "Space";
  return /^[a-z]$/i.test(key) ? `Key${key.toUpperCase()}` : key;
}

/** Key presses as different keyboards make them. */
import type { Pressed } from "@/lib/browser/pressed-keys";

const US: Readonly<Record<string, string>> = {
  Space: " ",
  Minus: "-",
  Equal: "=",
  Period: ".",
  NumpadEnter: "Enter",
  NumpadAdd: "+",
  NumpadSubtract: "-",
};

/** A key of a US keyboard. */
export function us(code: string): Pressed {
  const sign = /^(?:Key|Digit)(.)$/.exec(code)?.[1]?.toLowerCase();
  return { code, key: US[code] ?? sign ?? code };
}

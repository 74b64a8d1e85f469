import { expect, it } from "vitest";

import { actOf } from "@/components/in-step/answer-keys";

const key = (name: string, more = {}) =>
  actOf(
    {
      code: "",
      key: name,
      ctrlKey: false,
      metaKey: false,
      altKey: false,
      shiftKey: false,
      ...more,
    },
    { skip: ["s"], worst: ["w"] },
  );

it("keys answer by arrows, digits and letters, in either case", () => {
  expect(["ArrowLeft", "1", "=", "0", "ArrowRight", "2"].map((name) => key(name))).toEqual([
    "first",
    "first",
    "equal",
    "equal",
    "second",
    "second",
  ]);
  expect(["s", "S", "w", "u", "Backspace", " "].map((name) => key(name))).toEqual([
    "skip",
    "skip",
    "worst",
    "undo",
    "undo",
    "play",
  ]);
});

it("keys are those of any keyboard", () => {
  expect(key("é", { code: "Digit2" })).toBe("second");
  expect(key("ы", { code: "KeyS" })).toBe("skip");
  expect(key("я", { code: "KeyZ", ctrlKey: true })).toBe("undo");
  expect(key(",", { code: "KeyW" })).toBeNull();
});

it("keys with a modifier are the browser's, but for Ctrl+Z", () => {
  expect(key("s", { ctrlKey: true })).toBeNull();
  expect(key("ArrowLeft", { altKey: true })).toBeNull();
  expect(key("z", { ctrlKey: true })).toBe("undo");
  expect(key("z", { metaKey: true })).toBe("undo");
  expect(key("Z", { ctrlKey: true, shiftKey: true })).toBeNull();
  expect(key("x")).toBeNull();
});

import { describe, expect, it } from "vitest";

import {
  ago,
  bounds,
  bytes,
  duration,
  fixed,
  measured,
  ordinal,
  percent,
  remaining,
  shortCount,
  stepLabels,
  tickLabels,
  whole,
} from "@/lib/format";

describe("numbers", () => {
  it.each([
    [20_000, "20\u00a0k"],
    [1_500_000, "1.5\u00a0M"],
    [10_000_000, "10\u00a0M"],
    [1_234, "1,234"],
    [12_345, "12,345"],
    [0, "0"],
  ])("%d is short %s", (n, text) => expect(shortCount(n)).toBe(text));

  it.each([
    [0, "0.00"],
    [0.1234, "0.12"],
    [12.34, "12.3"],
    [123.4, "123"],
    [12345.6, "12,346"],
    [-1.5, "−1.50"],
    [0.00012, "1.2e−4"],
    [Number.NaN, "–"],
  ])("%d is measured as %s", (n, text) => expect(measured(n)).toBe(text));

  it("has a real minus sign, and none before zero", () => {
    expect(fixed(-0.04, 1)).toBe("0.0");
    expect(fixed(-2, 1)).toBe("−2.0");
    expect(whole(-1200)).toBe("−1,200");
  });

  it("carries units and intervals", () => {
    expect(percent(0.984)).toBe("98.4%");
    expect(bounds({ mean: 4.7, low: 3.9, high: 5.42, n: 23 })).toBe("3.9 to 5.4");
  });

  it.each([
    [1, "1st"],
    [2, "2nd"],
    [3, "3rd"],
    [4, "4th"],
    [11, "11th"],
    [12, "12th"],
    [21, "21st"],
    [36, "36th"],
  ])("%d is the %s", (n, text) => expect(ordinal(n)).toBe(text));
});

describe("sizes and times", () => {
  it.each([
    [999, "999\u00a0B"],
    [1_500, "1.5\u00a0kB"],
    [14_200, "14\u00a0kB"],
    [2_500_000, "2.5\u00a0MB"],
    [999_900, "1.0\u00a0MB"],
  ])("%d bytes are %s", (n, text) => expect(bytes(n)).toBe(text));

  it.each([
    [12.4, "12\u00a0s"],
    [59.6, "1\u00a0min"],
    [1020, "17\u00a0min"],
    [3599, "1\u00a0h 00\u00a0min"],
    [7500, "2\u00a0h 05\u00a0min"],
    [400_000, "5 days"],
  ])("%d s last %s", (s, text) => expect(duration(s)).toBe(text));

  it("passes from minutes to dates", () => {
    const now = Date.parse("2026-03-10T12:00:00Z");
    expect(ago("2026-03-10T11:59:50Z", now)).toBe("just now");
    expect(ago("2026-03-10T11:55:00Z", now)).toBe("5 min ago");
    expect(ago("2026-03-10T09:00:00Z", now)).toBe("3 h ago");
    expect(ago("2026-03-01T12:00:00Z", now)).toBe("Mar 1, 2026");
  });
});

describe("the remaining time", () => {
  it.each([
    [20, "less than a minute left"],
    [540, "about 9\u00a0min left"],
    [1000, "about 15\u00a0min left"],
    [3500, "about 1\u00a0h 00\u00a0min left"],
    [5000, "about 1\u00a0h 30\u00a0min left"],
  ])("of %d s is told coarsely: %s", (s, text) => expect(remaining(s)).toBe(text));
});

describe("ticks", () => {
  it.each([
    [
      [0, 0.25, 0.5],
      ["0.00", "0.25", "0.50"],
    ],
    [
      [0, 0.2, 0.4, 0.6000000000000001],
      ["0.0", "0.2", "0.4", "0.6"],
    ],
    [
      [0.001, 0.0015],
      ["0.0010", "0.0015"],
    ],
    [
      [0, 2000],
      ["0", "2,000"],
    ],
  ])("%j have as many digits as their distance needs", (ticks, labels) => {
    expect(tickLabels(ticks)).toEqual(labels);
  });

  it.each([
    [
      [0, 500_000, 1_000_000, 1_500_000],
      ["0", "500\u00a0k", "1\u00a0M", "1.5\u00a0M"],
    ],
    [
      [1_230_000, 1_235_000],
      ["1.23\u00a0M", "1.235\u00a0M"],
    ],
    [
      [12_000, 12_050],
      ["12\u00a0k", "12.05\u00a0k"],
    ],
    [
      [10_000, 20_000],
      ["10\u00a0k", "20\u00a0k"],
    ],
    [
      [1, 1.5],
      ["1.0", "1.5"],
    ],
  ])("of steps at %j are told apart", (ticks, labels) => {
    expect(stepLabels(ticks)).toEqual(labels);
  });
});

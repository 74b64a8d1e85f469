import { describe, expect, it } from "vitest";

import {
  furtherPlayer,
  nextStart,
  playerName,
  PLAYERS,
  readChoice,
  writeChoice,
} from "@/features/play/watch/choice";

const read = (text: string) => readChoice(new URLSearchParams(text));

describe("the choice of what is watched", () => {
  it("is the address", () => {
    for (const text of [
      "player=imitator.greedy&start=0",
      "player=clone.sticky&player=imitator.sampled&start=31",
      "player=clone.greedy&draw=123456",
    ]) {
      expect(writeChoice(read(text)).toString()).toBe(text);
    }
  });

  it("replaces what makes no sense", () => {
    expect(read("")).toEqual({ players: ["imitator.greedy"], start: 0, draw: 0 });
    expect(read("player=king.greedy&player=clone.greedy&start=32")).toEqual({
      players: ["clone.greedy"],
      start: 0,
      draw: 0,
    });
    expect(read("draw=-1&start=5").start).toBe(5);
    expect(read(PLAYERS.map((player) => `player=${player}`).join("&")).players).toHaveLength(4);
  });

  it("goes on to the next start, and from a drawn one to another", () => {
    expect(nextStart(read("start=4")).start).toBe(5);
    expect(nextStart(read("start=31")).start).toBe(0);
    const drawn = nextStart(read("draw=7"));
    expect(drawn.start).toBeNull();
    expect(drawn.draw).not.toBe(7);
  });

  it("adds the first player that does not play yet", () => {
    expect(furtherPlayer(["imitator.greedy"])).toBe("imitator.sampled");
    expect(furtherPlayer(PLAYERS)).toBe("imitator.sampled");
    expect(playerName("clone.sticky")).toBe("Clone, sticky");
  });
});

import { fireEvent, render, screen } from "@testing-library/react";
import { describe, expect, it, vi } from "vitest";

import type { TaughtGame } from "@/api/types";
import { TouchPad } from "@/features/play/input/TouchPad";
import { GameProvider } from "@/games/game";

import { BLACKJACK, MS_PACMAN, SPACE_INVADERS } from "../../../support/games";

function open(game: TaughtGame) {
  const [onHold, onRelease] = [vi.fn(), vi.fn()];
  render(
    <GameProvider game={game} settings={{ options: {} }}>
      <TouchPad idle={false} onHold={onHold} onRelease={onRelease} />
    </GameProvider>,
  );
  return { onHold, onRelease, held: () => onHold.mock.lastCall?.[1] as number };
}

const names = () => screen.queryAllByRole("button").map((one) => one.getAttribute("aria-label"));

describe("the touch pad", () => {
  it("has a button for each way of a game that goes left and right", () => {
    open(SPACE_INVADERS);
    expect(names()).toEqual(["Left", "Right", "Fire"]);
    expect(screen.queryByRole("img")).toBeNull();
  });

  it("has a button for each named button", () => {
    const { held } = open(BLACKJACK);
    expect(names()).toEqual(["Stick", "Hit"]);
    const right = screen.getByRole("button", { name: "Hit" });
    right.setPointerCapture = vi.fn();
    fireEvent.pointerDown(right, { pointerId: 3 });
    expect(held()).toBe(2);
  });

  it("lets a thumb slide between eight directions where a game goes up and down", () => {
    const { held, onRelease } = open({ ...MS_PACMAN, buttons: ["fire", ...MS_PACMAN.buttons] });
    expect(names()).toEqual(["Fire"]);
    const pad = screen.getByRole("img", { name: "Directions: slide your thumb" });
    pad.setPointerCapture = vi.fn();
    pad.hasPointerCapture = () => true;
    vi.spyOn(pad, "getBoundingClientRect").mockReturnValue(new DOMRect(100, 0, 200, 200));
    fireEvent.pointerDown(pad, { pointerId: 1, clientX: 290, clientY: 100 });
    expect(held()).toBe(4);
    fireEvent.pointerMove(pad, { pointerId: 1, clientX: 270, clientY: 30 });
    expect(held()).toBe(4 | 8);
    fireEvent.pointerMove(pad, { pointerId: 1, clientX: 200, clientY: 190 });
    expect(held()).toBe(16);
    fireEvent.pointerUp(pad, { pointerId: 1 });
    expect(onRelease).toHaveBeenCalledWith("directions-1");
  });
});

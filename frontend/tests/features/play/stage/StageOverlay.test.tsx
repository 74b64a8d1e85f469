import { render, screen } from "@testing-library/react";
import { describe, expect, it, vi } from "vitest";

import { StageOverlay } from "@/features/play/stage/StageOverlay";
import type { GameState, Phase } from "@/features/play/stream/game-state";
import { GameProvider } from "@/games/game";

import { SPACE_INVADERS } from "../../../support/games";

function state(phase: Phase): GameState {
  return { phase, seconds: 0, hits: [], why: "", ended: null, endedAt: 0, speed: 100 };
}

function lay(game: GameState | null, error: string | null = null) {
  const nothing = vi.fn();
  render(
    <GameProvider game={SPACE_INVADERS} settings={{ options: {} }}>
      <StageOverlay
        state={game}
        target={null}
        starting={false}
        error={error}
        onStart={nothing}
        onResume={nothing}
        onStep={nothing}
        onTakeBack={nothing}
      />
    </GameProvider>,
  );
}

describe("what lies over the game's screen", () => {
  it("says that all places are taken and that the game continues by itself", () => {
    lay(state("full"));
    expect(screen.getByRole("status")).toHaveTextContent("All places are taken");
    expect(screen.getByText(/yours continues as soon as one of them ends/)).toBeVisible();
    expect(screen.queryByRole("button")).toBeNull();
  });

  it("says what the server says when no game can be begun, and offers another try", () => {
    lay(null, "All 32 places are taken at the moment. Games are short: try again in a minute.");
    expect(screen.getByText(/try again in a minute/)).toBeVisible();
    expect(screen.getByRole("button", { name: "Try again" })).toBeEnabled();
  });

  it("says that an idle game ended and is kept", () => {
    lay(state("gone"));
    expect(screen.getByText(/It was idle for a while/)).toHaveTextContent("is kept");
    expect(screen.getByRole("button", { name: "Start game" })).toBeEnabled();
  });
});

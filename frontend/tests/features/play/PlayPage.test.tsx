import { act, screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { zlibSync } from "fflate";
import { beforeEach, describe, expect, it, vi } from "vitest";

import type { Pad } from "@/features/play/input/gamepad";
import { defaultKeys } from "@/features/play/input/keys";
import { PlayPage } from "@/features/play/PlayPage";
import { Sounds } from "@/features/play/sound/sounds";
import { SilenceWatch } from "@/lib/browser/silence";

import { behaviour, recording } from "../../support/data";
import { SPACE_INVADERS } from "../../support/games";
import { show } from "../../support/page";
import { Refusal, serve } from "../../support/server";
import { denyStorage } from "../../support/storage";

const DEFAULT_KEYS = defaultKeys(SPACE_INVADERS);
const SCREEN_BYTES = 160 * 210;

/** The server's end of the stream, controlled by the test. */
class FakeSocket extends EventTarget {
  static readonly OPEN = 1;
  static last: FakeSocket | null = null;
  static opened = 0;
  readyState = FakeSocket.OPEN;
  binaryType = "blob";
  readonly sent: (string | ArrayBuffer)[] = [];

  constructor() {
    super();
    FakeSocket.last = this;
    FakeSocket.opened += 1;
  }

  send(data: string | ArrayBuffer): void {
    this.sent.push(data);
  }

  close(): void {
    this.readyState = 3;
  }
}

function tell(message: object): void {
  act(() => {
    FakeSocket.last?.dispatchEvent(new MessageEvent("message", { data: JSON.stringify(message) }));
  });
}

/** The keys of each INPUT that was sent. */
function inputs(): number[] {
  return (FakeSocket.last?.sent ?? [])
    .filter((one) => typeof one !== "string")
    .map((one) => new Uint8Array(one)[1] ?? -1);
}

const HELLO = {
  type: "hello",
  width: 160,
  height: 210,
  palette: [],
  max_frames: 1200,
  frame: 0,
  resumed: false,
  hits: [],
  speed_percent: 100,
  overlay: {
    painter: "alien-formation",
    geometry: { width: 8, height: 10, column_px: 16, row_px: 18 },
  },
};
const ENDED = {
  type: "ended",
  reason: "hit",
  frame: 558,
  hits: [{ row: 0, column: 0, frame: 99, on_target: true }],
  targets: 1,
  strays: 0,
  order_errors: null,
  recording_id: 7,
  verification: "verified",
  verification_note: "",
};

const GHOST = {
  recording_id: 5,
  number: 2,
  source: "person",
  lefts: [34, 34, 35],
  top: 185,
  width: 7,
  height: 10,
};

let ghost: typeof GHOST | null = GHOST;
let undecided: readonly number[] = [];
const STANDARD = { id: "Pad", index: 0, connected: true, mapping: "standard" };

let pads: readonly (Pad | null)[] = [];

function open(one = behaviour()) {
  const asked = serve({
    "GET /api/behaviours/1/ghost": () => ghost,
    "GET /api/behaviours/1/recordings": () =>
      undecided.map((id) => recording({ id, number: id - 5, state: "finished" })),
    "POST /api/games": () => ({
      id: "g1",
      recording_id: 7,
      behaviour_id: 1,
      frame: 0,
      max_frames: 1200,
      stream_path: "/api/games/g1/stream",
    }),
    "POST /api/games/from/7": () => ({
      id: "g2",
      recording_id: 8,
      behaviour_id: 1,
      frame: 438,
      max_frames: 1200,
      stream_path: "/api/games/g2/stream",
    }),
    "GET /api/behaviours/1/checklist": () => ({
      planned: [
        {
          number: 1,
          description: "2 of 2 target aliens, no other",
          recording_id: 5,
          recording_number: 1,
        },
        {
          number: 2,
          description: "1 of 2 target aliens, no other",
          recording_id: null,
          recording_number: null,
        },
        { number: 3, description: "No alien is hit", recording_id: null, recording_number: null },
      ],
      note: "",
    }),
    "GET /api/games/g1": () => new Refusal(404, { detail: "Over." }),
    "POST /api/recordings/7/keep": () => recording({ id: 7, number: 3 }),
    "POST /api/recordings/7/discard": () => recording({ id: 7, number: 3, deleted: true }),
    "POST /api/recordings/7/restore": () => recording({ id: 7, number: 3 }),
    "PATCH /api/recordings/7": () => recording({ id: 7, perfect: true }),
  });
  show(<PlayPage behaviour={one} />);
  return asked;
}

async function start(one = behaviour()) {
  const asked = open(one);
  await userEvent.click(screen.getByRole("button", { name: "Start game" }));
  await waitFor(() => expect(FakeSocket.last).not.toBeNull());
  tell(HELLO);
  tell({ type: "countdown", seconds: 0 });
  return asked;
}

/** Shows a frame with the aliens where they begin. */
function frame(number: number, { hasCounted = false } = {}): void {
  const payload = zlibSync(new Uint8Array(SCREEN_BYTES));
  const data = new Uint8Array(16 + payload.length);
  data.set([1, hasCounted ? 3 : 1, 23 + 96, 31, number, 0, 0, 0, number]);
  data.set(payload, 16);
  act(() => {
    FakeSocket.last?.dispatchEvent(new MessageEvent("message", { data: data.buffer }));
  });
}

async function end(change: Partial<Record<keyof typeof ENDED, unknown>> = {}) {
  const asked = await start();
  tell({ ...ENDED, ...change });
  // Presses just after the end are still meant for the game.
  const now = performance.now();
  vi.spyOn(performance, "now").mockImplementation(() => now + 5000);
  const did = () => asked.filter(({ method }) => method !== "GET").map(({ path }) => path);
  return { asked, did };
}

beforeEach(() => {
  // The server of these tests says nothing by itself, and their machine may stand still.
  vi.spyOn(SilenceWatch.prototype, "start").mockReturnValue();
  FakeSocket.last = null;
  FakeSocket.opened = 0;
  vi.stubGlobal("WebSocket", FakeSocket);
  pads = [];
  ghost = GHOST;
  undecided = [];
  // jsdom has none of it.
  Object.defineProperty(navigator, "getGamepads", { configurable: true, value: () => pads });
});

describe("the demonstrations to play", () => {
  it("are ticked where a recording shows them", async () => {
    open();
    const list = within(await screen.findByRole("list", { name: "Demonstrations, best first" }));
    const [first, second] = list.getAllByRole("listitem");
    expect(first).toHaveTextContent("2 of 2 target aliens, no other Recording 1");
    expect(second).toHaveTextContent("1 of 2 target aliens, no other, missing");
    expect(screen.getByText("Demonstrations: 1 of 3")).toBeVisible();
    expect(screen.getByText(/^Next: 1 of 2 target aliens/)).toBeVisible();
  });
});

describe("playing", () => {
  it("needs no storage", async () => {
    const allow = denyStorage();
    try {
      await start();
      expect(screen.getByRole("timer", { name: "Time left" })).toBeVisible();
    } finally {
      allow();
    }
  });

  it("counts down, then passes the held keys on", async () => {
    open();
    await userEvent.click(screen.getByRole("button", { name: "Start game" }));
    await waitFor(() => expect(FakeSocket.last).not.toBeNull());
    tell(HELLO);
    tell({ type: "countdown", seconds: 3 });
    expect(screen.getByText("3")).toBeVisible();
    tell({ type: "countdown", seconds: 0 });
    expect(screen.getByRole("application")).toHaveFocus();
    await userEvent.keyboard("{ArrowRight>}{ >}{/ArrowRight}{/ }");
    expect(inputs()).toEqual([2, 6, 4, 0]);
  });

  it("releases all keys when the window loses the focus", async () => {
    await start();
    await userEvent.keyboard("{a>}");
    act(() => {
      window.dispatchEvent(new Event("blur"));
    });
    expect(inputs()).toEqual([1, 0]);
  });

  it("shows the pad, the time and the score where the picture fills the screen", async () => {
    await start();
    tell({ type: "hit", row: 0, column: 0, frame: 6, on_target: true });
    frame(60);
    const filling = screen.getByRole("application").parentElement;
    if (!filling) throw new Error("Expected the stage to have a parent.");
    const request = vi.fn(() => Promise.resolve());
    filling.requestFullscreen = request;
    await userEvent.keyboard("f");
    expect(request).toHaveBeenCalledOnce();
    expect(within(filling).getByRole("group", { name: "Touch controls" })).toBeInTheDocument();
    expect(within(filling).getByText("19.0")).toBeInTheDocument();
    expect(within(filling).getByText("1 of 2 targets, 0 strays")).toBeInTheDocument();
  });

  it("begins the first game by the space bar", async () => {
    const asked = open();
    await userEvent.keyboard(" ");
    await waitFor(() => expect(FakeSocket.opened).toBe(1));
    expect(asked.filter(({ method }) => method === "POST")).toHaveLength(1);
  });

  it("takes hits back while it rewinds", async () => {
    await start();
    tell({ type: "hit", row: 0, column: 0, frame: 50, on_target: true });
    frame(60);
    expect(screen.getByText("Targets hit").nextSibling).toHaveTextContent("1 of 2");
    await userEvent.keyboard("{Backspace>}");
    frame(52);
    expect(screen.getByText("Targets hit").nextSibling).toHaveTextContent("1 of 2");
    frame(49);
    expect(screen.getByText("Targets hit").nextSibling).toHaveTextContent("0 of 2");
    await userEvent.keyboard("{/Backspace}");
  });

  it("counts targets and strays as they are hit", async () => {
    await start();
    tell({ type: "hit", row: 0, column: 0, frame: 99, on_target: true, targets: 1, strays: 0 });
    tell({ type: "hit", row: 3, column: 4, frame: 150, on_target: false, targets: 1, strays: 1 });
    expect(screen.getByRole("img", { name: "1 of 2 targets hit, 1 stray" })).toBeVisible();
  });

  it("pauses and goes on by key", async () => {
    await start();
    await userEvent.keyboard("{Escape}");
    tell({ type: "paused", why: "You paused the game." });
    expect(screen.getByText("You paused the game.")).toBeVisible();
    await userEvent.keyboard("{Enter}");
    const commands = FakeSocket.last?.sent.filter((one) => typeof one === "string");
    expect(commands).toEqual(['{"type":"ready"}', '{"type":"pause"}', '{"type":"go_on"}']);
  });

  it("pauses for the help, once", async () => {
    await start();
    await userEvent.keyboard("?");
    tell({ type: "paused", why: "You paused the game." });
    await userEvent.keyboard("?");
    const commands = FakeSocket.last?.sent.filter((one) => typeof one === "string");
    expect(commands).toEqual(['{"type":"ready"}', '{"type":"pause"}']);
  });

  it("goes slower by key and button, and says so to the server", async () => {
    await start();
    await userEvent.keyboard("-");
    expect(screen.getByRole("button", { name: "75%" })).toHaveAttribute("aria-pressed", "true");
    await userEvent.click(screen.getByRole("button", { name: "25%" }));
    expect(screen.getByRole("application")).toHaveFocus();
    expect(FakeSocket.last?.sent.slice(1)).toEqual([
      '{"type":"speed","percent":75}',
      '{"type":"speed","percent":25}',
    ]);
  });

  it("plays frame by frame with the keys held", async () => {
    await start();
    await userEvent.keyboard(".");
    tell({ type: "paused", why: "You paused the game." });
    await userEvent.keyboard("{a>}.");
    expect(screen.queryByText("Paused")).toBeNull();
    expect(screen.getByText(/Frame by frame/)).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: /^One frame/ }));
    const commands = FakeSocket.last?.sent.filter((one) => typeof one === "string");
    expect(commands?.slice(1)).toEqual(['{"type":"pause"}', '{"type":"step"}', '{"type":"step"}']);
    expect(inputs()).toEqual([1]);
  });

  it("rewinds while the key is held and the window has the focus", async () => {
    await start();
    const user = userEvent.setup();
    await user.keyboard("{Backspace>}");
    expect(screen.getByText(/Rewinding/)).toBeVisible();
    await user.keyboard("{/Backspace}");
    tell({ type: "rewound", frame: 0, hits: [], recording_id: 6 });
    tell({ type: "countdown", seconds: 0 });
    await user.keyboard("{Backspace>}");
    act(() => {
      window.dispatchEvent(new Event("blur"));
    });
    const commands = FakeSocket.last?.sent.filter((one) => typeof one === "string");
    expect(commands?.slice(1)).toEqual([
      '{"type":"rewind"}',
      '{"type":"release"}',
      '{"type":"rewind"}',
      '{"type":"release"}',
    ]);
  });

  it("plays with reassigned keys and stores them", async () => {
    await start();
    await userEvent.click(screen.getByRole("button", { name: "Change the keys" }));
    const left = within(screen.getByRole("listitem", { name: "Left" }));
    await userEvent.click(left.getByRole("button", { name: "Add a key" }));
    await userEvent.keyboard("j");
    await userEvent.click(left.getByRole("button", { name: "Remove A from Left" }));
    expect(inputs()).toEqual([]);
    await userEvent.click(screen.getByRole("button", { name: "Close" }));
    await userEvent.keyboard("{j>}{a>}");
    expect(inputs()).toEqual([1]);
    const stored = JSON.parse(localStorage.getItem("tril.play.keys") ?? "") as { left: string[] };
    expect(stored.left).toEqual(["ArrowLeft", "KeyJ"]);
  });

  it.each([
    ["Cmd is pressed", "keydown", { key: "Meta", code: "MetaLeft", metaKey: true }],
    ["Cmd is released", "keyup", { key: "Meta", code: "MetaLeft" }],
    ["the window loses the focus", "blur", {}],
    ["a context menu opens", "contextmenu", {}],
  ])("lets every key go when %s", async (_name, type, init) => {
    await start();
    await userEvent.keyboard("{ArrowLeft>}{ >}");
    expect(inputs().at(-1)).toBe(5);
    act(() => {
      window.dispatchEvent(new KeyboardEvent(type, init));
    });
    expect(inputs().at(-1)).toBe(0);
  });

  it("lets every key go, and pauses, when its tab is hidden", async () => {
    await start();
    await userEvent.keyboard("{ArrowLeft>}");
    vi.spyOn(document, "hidden", "get").mockReturnValue(true);
    act(() => {
      document.dispatchEvent(new Event("visibilitychange", { bubbles: true }));
    });
    expect(inputs().at(-1)).toBe(0);
    expect(FakeSocket.last?.sent).toContain('{"type":"pause"}');
    vi.restoreAllMocks();
  });

  it("steers by the arrows of a numeric pad, too", async () => {
    await start();
    const press = (type: string) =>
      act(() => {
        window.dispatchEvent(new KeyboardEvent(type, { code: "Numpad4", key: "ArrowLeft" }));
      });
    press("keydown");
    expect(inputs().at(-1)).toBe(1);
    press("keyup");
    expect(inputs().at(-1)).toBe(0);
  });

  it("shows the key that is assigned to rewinding", async () => {
    localStorage.setItem("tril.play.keys", JSON.stringify({ ...DEFAULT_KEYS, rewind: ["KeyB"] }));
    await start();
    expect(screen.getByRole("button", { name: "Rewind B" })).toBeVisible();
  });

  it("gives a control no key that belongs to the browser", async () => {
    await start();
    await userEvent.click(screen.getByRole("button", { name: "Change the keys" }));
    const fire = within(screen.getByRole("listitem", { name: "Fire" }));
    await userEvent.click(fire.getByRole("button", { name: "Add a key" }));
    await userEvent.keyboard("{Control}");
    expect(fire.getByRole("button", { name: "Press a key" })).toBeVisible();
    await userEvent.keyboard("j");
    expect(fire.getByRole("button", { name: "Remove J from Fire" })).toBeVisible();
  });

  it("plays with a gamepad", async () => {
    const buttons = Array.from({ length: 17 }, () => ({ pressed: false }));
    const pad = { ...STANDARD, axes: [0, 0], buttons };
    pads = [null, pad];
    vi.spyOn(document, "hasFocus").mockReturnValue(true);
    await start();
    await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    pad.axes[0] = -1;
    await waitFor(() => expect(inputs()).toEqual([1]));
    buttons[0] = { pressed: true };
    await waitFor(() => expect(inputs()).toEqual([1, 5]));
    pad.axes[0] = 0;
    buttons[0] = { pressed: false };
    await waitFor(() => expect(inputs().at(-1)).toBe(0));
    buttons[9] = { pressed: true };
    await waitFor(() => expect(FakeSocket.last?.sent.at(-1)).toBe('{"type":"pause"}'));
  });

  it("starts the first game with a gamepad, by a button that was not held before", async () => {
    const buttons = Array.from({ length: 17 }, (_, n) => ({ pressed: n === 9 }));
    pads = [{ ...STANDARD, axes: [0, 0], buttons }];
    vi.spyOn(document, "hasFocus").mockReturnValue(true);
    const asked = open();
    const begun = () => asked.filter(({ path }) => path === "/api/games");
    await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    expect(begun()).toEqual([]);
    buttons[9] = { pressed: false };
    await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    buttons[9] = { pressed: true };
    await waitFor(() => expect(FakeSocket.last).not.toBeNull());
    tell(HELLO);
    tell({ type: "countdown", seconds: 0 });
    // The same press does not pause the game that it has started.
    await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    expect(FakeSocket.last?.sent).toEqual(['{"type":"ready"}']);
    expect(begun()).toHaveLength(1);
  });

  it("outlines the targets by key and by button, and says what the outlines mean", async () => {
    const strokeRect = vi.fn();
    const context = { clearRect: vi.fn(), strokeRect, fillRect: vi.fn() };
    await start();
    frame(1);
    vi.spyOn(HTMLCanvasElement.prototype, "getContext").mockReturnValue(
      context as unknown as RenderingContext,
    );
    await userEvent.keyboard("t");
    expect(strokeRect).toHaveBeenCalledTimes(2);
    const legend = screen.getByRole("list", { name: "Drawn over the game, and not recorded" });
    expect(legend).toHaveTextContent("remaining targets");
    frame(2);
    tell({ type: "hit", row: 0, column: 0, frame: 3, on_target: true, targets: 1, strays: 0 });
    frame(3);
    expect(strokeRect).toHaveBeenCalledTimes(3);
    const button = screen.getByRole("button", { name: /^Outline targets/ });
    expect(button).toHaveAttribute("aria-pressed", "true");
    await userEvent.click(button);
    expect(legend).not.toBeInTheDocument();
    frame(4);
    expect(strokeRect).toHaveBeenCalledTimes(3);
    expect(localStorage.getItem("tril.play.targets")).toBe("false");
  });

  it("shows the ghost of the best demonstration and names its recording", async () => {
    const asked = await start(behaviour({ n_ranked: 2 }));
    const fetched = () => asked.filter(({ path }) => path.endsWith("/ghost"));
    expect(fetched()).toEqual([]);
    await userEvent.keyboard("g");
    const legend = within(await screen.findByRole("list", { name: /^Drawn over the game/ }));
    expect(legend.getByRole("link", { name: "Recording 2" })).toBeVisible();
    await userEvent.keyboard("gg");
    expect(fetched()).toHaveLength(1);
    expect(localStorage.getItem("tril.play.ghost")).toBe("true");
  });

  it("offers neither outlines nor a ghost where there is nothing to show", async () => {
    await start(behaviour({ target: null }));
    await userEvent.keyboard("tg");
    expect(screen.queryByRole("button", { name: /^Outline targets/ })).toBeNull();
    expect(screen.queryByRole("button", { name: /^Ghost/ })).toBeNull();
    expect(screen.queryByRole("list", { name: /^Drawn over/ })).toBeNull();
  });

  it("offers no ghost once the server knows of none", async () => {
    ghost = null;
    await start(behaviour({ n_perfect: 1 }));
    await userEvent.click(screen.getByRole("button", { name: /^Ghost/ }));
    await waitFor(() => expect(screen.queryByRole("button", { name: /^Ghost/ })).toBeNull());
  });

  it("plays sounds for shots, hits and the end if sound is on", async () => {
    const heard: string[] = [];
    vi.spyOn(Sounds.prototype, "play").mockImplementation((name) => void heard.push(name));
    const close = vi.spyOn(Sounds.prototype, "close").mockReturnValue(undefined);
    vi.stubGlobal("AudioContext", vi.fn());
    await start();
    frame(1, { hasCounted: true });
    await userEvent.keyboard("m");
    frame(2, { hasCounted: true });
    frame(3);
    await Promise.resolve();
    tell({ type: "hit", row: 0, column: 0, frame: 3, on_target: true, targets: 1, strays: 0 });
    tell({ type: "hit", row: 0, column: 3, frame: 9, on_target: false, targets: 1, strays: 1 });
    expect(heard).toEqual(["shot", "target", "stray"]);
    tell({ type: "rewound", frame: 0, hits: [], recording_id: 6 });
    tell(ENDED);
    expect(heard).toEqual(["shot", "target", "stray", "end"]);
    await userEvent.click(screen.getByRole("button", { name: /^Sound/ }));
    expect(close).toHaveBeenCalledOnce();
  });

  it("shows the latency by key and by button, also in the next game", async () => {
    await start();
    expect(screen.queryByLabelText("Latency")).toBeNull();
    await userEvent.keyboard("l");
    expect(screen.getByLabelText("Latency")).toHaveTextContent("key to draw, p50–");
    await userEvent.click(screen.getByRole("button", { name: /^Latency/ }));
    expect(screen.queryByLabelText("Latency")).toBeNull();
    expect(localStorage.getItem("tril.play.latency")).toBe("false");
  });

  it("says when another tab has taken the game over, and can take it back", async () => {
    await start();
    tell({ type: "taken_over" });
    expect(screen.getByText("This game is open in another tab now")).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Play here" }));
    expect(FakeSocket.opened).toBe(2);
  });

  it("says why a game can't be started", async () => {
    serve({ "POST /api/games": () => new Refusal(503, { detail: "The disk is full." }) });
    show(<PlayPage behaviour={behaviour()} />);
    await userEvent.click(screen.getByRole("button", { name: "Start game" }));
    expect(await screen.findByText("The disk is full.")).toBeVisible();
    expect(screen.getByRole("button", { name: "Try again" })).toBeEnabled();
  });
});

describe("games that nobody decided about", () => {
  it("are asked about, the one on the screen apart", async () => {
    undecided = [6, 7];
    const { did } = await end();
    expect(await screen.findByText("1 game waits for your decision")).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Keep Recording 1" }));
    expect(did()).toContain("/api/recordings/6/keep");
    expect(screen.queryByRole("button", { name: "Keep Recording 2" })).toBeNull();
  });
});

describe("after the end", () => {
  it("says how it ended and keeps the game by key", async () => {
    const { did } = await end();
    expect(screen.getByText("Hit by a bomb after 9.3 s")).toBeVisible();
    expect(screen.getByText("1 of 2 targets, no strays")).toBeVisible();
    await userEvent.keyboard("k");
    expect(await screen.findByText("Kept as recording 3.")).toBeVisible();
    expect(did()).toEqual(["/api/games", "/api/recordings/7/keep"]);
    expect(screen.queryByRole("button", { name: /^Keep/ })).toBeNull();
  });

  it("says that nothing was played, and keeps nothing", async () => {
    const { did } = await end({ reason: null, frame: 3, hits: [], targets: 0 });
    expect(screen.getByText("Nothing was played")).toBeVisible();
    await waitFor(() => expect(did()).toContain("/api/recordings/7/discard"));
    await userEvent.keyboard("kpx{Backspace}");
    for (const name of [/^Keep/, /^Perfect/, /^Discard/]) {
      expect(screen.queryByRole("button", { name })).toBeNull();
    }
    await userEvent.keyboard(" ");
    await waitFor(() => expect(FakeSocket.opened).toBe(2));
    expect(did()).toEqual(["/api/games", "/api/recordings/7/discard", "/api/games"]);
  });

  it("discards by key, with a way back", async () => {
    const { did } = await end();
    // It moves to the right, and may still be pressed.
    await userEvent.keyboard("d");
    expect(did()).toEqual(["/api/games"]);
    await userEvent.keyboard("x");
    expect(await screen.findByText("Discarded.")).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Undo" }));
    expect(await screen.findByText("Kept as recording 3.")).toBeVisible();
    expect(did().at(-1)).toBe("/api/recordings/7/restore");
  });

  it("keeps what is marked as perfect", async () => {
    const { asked, did } = await end();
    await userEvent.keyboard("p");
    expect(screen.getByRole("dialog", { name: "Mark as perfect?" })).toHaveTextContent(
      "it missed 1 target, it was lost: hit by a bomb",
    );
    expect(did()).toEqual(["/api/games"]);
    expect(screen.getByRole("button", { name: "Don’t mark" })).toHaveFocus();
    await userEvent.click(screen.getByRole("button", { name: "Mark all the same" }));
    expect(await screen.findByText("Kept as recording 3, marked as perfect.")).toBeVisible();
    expect(did()).toContain("/api/recordings/7/keep");
    expect(asked.find(({ method }) => method === "PATCH")?.body).toEqual({ perfect: true });
  });

  it("says on the button that playing again keeps the game, until it is kept", async () => {
    await end();
    expect(screen.getByRole("button", { name: /^Keep and play again/ })).toBeVisible();
    await userEvent.keyboard("k");
    expect(await screen.findByRole("button", { name: /^Play again/ })).toBeVisible();
  });

  it("plays again at a press, and keeps the game before", async () => {
    const { did } = await end();
    await userEvent.keyboard(" ");
    await waitFor(() => expect(FakeSocket.opened).toBe(2));
    expect(did()).toContain("/api/recordings/7/keep");
  });

  it("plays on from shortly before the end, and keeps the game as it was", async () => {
    const { asked, did } = await end();
    await userEvent.keyboard("{Backspace}");
    await waitFor(() => expect(FakeSocket.opened).toBe(2));
    expect(did()).toEqual(["/api/games", "/api/recordings/7/keep", "/api/games/from/7"]);
    expect(asked.find(({ path }) => path === "/api/games/from/7")?.body).toEqual({ frame: 438 });
  });

  it("hears neither fire nor steering in the first moment", async () => {
    const asked = await start();
    tell(ENDED);
    await userEvent.keyboard(" {ArrowLeft}");
    expect(asked.filter(({ method }) => method === "POST")).toHaveLength(1);
  });
});

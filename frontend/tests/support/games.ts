/** Games as the API describes them. */
import type { TaughtGame, Title } from "@/api/types";

export const SPACE_INVADERS: TaughtGame = {
  name: "space_invaders",
  title: "Space Invaders",
  picture_url: "/api/catalogue/pictures/space_invaders?v=1",
  width: 160,
  height: 210,
  pixel_aspect: 12 / 7,
  frame_rate_hz: 60,
  frames_per_step: 4,
  max_steps: 300,
  longest_steps: 6000,
  actions: ["NOOP", "FIRE", "RIGHT", "LEFT", "RIGHTFIRE", "LEFTFIRE"],
  buttons: ["left", "right", "fire"],
  held: [0, 4, 2, 1, 6, 5],
  default_keys: {
    ArrowLeft: "left",
    KeyA: "left",
    ArrowRight: "right",
    KeyD: "right",
    Space: "fire",
    ArrowUp: "fire",
    KeyW: "fire",
  },
  waits: false,
  end_rules: [
    { name: "hit", title: "when the cannon is hit" },
    { name: "life_counter", title: "when the count of lives drops" },
  ],
  ends: [
    { name: "hit", kind: "death", sentence: "the player was hit" },
    { name: "lives", kind: "death", sentence: "the player lost a life" },
    { name: "landed", kind: "failed", sentence: "the aliens landed" },
    { name: "cleared", kind: "won", sentence: "no alien was left" },
    { name: "steps", kind: "time", sentence: "300 steps were over" },
  ],
  options: { mode: [0], difficulty: [0] },
  hidden: [[0, 0, 160, 21]],
  items: {
    rows: 6,
    columns: 6,
    singular: "alien",
    plural: "aliens",
    verb: "hit",
    row_colours: [],
  },
  counters: { shots: "missiles fired" },
  things: { cannon: "cannon", missile: "missile" },
  tallies: {},
  ready_made: [],
  saves_states: true,
  has_memory: true,
  has_player: true,
  attribution: "",
};

/** A joystick game without items, counters or a scripted player. */
export const PONG: TaughtGame = {
  ...SPACE_INVADERS,
  name: "pong",
  title: "Pong",
  picture_url: "/api/catalogue/pictures/pong?v=1",
  end_rules: [
    { name: "life", title: "when a life is lost" },
    { name: "over", title: "when the game is over" },
  ],
  ends: [
    { name: "life", kind: "death", sentence: "a life was lost" },
    { name: "over", kind: "failed", sentence: "the game was over" },
    { name: "steps", kind: "time", sentence: "the time was over" },
  ],
  options: { mode: [0, 1], difficulty: [0, 1, 2, 3] },
  hidden: [[0, 0, 160, 24]],
  items: null,
  buttons: ["down", "up", "fire"],
  default_keys: {
    ArrowDown: "down",
    KeyS: "down",
    ArrowUp: "up",
    KeyW: "up",
    Space: "fire",
  },
  counters: {},
  things: { player: "green paddle", opponent: "orange paddle", ball: "ball" },
  has_player: false,
};

/** A joystick with all directions and fire, as most games of the console have. */
export const MS_PACMAN: TaughtGame = {
  ...PONG,
  name: "ms_pacman",
  title: "Ms. Pac-Man",
  actions: ["NOOP", "UP", "RIGHT", "LEFT", "DOWN", "UPRIGHT", "UPLEFT", "DOWNRIGHT", "DOWNLEFT"],
  buttons: ["left", "right", "up", "down"],
  held: [0, 4, 2, 1, 8, 6, 5, 10, 9],
  default_keys: {
    ArrowLeft: "left",
    ArrowRight: "right",
    ArrowUp: "up",
    ArrowDown: "down",
    KeyA: "left",
    KeyD: "right",
    KeyW: "up",
    KeyS: "down",
  },
};

/** An environment with named buttons, colours of its own, and nothing that can be saved. */
export const CART_POLE: TaughtGame = {
  ...PONG,
  name: "gym:CartPole-v1",
  title: "CartPole",
  width: 600,
  height: 400,
  pixel_aspect: 1,
  frame_rate_hz: 50,
  frames_per_step: 1,
  max_steps: 500,
  actions: ["push left", "push right"],
  buttons: ["push left", "push right"],
  held: [1, 2],
  default_keys: { ArrowLeft: "push left", ArrowRight: "push right" },
  waits: true,
  options: {},
  hidden: [],
  saves_states: false,
  has_memory: false,
};

export function titleOf(game: TaughtGame, change: Partial<Title> = {}): Title {
  const { name, title, picture_url } = game;
  return { name, title, picture_url, n_behaviours: 0, last_played_at: null, ...change };
}

/** Answers of a server that has these games. */
export function gameRoutes(...games: readonly TaughtGame[]) {
  const all = games.length > 0 ? games : [SPACE_INVADERS];
  return {
    "GET /api/catalogue": () => all.map((game) => titleOf(game)),
    ...Object.fromEntries(
      all.map((game) => [`GET /api/catalogue/games/${encodeURIComponent(game.name)}`, () => game]),
    ),
  };
}

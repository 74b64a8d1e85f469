/** One game as this tab plays it: the connection, its state, and the frames that come. */
import { ScreenDecoder } from "@/lib/game/codec";
import type { Palette } from "@/lib/game/screen";

import { type FrameMessage, readFrame, writeAck, writeInput } from "./binary-messages";
import type { AlienGeometry } from "./formation";
import { LatencyMeter, type LatencySummary } from "./latency";
import {
  CLOSE,
  type Command,
  type Ended,
  type HitAt,
  type ServerMessage,
  SPEEDS,
} from "./text-messages";

/**
 * connecting: nothing was heard yet. countdown, playing, paused, ended: what the game does.
 * stepping: it is paused and played frame by frame. rewinding: it is run back.
 * lost: the connection broke; it is tried again. full: too many games are open; it is tried again.
 * elsewhere: another tab plays. gone: no such game.
 * refused: this browser isn't let in any more.
 */
export type Phase =
  | "connecting"
  | "countdown"
  | "playing"
  | "paused"
  | "stepping"
  | "rewinding"
  | "ended"
  | "lost"
  | "full"
  | "elsewhere"
  | "gone"
  | "refused";

export interface GameState {
  readonly phase: Phase;
  /** Whole seconds until it goes on, in the countdown. */
  readonly seconds: number;
  readonly hits: readonly HitAt[];
  /** Why it is paused. */
  readonly why: string;
  readonly ended: Ended | null;
  /** When it ended, by performance.now(). */
  readonly endedAt: number;
  /** Percent of 60 frames a second. */
  readonly speed: number;
}

/** What is known of a frame besides its picture. */
export type SeenFrame = Pick<FrameMessage, "frame" | "formation" | "isShot">;

/** What shows the frames; called for each one, outside React. */
export interface GameScreen {
  setPalette(palette: Palette): void;
  /** Palette values, valid during the call; the frame, and how many there are at most. */
  show(pixels: Uint8Array, seen: SeenFrame, maxFrames: number): void;
}

const RETRY_MS = [250, 500, 1000, 2000, 4000] as const;
const MAX_FRAMES = 1200;
const REWINDABLE: ReadonlySet<Phase> = new Set(["countdown", "playing", "paused", "stepping"]);
const FULL_SPEED: number = SPEEDS[0];

export class GameStream {
  private state: GameState;
  private readonly listeners = new Set<() => void>();
  private readonly url: string;
  private readonly screen: GameScreen;
  private socket: WebSocket | null = null;
  private decoder = new ScreenDecoder();
  private readonly latency = new LatencyMeter();
  private keys = 0;
  private inputSequence = 0;
  private maxFrames = MAX_FRAMES;
  private geometry: AlienGeometry | null = null;
  private failures = 0;
  private timer: ReturnType<typeof setTimeout> | null = null;

  /** @param speed Percent of 60 frames a second at which a new game is played. */
  constructor(url: string, screen: GameScreen, speed = FULL_SPEED) {
    this.url = url;
    this.screen = screen;
    this.state = {
      phase: "connecting",
      seconds: 0,
      hits: [],
      why: "",
      ended: null,
      endedAt: 0,
      speed,
    };
  }

  readonly subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  readonly snapshot = (): GameState => this.state;

  /** Connects, or connects anew (as when another tab had taken the game over). */
  connect(): void {
    this.detach();
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.decoder = new ScreenDecoder();
    socket.addEventListener("message", ({ data }: MessageEvent<ArrayBuffer | string>) => {
      try {
        if (typeof data === "string") this.hear(JSON.parse(data) as ServerMessage);
        else this.see(socket, data);
      } catch {
        // What can't be read breaks the chain of differences: a new connection starts a new one.
        socket.close();
      }
    });
    socket.addEventListener("close", ({ code }) => {
      if (this.socket === socket) this.closed(code);
    });
  }

  /** Sets the keys held now, since an event at a time by performance.now(). */
  hold(keys: number, atMs = performance.now()): void {
    if (keys === this.keys) return;
    const pressed = (keys & ~this.keys) !== 0;
    this.keys = keys;
    this.sendKeys();
    const { phase, speed } = this.state;
    const timed = phase === "playing" && speed === FULL_SPEED;
    if (pressed && timed) this.latency.press(this.inputSequence, atMs);
  }

  /** How the aliens are laid out on the screen; null before the server has said it. */
  get aliens(): AlienGeometry | null {
    return this.geometry;
  }

  /** How late this game was seen so far. */
  latencySummary(): LatencySummary {
    return this.latency.summary();
  }

  command(type: Command): void {
    this.say({ type });
  }

  /** Plays on at another speed. */
  setSpeed(percent: number): void {
    if (percent === this.state.speed) return;
    this.latency.forget();
    this.update({ speed: percent });
    this.say({ type: "speed", percent });
  }

  /** Plays one frame of a paused game. */
  step(): void {
    if (this.state.phase !== "paused" && this.state.phase !== "stepping") return;
    this.update({ phase: "stepping" });
    this.command("step");
  }

  /** Leaves the game; the server keeps it as it stands. */
  leave(): void {
    this.detach();
    this.listeners.clear();
  }

  private say(message: object): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  /** Runs the game back until `release`, or as long as the connection holds. */
  rewind(): void {
    if (!REWINDABLE.has(this.state.phase)) return;
    this.latency.forget();
    this.update({ phase: "rewinding" });
    this.command("rewind");
  }

  /** The game goes on from where it was run back to. */
  release(): void {
    if (this.state.phase === "rewinding") this.command("release");
  }

  private sendKeys(): void {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    this.inputSequence += 1;
    this.socket.send(writeInput(this.keys, this.inputSequence));
  }

  private see(socket: WebSocket, data: ArrayBuffer): void {
    const message = readFrame(data);
    this.decoder.apply(message.payload, message.isKey);
    this.screen.show(this.decoder.pixels, message, this.maxFrames);
    const latency =
      this.state.phase === "rewinding"
        ? null
        : this.latency.show(message.frame, message.inputSequence, performance.now());
    socket.send(writeAck(message.sequence, latency));
  }

  private hear(message: ServerMessage): void {
    switch (message.type) {
      case "hello":
        this.failures = 0;
        this.latency.forget();
        this.maxFrames = message.max_frames;
        this.geometry = message.aliens;
        this.screen.setPalette(message.palette);
        if (message.frame === 0) this.keepSpeed(message.speed_percent);
        else this.update({ speed: message.speed_percent });
        this.update({ hits: message.hits });
        if (this.keys !== 0) this.sendKeys();
        this.command("ready");
        break;
      case "countdown":
        this.latency.forget();
        this.update({
          phase: message.seconds > 0 ? "countdown" : "playing",
          seconds: message.seconds,
        });
        break;
      case "hit":
        this.update({ hits: [...this.state.hits, message] });
        break;
      case "paused":
        this.latency.forget();
        this.update({ phase: "paused", why: message.why });
        break;
      case "rewound":
        this.update({ hits: message.hits });
        break;
      case "ended":
        this.update({
          phase: "ended",
          ended: message,
          endedAt: performance.now(),
          hits: message.hits,
        });
        break;
      case "taken_over":
        this.update({ phase: "elsewhere" });
        break;
    }
  }

  /** Asks for this page's speed, if the game has another one. */
  private keepSpeed(percent: number): void {
    if (percent !== this.state.speed) this.say({ type: "speed", percent: this.state.speed });
  }

  private closed(code: number): void {
    this.socket = null;
    if (this.state.phase === "ended") return;
    switch (code) {
      case CLOSE.takenOver:
        this.update({ phase: "elsewhere" });
        break;
      case CLOSE.noSuchGame:
      case CLOSE.gameOver:
        this.update({ phase: "gone" });
        break;
      case CLOSE.unauthorised:
        this.update({ phase: "refused" });
        break;
      default:
        this.update({ phase: code === CLOSE.tryAgainLater ? "full" : "lost" });
        this.retry();
    }
  }

  private retry(): void {
    const wait = RETRY_MS[Math.min(this.failures, RETRY_MS.length - 1)];
    this.failures += 1;
    this.timer = setTimeout(() => this.connect(), wait);
  }

  private detach(): void {
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = null;
    const { socket } = this;
    this.socket = null;
    socket?.close();
  }

  private update(change: Partial<GameState>): void {
    this.state = { ...this.state, ...change };
    this.listeners.forEach((listener) => listener());
  }
}

/** The address of a game's stream. The id is new with every load: a copied tab is another tab. */
export function streamUrl(streamPath: string, tab: string): string {
  const url = new URL(streamPath, location.href);
  url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  url.searchParams.set("tab", tab);
  return url.href;
}

/** A random id of a tab. `crypto.randomUUID` exists only on secure origins. */
export function newTabId(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  bytes[6] = ((bytes[6] ?? 0) & 0x0f) | 0x40;
  bytes[8] = ((bytes[8] ?? 0) & 0x3f) | 0x80;
  const hex = Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
  return hex.replace(/^(.{8})(.{4})(.{4})(.{4})(.{12})$/, "$1-$2-$3-$4-$5");
}

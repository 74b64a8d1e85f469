/** The connection of one game: its state, its frames, and what is sent to the server. */
import { t } from "@lingui/core/macro";

import type { FrameInfo, Overlay } from "@/games/view";
import { seconds } from "@/lib/format";
import { ScreenDecoder } from "@/lib/game/codec";
import type { ScreenFormat } from "@/lib/game/screen";
import { SilenceWatch } from "@/lib/browser/silence";

import { readFrame, writeAck, writeInput } from "./binary-messages";
import type { GameState, Phase } from "./game-state";
import { LatencyMeter, type LatencySummary } from "./latency";
import {
  CLOSE,
  type Command,
  HANDSHAKE_MS,
  type ServerMessage,
  SILENCE_MS,
  SPEEDS,
} from "./text-messages";

/** Shows the frames; called for each of them, outside React. */
export interface GameScreen {
  setFormat(format: ScreenFormat): void;
  /** @param pixels Palette indices or colours, valid only during the call. */
  show(pixels: Uint8Array, info: FrameInfo, maxFrames: number): void;
}

const RETRY_MS = [250, 500, 1000, 2000, 4000] as const;
const REWINDABLE: ReadonlySet<Phase> = new Set(["countdown", "playing", "paused", "stepping"]);
const RUNNING: ReadonlySet<Phase> = new Set(["countdown", "playing", "rewinding"]);
const FULL_SPEED: number = SPEEDS[0];
const MOST_PATIENCE = 4;

export class GameStream {
  private state: GameState;
  private readonly listeners = new Set<() => void>();
  private readonly url: string;
  private readonly screen: GameScreen;
  private socket: WebSocket | null = null;
  private decoder: ScreenDecoder | null = null;
  private readonly latency = new LatencyMeter();
  private keys = 0;
  private inputSequence = 0;
  private maxFrames = 0;
  private drawn: Overlay | null = null;
  private failures = 0;
  private timer: ReturnType<typeof setTimeout> | null = null;
  /** Why the game stands still; null if it goes on when a broken connection is back. */
  private standing: string | null = null;
  /** Why this page paused the game; null if something else did. */
  private ownReason: string | null = null;
  private readonly silence = new SilenceWatch({
    onSilence: () => this.onSilence(),
    onJump: (gapMs) => this.onJump(gapMs),
  });

  /** @param speed Percent of the game's own rate to start a new game at. */
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

  /** Connects or reconnects, for example to take the game back from another tab. */
  connect(): void {
    this.detach();
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.decoder = null;
    this.silence.start(HANDSHAKE_MS * Math.min(this.failures + 1, MOST_PATIENCE));
    socket.addEventListener("message", ({ data }: MessageEvent<ArrayBuffer | string>) => {
      // A connection that was given up may come back to life.
      if (this.socket !== socket) return;
      this.silence.heard(SILENCE_MS);
      try {
        if (typeof data === "string") this.onMessage(JSON.parse(data) as ServerMessage);
        else this.onFrame(socket, data);
      } catch {
        // Each frame builds on the last, so an unreadable one takes a new connection.
        socket.close();
      }
    });
    socket.addEventListener("close", ({ code }) => {
      if (this.socket === socket) this.onClose(code);
    });
  }

  /** Sets the keys held, as of an event at a time by `performance.now()`. */
  hold(keys: number, atMs = performance.now()): void {
    if (keys === this.keys) return;
    const pressed = (keys & ~this.keys) !== 0;
    this.keys = keys;
    this.sendKeys();
    const { phase, speed } = this.state;
    const timed = phase === "playing" && speed === FULL_SPEED;
    if (pressed && timed) this.latency.press(this.inputSequence, atMs);
  }

  /** What may be drawn over the screens; null until the server has named something. */
  get overlay(): Overlay | null {
    return this.drawn;
  }

  /** Input latency and dropped frames so far. */
  latencySummary(): LatencySummary {
    return this.latency.summary();
  }

  command(type: Command): void {
    this.send({ type });
  }

  /** Changes the speed. */
  setSpeed(percent: number): void {
    if (percent === this.state.speed) return;
    this.latency.forget();
    this.update({ speed: percent });
    this.send({ type: "speed", percent });
  }

  /** Plays one frame of a paused game. */
  step(): void {
    if (this.state.phase !== "paused" && this.state.phase !== "stepping") return;
    this.update({ phase: "stepping" });
    this.command("step");
  }

  /** Rewinds the game until `release` or a disconnection. */
  rewind(): void {
    if (!REWINDABLE.has(this.state.phase)) return;
    this.latency.forget();
    this.update({ phase: "rewinding" });
    this.command("rewind");
  }

  /** Ends rewinding; the game continues from there. */
  release(): void {
    if (this.state.phase === "rewinding") this.command("release");
  }

  /** Disconnects; the server keeps the game. */
  leave(): void {
    this.detach();
    this.listeners.clear();
  }

  private send(message: object): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  private sendKeys(): void {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    this.inputSequence += 1;
    this.socket.send(writeInput(this.keys, this.inputSequence));
  }

  private onFrame(socket: WebSocket, data: ArrayBuffer): void {
    const message = readFrame(data);
    if (!this.decoder) throw new Error("A frame came before the greeting.");
    this.decoder.apply(message.payload, message.isKey);
    this.screen.show(this.decoder.pixels, message, this.maxFrames);
    if (this.state.phase === "rewinding") this.takeBackHits(message.frame);
    const latency =
      this.state.phase === "rewinding"
        ? null
        : this.latency.show(message.frame, message.inputSequence, performance.now());
    socket.send(writeAck(message.sequence, latency));
  }

  /** Forgets the hits after a frame that is shown again; the server names the rest at the end. */
  private takeBackHits(frame: number): void {
    const hits = this.state.hits.filter((one) => one.frame <= frame);
    if (hits.length < this.state.hits.length) this.update({ hits });
  }

  private onMessage(message: ServerMessage): void {
    switch (message.type) {
      case "hello":
        this.failures = 0;
        this.latency.forget();
        this.maxFrames = message.max_frames;
        this.drawn = message.overlay;
        this.decoder = new ScreenDecoder(message);
        this.screen.setFormat(message);
        if (message.frame === 0) this.keepSpeed(message.speed_percent);
        else this.update({ speed: message.speed_percent });
        this.update({ hits: message.hits });
        if (this.keys !== 0) this.sendKeys();
        this.goOn();
        break;
      case "countdown":
        this.latency.forget();
        this.standing = this.ownReason = null;
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
        this.standing = this.ownReason ?? message.why;
        this.update({ phase: "paused", why: this.standing });
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
      case "alive":
        break;
    }
  }

  /** Plays from a greeting on, unless the game stood still before or nobody sees it. */
  private goOn(): void {
    if (document.hidden) this.standing ??= t`The page was in the background.`;
    if (this.standing === null) this.command("ready");
    else this.update({ phase: "paused", why: this.standing });
  }

  private onSilence(): void {
    this.detach();
    if (this.state.phase === "ended") return;
    this.update({ phase: "lost" });
    this.retry();
  }

  private onJump(gapMs: number): void {
    if (!RUNNING.has(this.state.phase)) return;
    const gap = seconds(gapMs / 1000, 0);
    this.standing = this.ownReason = t`This page stood still for ${gap}, so the game is paused.`;
    this.command("pause");
  }

  /** Requests this page's speed if the game has another. */
  private keepSpeed(percent: number): void {
    if (percent !== this.state.speed) this.send({ type: "speed", percent: this.state.speed });
  }

  private onClose(code: number): void {
    this.socket = null;
    this.silence.stop();
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
    this.silence.stop();
    const { socket } = this;
    this.socket = null;
    socket?.close();
  }

  private update(change: Partial<GameState>): void {
    this.state = { ...this.state, ...change };
    this.listeners.forEach((listener) => listener());
  }
}

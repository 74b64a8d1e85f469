/** The connection of a page that watches: its state, and the frames of each lane. */
import { readFrame, writeAck } from "@/features/play/stream/binary-messages";
import {
  CLOSE,
  HANDSHAKE_MS,
  type HitAt,
  SILENCE_MS,
  SPEEDS,
} from "@/features/play/stream/text-messages";
import type { FrameInfo } from "@/games/view";
import { ScreenDecoder } from "@/lib/game/codec";
import type { ScreenFormat } from "@/lib/game/screen";
import { SilenceWatch } from "@/lib/browser/silence";

import type { LookingNetwork } from "./choice";
import type { Decision, LaneAttention, LaneEnded, Taken, WatchMessage } from "./watch-messages";

/**
 * - connecting: nothing was received yet
 * - playing, paused, finished: what the server reports
 * - waiting: the games wait for their policies, for longer than one would not notice
 * - taken: the person goes on with one of the games
 * - refused: there is nothing to watch; `why` says why
 * - closed: the games are gone because they were paused for long
 * - lost: the connection broke, and the games with it
 */
export type WatchPhase =
  | "connecting"
  | "playing"
  | "waiting"
  | "paused"
  | "finished"
  | "taken"
  | "refused"
  | "closed"
  | "lost";

export interface LaneState {
  readonly hits: readonly HitAt[];
  readonly ended: LaneEnded | null;
}

export interface WatchState {
  readonly phase: WatchPhase;
  /** Why the games are paused or refused; empty if the person paused them. */
  readonly why: string;
  /** Percent of the game's own rate. */
  readonly speed: number;
  readonly lanes: readonly LaneState[];
  /** Frames of the opening that was played before the policies began. */
  readonly openingFrames: number;
  readonly taken: Taken | null;
}

/** Shows what changes with every frame or step; called outside React. */
export interface LaneScreen {
  setFormat: (format: ScreenFormat) => void;
  /** @param pixels Palette indices or colours, valid only during the call. */
  show: (pixels: Uint8Array, info: FrameInfo, maxFrames: number) => void;
  decide: (decision: Decision) => void;
  reward: (level: number, deviation: number | null) => void;
  attend: (attention: LaneAttention) => void;
}

const FULL_SPEED: number = SPEEDS[0];
const NEW_LANE: LaneState = { hits: [], ended: null };

export class WatchStream {
  private state: WatchState;
  private readonly listeners = new Set<() => void>();
  private decoders: readonly ScreenDecoder[] = [];
  private readonly url: string;
  private readonly screens: readonly LaneScreen[];
  private socket: WebSocket | null = null;
  private maxFrames = 0;
  private attention: LookingNetwork | null = null;
  private readonly silence = new SilenceWatch({
    onSilence: () => this.onClose(null),
    onJump: () => this.command("pause"),
  });

  /** @param screens One for each game. */
  constructor(url: string, screens: readonly LaneScreen[], speed = FULL_SPEED) {
    this.url = url;
    this.screens = screens;
    this.state = {
      phase: "connecting",
      why: "",
      speed,
      lanes: screens.map(() => NEW_LANE),
      openingFrames: 0,
      taken: null,
    };
  }

  readonly subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  readonly snapshot = (): WatchState => this.state;

  connect(): void {
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.silence.start(HANDSHAKE_MS);
    socket.addEventListener("message", ({ data }: MessageEvent<ArrayBuffer | string>) => {
      // A connection that was given up may come back to life.
      if (this.socket !== socket) return;
      this.silence.heard(SILENCE_MS);
      try {
        if (typeof data === "string") this.onMessage(JSON.parse(data) as WatchMessage);
        else this.onFrame(socket, data);
      } catch {
        // Each frame builds on the last, so nothing after an unreadable one can be shown.
        socket.close();
      }
    });
    socket.addEventListener("close", ({ code }) => {
      if (this.socket === socket) this.onClose(code);
    });
  }

  /** Plays, pauses, or plays one step. */
  command(type: "play" | "pause" | "step"): void {
    this.send({ type });
  }

  /** Pauses games that are playing, and plays paused ones. */
  toggle(): void {
    const { phase } = this.state;
    if (phase === "paused") this.command("play");
    else if (phase === "playing" || phase === "waiting") this.command("pause");
  }

  setSpeed(percent: number): void {
    if (percent === this.state.speed) return;
    this.update({ speed: percent });
    this.send({ type: "speed", percent });
  }

  /** Asks to show what a network looks at in the games; null for nothing any more. */
  showAttention(network: LookingNetwork | null): void {
    if (network === this.attention) return;
    this.attention = network;
    // Games that have not begun are asked for theirs when they do.
    if (this.state.phase !== "connecting") this.sendAttention();
  }

  /** Asks to go on with a lane's game; `taken` follows. */
  takeOver(lane: number): void {
    if (this.state.lanes[lane]?.ended === null) this.send({ type: "take_over", lane });
  }

  /** Disconnects, which ends the games. */
  leave(): void {
    this.listeners.clear();
    this.detach();
  }

  private detach(): void {
    this.silence.stop();
    const { socket } = this;
    this.socket = null;
    socket?.close();
  }

  private sendAttention(): void {
    this.send({ type: "attention", network: this.attention });
  }

  private send(message: object): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  private onFrame(socket: WebSocket, data: ArrayBuffer): void {
    const lane = new Uint8Array(data)[0] ?? 0;
    const decoder = this.decoders[lane];
    if (!decoder) throw new Error(`There is no lane ${lane}.`);
    const message = readFrame(data.slice(1));
    decoder.apply(message.payload, message.isKey);
    this.screens[lane]?.show(decoder.pixels, message, this.maxFrames);
    const ack = new Uint8Array(writeAck(message.sequence));
    socket.send(new Uint8Array([lane, ...ack]).buffer);
  }

  private onMessage(message: WatchMessage): void {
    switch (message.type) {
      case "hello":
        this.maxFrames = message.max_frames;
        this.decoders = this.screens.map(() => new ScreenDecoder(message));
        for (const screen of this.screens) screen.setFormat(message);
        this.update({ openingFrames: message.frame });
        if (message.speed_percent !== this.state.speed) {
          this.send({ type: "speed", percent: this.state.speed });
        }
        if (this.attention !== null) this.sendAttention();
        if (document.hidden) this.update({ phase: "paused" });
        else this.command("play");
        break;
      case "playing":
      case "waiting":
      case "finished":
        this.update({ phase: message.type, why: "" });
        break;
      case "paused":
        this.update({ phase: "paused", why: message.why });
        break;
      case "hit":
        this.updateLane(message.lane, (lane) => ({ ...lane, hits: [...lane.hits, message] }));
        break;
      case "ended":
        this.updateLane(message.lane, () => ({ hits: message.hits, ended: message }));
        break;
      case "decision":
        this.screens[message.lane]?.decide(message);
        break;
      case "reward":
        this.screens[message.lane]?.reward(message.level, message.deviation);
        break;
      case "attention":
        // One that was on its way when the page asked for nothing any more is late.
        if (this.attention !== null) this.screens[message.lane]?.attend(message);
        break;
      case "taken":
        this.update({ phase: "taken", taken: message });
        break;
      case "refused":
        this.update({ phase: "refused", why: message.why });
        break;
      case "alive":
        break;
    }
  }

  /** @param code Null if the connection went silent. */
  private onClose(code: number | null): void {
    this.detach();
    const { phase } = this.state;
    if (phase === "taken" || phase === "refused") return;
    this.update({ phase: code === CLOSE.gameOver ? "closed" : "lost" });
  }

  private updateLane(index: number, change: (lane: LaneState) => LaneState): void {
    this.update({
      lanes: this.state.lanes.map((lane, at) => (at === index ? change(lane) : lane)),
    });
  }

  private update(change: Partial<WatchState>): void {
    this.state = { ...this.state, ...change };
    this.listeners.forEach((listener) => listener());
  }
}

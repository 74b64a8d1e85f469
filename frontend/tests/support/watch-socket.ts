/** The server's end of a page that watches, controlled by the test. */
import { zlibSync } from "fflate";

const SCREEN_BYTES = 160 * 210;

export const WATCH_HELLO = {
  type: "hello",
  width: 160,
  height: 210,
  palette: [],
  max_frames: 1200,
  frame: 96,
  speed_percent: 100,
  overlay: {
    painter: "alien-formation",
    geometry: { width: 8, height: 10, column_px: 16, row_px: 18 },
  },
  start: { idle_frames: 11 },
  start_number: 0,
  actors: [],
};

export class WatchSocket extends EventTarget {
  static readonly OPEN = 1;
  static readonly opened: WatchSocket[] = [];

  readonly url: URL;
  readyState = WatchSocket.OPEN;
  binaryType = "blob";
  readonly sent: (string | ArrayBuffer)[] = [];

  constructor(url: string) {
    super();
    this.url = new URL(url);
    WatchSocket.opened.push(this);
  }

  static get newest(): WatchSocket {
    const socket = WatchSocket.opened.at(-1);
    if (!socket) throw new Error("No connection was opened.");
    return socket;
  }

  send(data: string | ArrayBuffer): void {
    this.sent.push(data);
  }

  close(code = 1000): void {
    if (this.readyState === 3) return;
    this.readyState = 3;
    this.dispatchEvent(Object.assign(new Event("close"), { code }));
  }

  tell(message: object): void {
    this.dispatchEvent(new MessageEvent("message", { data: JSON.stringify(message) }));
  }

  /** Shows a lane a screen of one colour. */
  show(lane: number, sequence: number, frame: number, colour = 0): void {
    const payload = zlibSync(new Uint8Array(SCREEN_BYTES).fill(colour));
    const data = new Uint8Array(17 + payload.length);
    const view = new DataView(data.buffer);
    view.setUint8(0, lane);
    view.setUint8(1, 1);
    view.setUint8(2, 1);
    view.setUint32(5, sequence, true);
    view.setUint32(9, frame, true);
    data.set(payload, 17);
    this.dispatchEvent(new MessageEvent("message", { data: data.buffer }));
  }

  get commands(): object[] {
    return this.sent
      .filter((one) => typeof one === "string")
      .map((one) => JSON.parse(one) as object);
  }

  get acks(): number[][] {
    return this.sent
      .filter((one) => typeof one !== "string")
      .map((one) => [...new Uint8Array(one)]);
  }
}

/** Reads what a share page has in it. */
import { Film } from "./film";

export interface SharedScreen {
  readonly width: number;
  readonly height: number;
  readonly pixel_aspect: number;
  readonly palette: readonly (readonly [number, number, number])[] | null;
  readonly frame_rate_hz: number;
  readonly frames_per_step: number;
  /** The last frame of the longer one of the games in step. */
  readonly last: number;
  /** The scale of the curves of R. */
  readonly low: number;
  readonly high: number;
  readonly plot_height: number;
  readonly plot_padding: number;
}

interface FilmData {
  readonly number: number;
  readonly last: number;
  readonly frames_per_picture: number;
  /** In base64. */
  readonly content: string;
  /** Of R by step; of the games in step alone, where R is known. */
  readonly levels: readonly number[] | null;
}

/** The films of a page, unpacked when they are first shown. */
export class Films {
  readonly screen: SharedScreen;
  private readonly data = new Map<number, FilmData>();

  constructor(page: ParentNode) {
    this.screen = JSON.parse(page.querySelector("#screen")?.textContent ?? "") as SharedScreen;
    for (const element of page.querySelectorAll("script.film")) {
      const data = JSON.parse(element.textContent) as FilmData;
      this.data.set(data.number, data);
    }
  }

  /** Returns a film of its own for each caller, who moves in it. */
  film(number: number): Film | null {
    const data = this.data.get(number);
    if (!data) return null;
    const content = Uint8Array.from(atob(data.content), (sign) => sign.charCodeAt(0));
    return new Film(this.screen, content, data.last, data.frames_per_picture);
  }

  levels(number: number): readonly number[] | null {
    return this.data.get(number)?.levels ?? null;
  }
}

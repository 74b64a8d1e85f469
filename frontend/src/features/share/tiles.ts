/** Plays the ranked games of a share page while they are pointed at or focused. */
import { Playback } from "@/lib/game/playback";
import { ScreenPainter } from "@/lib/game/screen";

import type { Films } from "./data";

/** Lets a tile play; where less motion is asked for, only when it is pressed. */
export function playTile(tile: HTMLElement, films: Films, calm: boolean): void {
  const canvas = tile.querySelector("canvas");
  const still = tile.querySelector("img");
  if (!canvas || !still) return;
  let playback: Playback | null = null;
  const load = () => {
    const film = films.film(Number(tile.dataset.film));
    if (!film) return null;
    const painter = new ScreenPainter(canvas);
    painter.setFormat(films.screen);
    const made = new Playback(film.last, films.screen.frame_rate_hz, { loop: true });
    made.subscribe(() => painter.draw(film.show(made.snapshot().frame)));
    return made;
  };
  const start = () => {
    playback ??= load();
    playback?.play();
    still.hidden = playback !== null;
    canvas.hidden = playback === null;
  };
  const stop = () => {
    playback?.pause();
    playback?.seek(0);
    still.hidden = false;
    canvas.hidden = true;
  };
  if (!calm) {
    tile.addEventListener("pointerenter", ({ pointerType }) => {
      if (pointerType === "mouse") start();
    });
    tile.addEventListener("focus", () => {
      if (tile.matches(":focus-visible")) start();
    });
  }
  tile.addEventListener("pointerleave", ({ pointerType }) => {
    if (pointerType === "mouse") stop();
  });
  tile.addEventListener("blur", stop);
  tile.addEventListener("click", () => {
    if (playback?.snapshot().playing) playback.pause();
    else start();
  });
}

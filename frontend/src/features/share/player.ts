/** Plays a share page's games in step, with R under them. */
import { playByKey } from "@/components/in-step/playback-keys";
import { Playback, SPEEDS } from "@/lib/game/playback";
import { ScreenPainter, screenScale } from "@/lib/game/screen";

import type { Films } from "./data";

/** The part of the window's height that the controls and R need. */
const CHROME_PX = 380;
const LEAST_PX = 210;

export function playInStep(player: HTMLElement, films: Films, calm: boolean): void {
  const { screen } = films;
  const playback = new Playback(screen.last, screen.frame_rate_hz);
  showScreens(player, films, playback);
  showReward(player, films, playback);
  control(player, films, playback);
  if (calm) playback.seek(screen.last);
  else playback.play();
}

function showScreens(player: HTMLElement, films: Films, playback: Playback): void {
  const stages = [...player.querySelectorAll<HTMLElement>(".stage")];
  for (const stage of stages) {
    const canvas = stage.querySelector("canvas");
    const still = stage.querySelector("img");
    const film = films.film(Number(canvas?.dataset.film));
    if (!canvas || !still || !film) continue;
    const painter = new ScreenPainter(canvas);
    painter.setFormat(films.screen);
    const draw = () => painter.draw(film.show(playback.snapshot().frame));
    draw();
    still.hidden = true;
    canvas.hidden = false;
    playback.subscribe(draw);
    const fit = () => fitScreen(canvas, stage.clientWidth, films);
    fit();
    new ResizeObserver(fit).observe(stage);
    window.addEventListener("resize", fit);
  }
}

/** Makes a screen as large as there is room for whole pixels. */
function fitScreen(canvas: HTMLCanvasElement, width: number, { screen }: Films): void {
  const ratio = window.devicePixelRatio || 1;
  const height = Math.max(window.innerHeight - CHROME_PX, LEAST_PX);
  const scale = screenScale(width * ratio + 0.01, height * ratio + 0.01, screen);
  canvas.style.width = `${(screen.width * scale.x) / ratio}px`;
  canvas.style.height = `${(screen.height * scale.y) / ratio}px`;
}

function showReward(player: HTMLElement, films: Films, playback: Playback): void {
  const plot = player.querySelector<HTMLElement>("#plot");
  const cursor = plot?.querySelector<SVGGElement>("#cursor");
  const line = cursor?.querySelector("line");
  if (!plot || !cursor || !line) return;
  const { last, low, high, plot_height, plot_padding, frames_per_step } = films.screen;
  const y = (level: number) =>
    plot_height - plot_padding - ((level - low) / (high - low)) * (plot_height - 2 * plot_padding);
  const x = (frame: number) => `${(frame / Math.max(last, 1)) * 100}%`;
  const draw = () => {
    const { frame } = playback.snapshot();
    line.setAttribute("x1", x(frame));
    line.setAttribute("x2", x(frame));
    for (const circle of cursor.querySelectorAll("circle")) {
      const number = circle.dataset.film ?? "";
      const levels = films.levels(Number(number)) ?? [];
      const step = Math.min(Math.floor(frame / frames_per_step), levels.length - 1);
      const level = levels[step] ?? 0;
      // A game that is over stays where it ended.
      circle.setAttribute("cx", x(Math.min(frame, (levels.length - 1) * frames_per_step, last)));
      circle.setAttribute("cy", String(y(level)));
      const value = player.querySelector(`[data-level="${number}"]`);
      if (value) value.textContent = signed(level);
    }
  };
  cursor.removeAttribute("hidden");
  draw();
  playback.subscribe(draw);
  const seek = (event: PointerEvent) => {
    const box = plot.getBoundingClientRect();
    playback.pause();
    playback.seek(((event.clientX - box.left) / Math.max(box.width, 1)) * last);
  };
  plot.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    plot.setPointerCapture(event.pointerId);
    seek(event);
  });
  plot.addEventListener("pointermove", (event) => {
    if (plot.hasPointerCapture(event.pointerId)) seek(event);
  });
}

/** Writes a level with two digits. */
function signed(level: number): string {
  return level
    .toFixed(2)
    .replace(/^-0\.00$/, "0.00")
    .replace("-", "−");
}

function control(player: HTMLElement, { screen }: Films, playback: Playback): void {
  const play = player.querySelector("#play");
  const position = player.querySelector<HTMLInputElement>("#position");
  const time = player.querySelector("#time");
  const speed = player.querySelector<HTMLSelectElement>("#speed");
  if (!play || !position || !time || !speed) return;
  play.addEventListener("click", () => playback.toggle());
  for (const [id, frames] of [
    ["#back", -screen.frames_per_step],
    ["#forward", screen.frames_per_step],
  ] as const) {
    player.querySelector(id)?.addEventListener("click", () => playback.step(frames));
  }
  position.addEventListener("input", () => {
    playback.pause();
    playback.seek(position.valueAsNumber);
  });
  speed.append(...SPEEDS.map((factor) => new Option(`${factor}×`, String(factor))));
  speed.value = "1";
  speed.addEventListener("change", () => playback.setSpeed(Number(speed.value)));
  player.addEventListener("keydown", (event) =>
    playByKey(event, playback, screen.last, screen.frames_per_step),
  );
  const show = () => {
    const { frame, playing } = playback.snapshot();
    const seconds = `${(frame / screen.frame_rate_hz).toFixed(1)} s`;
    position.value = String(frame);
    position.setAttribute("aria-valuetext", seconds);
    time.textContent = seconds;
    play.setAttribute("aria-label", playing ? "Pause" : "Play");
    play.classList.toggle("playing", playing);
  };
  show();
  playback.subscribe(show);
  for (const part of player.querySelectorAll("#transport, #keys")) part.removeAttribute("hidden");
}

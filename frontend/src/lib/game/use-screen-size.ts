import { type RefObject, useLayoutEffect, useState, useSyncExternalStore } from "react";

import { SCREEN_HEIGHT, SCREEN_WIDTH } from "./codec";
import { screenScale } from "./screen";

export interface ScreenSize {
  /** In CSS pixels, so that each pixel of the game covers a whole number of device pixels. */
  readonly width: number;
  readonly height: number;
}

function subscribeToRatio(listener: () => void): () => void {
  const query = window.matchMedia(`(resolution: ${devicePixelRatio}dppx)`);
  query.addEventListener("change", listener);
  window.addEventListener("resize", listener);
  return () => {
    query.removeEventListener("change", listener);
    window.removeEventListener("resize", listener);
  };
}

function usePixelRatio(): number {
  return useSyncExternalStore(subscribeToRatio, () => window.devicePixelRatio || 1);
}

function sizeIn(width: number, height: number, ratio: number): ScreenSize {
  // Tolerance: at fractional zoom, browsers report rounded sizes.
  const scale = screenScale(width * ratio + 0.01, height * ratio + 0.01);
  return { width: (SCREEN_WIDTH * scale.x) / ratio, height: (SCREEN_HEIGHT * scale.y) / ratio };
}

/** Returns the size of the game's screen in a box of CSS pixels. */
export function useScreenSize(width: number, height: number): ScreenSize {
  return sizeIn(width, height, usePixelRatio());
}

/** Returns the size of the game's screen in an element's width and a height from the window's. */
export function useFittingScreenSize(
  ref: RefObject<HTMLElement | null>,
  heightFor: (windowHeight: number) => number,
): ScreenSize {
  const ratio = usePixelRatio();
  const [box, setBox] = useState({ width: SCREEN_WIDTH * 2, height: SCREEN_HEIGHT * 2 });
  useLayoutEffect(() => {
    const element = ref.current;
    if (!element) return undefined;
    const measure = () => {
      const width = element.clientWidth;
      const height = heightFor(window.innerHeight);
      setBox((box) => (box.width === width && box.height === height ? box : { width, height }));
    };
    measure();
    const observer = new ResizeObserver(measure);
    observer.observe(element);
    window.addEventListener("resize", measure);
    return () => {
      observer.disconnect();
      window.removeEventListener("resize", measure);
    };
  }, [ref, heightFor]);
  return sizeIn(box.width, box.height, ratio);
}

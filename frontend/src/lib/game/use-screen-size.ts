import { type RefObject, useLayoutEffect, useState, useSyncExternalStore } from "react";

import { screenScale, type ScreenShape } from "./screen";

export interface ScreenSize {
  /** In CSS pixels, so that each pixel of the game covers a whole number of device pixels. */
  readonly width: number;
  readonly height: number;
  /** Whether there is no room for whole pixels, so that the picture is reduced. */
  readonly reduced: boolean;
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

function sizeIn(width: number, height: number, ratio: number, screen: ScreenShape): ScreenSize {
  // Tolerance: at fractional zoom, browsers report rounded sizes.
  const scale = screenScale(width * ratio + 0.01, height * ratio + 0.01, screen);
  return {
    width: (screen.width * scale.x) / ratio,
    height: (screen.height * scale.y) / ratio,
    reduced: !Number.isInteger(scale.y),
  };
}

/** Returns the size of the game's screen in a box of CSS pixels. */
export function useScreenSize(width: number, height: number, screen: ScreenShape): ScreenSize {
  return sizeIn(width, height, usePixelRatio(), screen);
}

/** Returns the size of the game's screen in an element's width and a height from the window's. */
export function useFittingScreenSize(
  ref: RefObject<HTMLElement | null>,
  heightFor: (windowHeight: number) => number,
  screen: ScreenShape,
): ScreenSize {
  const ratio = usePixelRatio();
  const [box, setBox] = useState({ width: 320, height: 420 });
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
  return sizeIn(box.width, box.height, ratio, screen);
}

import { useEffect } from "react";

import { type Accent, accentOf, coloursIn } from "./accent";

/** What text in the accent colour stands on. */
const BACKGROUNDS = ["--paper", "--surface", "--sunken"];

const known = new Map<string, Promise<Accent | null>>();

/** Gives the page the accent of a game, worked out once from its picture, while it is shown. */
export function useAccent(pictureUrl: string | undefined): void {
  useEffect(() => {
    if (pictureUrl === undefined) return undefined;
    const { style } = document.documentElement;
    let gone = false;
    let names: readonly string[] = [];
    const accent = known.get(pictureUrl) ?? accentOfPicture(pictureUrl);
    known.set(pictureUrl, accent);
    void accent.then((tokens) => {
      if (gone || !tokens) return;
      names = Object.keys(tokens);
      for (const [name, value] of Object.entries(tokens)) style.setProperty(name, value);
    });
    return () => {
      gone = true;
      for (const name of names) style.removeProperty(name);
    };
  }, [pictureUrl]);
}

/** Returns the accent of a picture; null where it can't be read, so that the page keeps its own. */
async function accentOfPicture(url: string): Promise<Accent | null> {
  const root = getComputedStyle(document.documentElement);
  const backgrounds = BACKGROUNDS.flatMap((name) => coloursIn(root.getPropertyValue(name)) ?? []);
  const picture = new Image();
  picture.src = url;
  try {
    await picture.decode();
    const { naturalWidth: width, naturalHeight: height } = picture;
    // Browsers of before 2023 have none.
    const canvas = new OffscreenCanvas(width, height);
    const context = canvas.getContext("2d");
    if (!context || backgrounds.length < BACKGROUNDS.length) return null;
    context.drawImage(picture, 0, 0);
    return accentOf(context.getImageData(0, 0, width, height).data, {
      light: backgrounds.map(({ light }) => light),
      dark: backgrounds.map(({ dark }) => dark),
    });
  } catch {
    return null;
  }
}

import { type CSSProperties, useMemo } from "react";

import type { Recording } from "@/api/types";
import { useGame } from "@/games/game";
import { classes } from "@/lib/classes";
import { type Moments, momentsOf, SMALL_COLUMNS, SMALL_ROWS } from "@/lib/game/strip";
import { type ScreenSize, useScreenSize } from "@/lib/game/use-screen-size";

import styles from "./GamePicture.module.css";

/** Makes the pictures within an element loop while it is pointed at, touched or has the focus. */
export const LOOPS = { "data-loops": "" } as const;

const SCREEN = { width: 320, height: 210 } as const;

interface Size {
  readonly width: number;
  readonly height: number;
}

/**
 * A game's last moment, which loops through the eight of its film strip within `LOOPS`.
 *
 * @param box Available size in CSS pixels; without it, it is small.
 */
export function GamePicture({ recording, box }: { recording: Recording; box?: Size }) {
  const game = useGame();
  const { whole, small } = useMemo(() => momentsOf(game), [game]);
  const { width, height } = box ?? small.shape;
  const asWhole = useScreenSize(width, height, whole.shape);
  const asSmall = useScreenSize(width, height, small.shape);
  const [moments, size] = asWhole.reduced ? [small, asSmall] : [whole, asWhole];
  return (
    <Cut
      recording={recording}
      moments={moments}
      size={size}
      className={moments === small ? styles.small : styles.whole}
    />
  );
}

/** A game's picture, and below it its eight moments, of which the one that it shows is marked. */
export function FilmStrip({ recording }: { recording: Recording }) {
  return (
    <span className={styles.film}>
      <span className={styles.screen}>
        <GamePicture recording={recording} box={SCREEN} />
      </span>
      <Strip recording={recording} />
    </span>
  );
}

function Strip({ recording }: { recording: Recording }) {
  const game = useGame();
  const { small } = useMemo(() => momentsOf(game), [game]);
  const { width, height } = small.shape;
  const size = useScreenSize(width, height, small.shape);
  return (
    <span className={styles.strip} style={step(size.width, size.height)}>
      <Cut
        recording={recording}
        moments={small}
        size={size}
        columns={SMALL_COLUMNS}
        rows={SMALL_ROWS}
      />
      <span className={styles.mark} />
    </span>
  );
}

/** What is seen of a film strip: the first moment, or so many columns and rows of them. */
function Cut({
  recording,
  moments: { shape, sheet, top },
  size,
  columns = 1,
  rows = 1,
  className,
}: {
  recording: Recording;
  moments: Moments;
  /** Of a moment, as shown. */
  size: ScreenSize;
  columns?: number;
  rows?: number;
  className?: string | undefined;
}) {
  const [x, y] = [size.width / shape.width, size.height / shape.height];
  return (
    <span
      className={styles.cut}
      style={{ width: columns * size.width, height: rows * size.height }}
    >
      <img
        className={classes(styles.sheet, className)}
        src={recording.strip_url}
        alt=""
        loading="lazy"
        style={{
          width: sheet.width * x,
          height: sheet.height * y,
          insetBlockStart: -top * y,
          ...step(-size.width, -size.height),
          ...(size.reduced && { imageRendering: "auto" }),
        }}
      />
    </span>
  );
}

/** The way from a moment to the one beside it and the one below it, for the style sheet. */
function step(x: number, y: number): CSSProperties {
  return { "--x": `${x}px`, "--y": `${y}px` } as CSSProperties;
}

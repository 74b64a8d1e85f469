import { memo } from "react";

import {
  type Cell,
  cellKey,
  CELL_SIZE,
  columnX,
  describeGrid,
  GRID_SIZE,
  gridPath,
  gridState,
  rowY,
  SPRITE_SIZE,
  spritePath,
} from "@/lib/game/aliens";

import styles from "./AlienGrid.module.css";

interface AlienGridProps {
  /** Aliens hit, in order of time. */
  hits?: readonly Cell[];
  target?: readonly Cell[] | null;
  /** CSS pixels per pixel of the drawing. */
  scale?: 1 | 2 | 3 | 4;
  /** Accessible name instead of the generated one; "" makes the grid decorative. */
  label?: string;
}

/**
 * The 6x6 grid of aliens: remaining aliens as sprites, those of the target in the accent colour;
 * target hits as dots, strays as crosses.
 */
export const AlienGrid = memo(function AlienGrid({
  hits = [],
  target,
  scale = 1,
  label,
}: AlienGridProps) {
  const state = gridState(hits, target);
  const side = GRID_SIZE * scale;
  const name = label ?? describeGrid(hits, target);
  return (
    <svg
      className={styles.grid}
      viewBox={`0 0 ${GRID_SIZE} ${GRID_SIZE}`}
      width={side}
      height={side}
      {...(name === "" ? { "aria-hidden": true } : { role: "img", "aria-label": name })}
    >
      {target?.map((cell) => (
        <rect
          key={cellKey(cell)}
          className={styles.target}
          x={columnX(cell[1]) - 1}
          y={rowY(cell[0]) - 1}
          width={CELL_SIZE}
          height={CELL_SIZE}
        />
      ))}
      <path className={styles.standing} d={gridPath(state.standing)} />
      <path className={styles.missing} d={gridPath(state.missing)} />
      <path className={styles.hit} d={dots(state.hit)} />
      <path className={styles.stray} d={crosses(state.stray)} shapeRendering="geometricPrecision" />
      <path className={styles.gone} d={crosses(state.gone)} shapeRendering="geometricPrecision" />
    </svg>
  );
});

const DOT = 4;
const CROSS = 4;

function dots(cells: readonly Cell[]): string {
  const inset = (SPRITE_SIZE - DOT) / 2;
  return cells
    .map(([row, column]) => {
      const x = columnX(column) + inset;
      return `M${x} ${rowY(row) + inset}h${DOT}v${DOT}h${-DOT}z`;
    })
    .join("");
}

function crosses(cells: readonly Cell[]): string {
  const inset = (SPRITE_SIZE - CROSS) / 2;
  return cells
    .map(([row, column]) => {
      const x = columnX(column) + inset;
      const y = rowY(row) + inset;
      return `M${x} ${y}l${CROSS} ${CROSS}M${x + CROSS} ${y}l${-CROSS} ${CROSS}`;
    })
    .join("");
}

/** A single alien sprite. */
export function Alien({ row = 2, scale = 2 }: { row?: number; scale?: number }) {
  return (
    <svg
      className={styles.grid}
      viewBox={`0 0 ${SPRITE_SIZE} ${SPRITE_SIZE}`}
      width={SPRITE_SIZE * scale}
      height={SPRITE_SIZE * scale}
      aria-hidden="true"
    >
      <path className={styles.missing} d={spritePath(row, 0, 0)} />
    </svg>
  );
}

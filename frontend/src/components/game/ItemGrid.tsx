import { plural, t } from "@lingui/core/macro";
import { memo } from "react";

import { viewOf } from "@/games/views";
import { useGame } from "@/games/game";
import {
  type Cell,
  CELL_SIZE,
  cellKey,
  columnX,
  gridLength,
  gridPath,
  gridState,
  ITEM_SIZE,
  type ItemGridSize,
  plainItem,
  rowY,
  strayWords,
} from "@/lib/game/items";

import styles from "./ItemGrid.module.css";

interface ItemGridProps {
  /** Items taken, in order of time. */
  hits?: readonly Cell[];
  target: readonly Cell[] | null;
  /** CSS pixels per pixel of the drawing. */
  scale?: 1 | 2 | 3 | 4;
  /** Accessible name instead of the generated one; "" makes the grid decorative. */
  label?: string;
}

/**
 * The grid of a game's items: the remaining ones, those of the target in the accent colour; targets
 * taken as dots, strays as crosses. Nothing for a game without items or without a target, where they
 * say nothing of the behaviour.
 */
export const ItemGrid = memo(function ItemGrid({
  hits = [],
  target,
  scale = 1,
  label,
}: ItemGridProps) {
  const game = useGame();
  const { items } = game;
  if (!items || !target) return null;
  const path = viewOf(game.name)?.itemPath ?? plainItem;
  const state = gridState(items, hits, target);
  const [width, height] = [gridLength(items.columns), gridLength(items.rows)];
  const name = label ?? describeGrid(items, hits, target);
  return (
    <svg
      className={styles.grid}
      viewBox={`0 0 ${width} ${height}`}
      width={width * scale}
      height={height * scale}
      {...(name === "" ? { "aria-hidden": true } : { role: "img", "aria-label": name })}
    >
      {target.map((cell) => (
        <rect
          key={cellKey(cell)}
          className={styles.target}
          x={columnX(cell[1]) - 1}
          y={rowY(cell[0], items) - 1}
          width={CELL_SIZE}
          height={CELL_SIZE}
        />
      ))}
      <path className={styles.standing} d={gridPath(state.standing, items, path)} />
      <path className={styles.missing} d={gridPath(state.missing, items, path)} />
      <path className={styles.hit} d={dots(state.hit, items)} />
      <path
        className={styles.stray}
        d={crosses(state.stray, items)}
        shapeRendering="geometricPrecision"
      />
    </svg>
  );
});

/** Describes the state of the grid in a sentence. */
function describeGrid(size: ItemGridSize, hits: readonly Cell[], target: readonly Cell[]): string {
  const { hit, stray } = gridState(size, hits, target);
  const targets = plural(target.length, { one: "# target", other: "# targets" });
  return t`${hit.length} of ${targets} hit, ${strayWords(stray.length)}`;
}

const DOT = 4;
const CROSS = 4;

function dots(cells: readonly Cell[], size: ItemGridSize): string {
  const inset = (ITEM_SIZE - DOT) / 2;
  return cells
    .map(([row, column]) => {
      const x = columnX(column) + inset;
      return `M${x} ${rowY(row, size) + inset}h${DOT}v${DOT}h${-DOT}z`;
    })
    .join("");
}

function crosses(cells: readonly Cell[], size: ItemGridSize): string {
  const inset = (ITEM_SIZE - CROSS) / 2;
  return cells
    .map(([row, column]) => {
      const x = columnX(column) + inset;
      const y = rowY(row, size) + inset;
      return `M${x} ${y}l${CROSS} ${CROSS}M${x + CROSS} ${y}l${-CROSS} ${CROSS}`;
    })
    .join("");
}

import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { WantedItems } from "@/api/types";
import gridStyles from "@/components/game/ItemGrid.module.css";
import type { WantedProps } from "@/games/view";
import {
  type Cell,
  CELL_SIZE,
  cellKey,
  cellName,
  columnX,
  gridLength,
  gridPath,
  ITEM_SIZE,
  rowY,
} from "@/lib/game/items";

import { ALL_CELLS, GRID } from "./grid";
import { spritePath } from "./sprites";
import styles from "./WantedAliens.module.css";

const SIDE = gridLength(GRID.columns);

/** Labels nearer to 0 are not sure. */
const SURE = 0.5;
/** From here on, an alien counts as one of a row that is swept. */
const IN_ORDER = 0.5;

/** All cells, bottom row first, as labels are ordered. */
const CELLS: readonly Cell[] = [...ALL_CELLS].sort((a, b) => a[0] - b[0] || a[1] - b[1]);

/** Which aliens are inferred to be wanted, which to be left alone, and which may be either. */
export function WantedAliens({ title, inferred, behaviour, scale, children }: WantedProps) {
  const { wanted, others, unsure } = sorted(inferred);
  const { missed, strange } = compared(wanted, behaviour.target);
  const keys = new Set(unsure.map(cellKey));
  const sure = (cells: readonly Cell[]) => cells.filter((cell) => !keys.has(cellKey(cell)));
  const rows = orderedRows(inferred);
  const numbers = rows.join(", ");
  const side = SIDE * scale;
  return (
    <section aria-label={title} className={styles.wanted}>
      <svg
        className={gridStyles.grid}
        viewBox={`0 0 ${SIDE} ${SIDE}`}
        width={side}
        height={side}
        role="img"
        aria-label={describe(wanted, unsure, missed)}
      >
        <path className={styles.targets} d={outline(behaviour.target ?? [])} />
        <path className={gridStyles.standing} d={gridPath(others, GRID, spritePath)} />
        <path className={gridStyles.missing} d={gridPath(wanted, GRID, spritePath)} />
        <path className={styles.unsure} d={frames(unsure)} />
      </svg>
      <div className={styles.words}>
        <h3>{title}</h3>
        <p>
          <Trans>Hit the coloured aliens, spare the grey ones.</Trans>
        </p>
        {sure(missed).length > 0 && (
          <p>
            {plural(sure(missed).length, {
              one: "# target (outlined) is not learned yet: hit it in your best games.",
              other: "# targets (outlined) are not learned yet: hit them in your best games.",
            })}
          </p>
        )}
        {sure(strange).length > 0 && (
          <p>
            {plural(sure(strange).length, {
              one: "# other alien seems wanted: put games that hit it further down.",
              other: "# other aliens seem wanted: put games that hit them further down.",
            })}
          </p>
        )}
        {unsure.length > 0 && (
          <p>
            {plural(unsure.length, {
              one: "Unsure about # alien (dashed): rank games that hit it and games that spare it.",
              other:
                "Unsure about # aliens (dashed): rank games that hit them and games that spare them.",
            })}
          </p>
        )}
        {rows.length > 0 && (
          <p>
            {plural(rows.length, {
              one: `In row ${numbers}, a wanted alien counts only once all on its left are gone.`,
              other: `In rows ${numbers}, a wanted alien counts only once all on its left are gone.`,
            })}
          </p>
        )}
        <details>
          <summary>
            <Trans>How to read this</Trans>
          </summary>
          <p>
            <Trans>
              It is inferred from the order of the games and from what the best of them hit.
            </Trans>{" "}
            {behaviour.target && (
              <Trans>The outline shows the targets, which no training ever sees.</Trans>
            )}
          </p>
          {children}
        </details>
      </div>
    </section>
  );
}

function sorted({ labels }: WantedItems): { wanted: Cell[]; others: Cell[]; unsure: Cell[] } {
  const label = (index: number) => labels[index] ?? 0;
  return {
    wanted: CELLS.filter((_, index) => label(index) > 0),
    others: CELLS.filter((_, index) => label(index) <= 0),
    unsure: CELLS.filter((_, index) => Math.abs(label(index)) < SURE),
  };
}

/** Targets that are not inferred to be wanted, and other aliens that are. */
function compared(
  wanted: readonly Cell[],
  target: readonly Cell[] | null,
): { missed: Cell[]; strange: Cell[] } {
  if (!target) return { missed: [], strange: [] };
  const [found, meant] = [new Set(wanted.map(cellKey)), new Set(target.map(cellKey))];
  return {
    missed: target.filter((cell) => !found.has(cellKey(cell))),
    strange: wanted.filter((cell) => !meant.has(cellKey(cell))),
  };
}

/** The rows, from 1, in which a wanted alien counts only once all on its left are gone. */
function orderedRows({ labels, in_order: inOrder }: WantedItems): number[] {
  const ordered = CELLS.filter(
    (_, index) => (labels[index] ?? 0) > 0 && (inOrder[index] ?? 0) > IN_ORDER,
  );
  return [...new Set(ordered.map(([row]) => row + 1))];
}

function describe(
  wanted: readonly Cell[],
  unsure: readonly Cell[],
  missed: readonly Cell[],
): string {
  const names = wanted.map(cellName).join("; ");
  return [
    wanted.length === 0 ? t`No alien is to be hit` : t`To be hit: ${names}`,
    missed.length > 0 && t`Targets among the others: ${missed.map(cellName).join("; ")}`,
    unsure.length > 0 && t`Not sure: ${unsure.map(cellName).join("; ")}`,
  ]
    .filter(Boolean)
    .join(". ");
}

/** The outline of cells, as one SVG path of the sides that no two of them share. */
function outline(cells: readonly Cell[]): string {
  const keys = new Set(cells.map(cellKey));
  const gap = (CELL_SIZE - ITEM_SIZE) / 2;
  return cells
    .map(([row, column]) => {
      const [left, top] = [columnX(column) - gap, rowY(row, GRID) - gap];
      const [right, bottom] = [left + CELL_SIZE, top + CELL_SIZE];
      return [
        !keys.has(cellKey([row + 1, column])) && `M${left} ${top}H${right}`,
        !keys.has(cellKey([row - 1, column])) && `M${left} ${bottom}H${right}`,
        !keys.has(cellKey([row, column - 1])) && `M${left} ${top}V${bottom}`,
        !keys.has(cellKey([row, column + 1])) && `M${right} ${top}V${bottom}`,
      ]
        .filter(Boolean)
        .join("");
    })
    .join("");
}

/** Frames around cells, as one SVG path. */
function frames(cells: readonly Cell[]): string {
  const side = ITEM_SIZE + 1;
  return cells
    .map(([row, column]) => {
      const [x, y] = [columnX(column) - 0.5, rowY(row, GRID) - 0.5];
      return `M${x} ${y}h${side}v${side}h${-side}z`;
    })
    .join("");
}

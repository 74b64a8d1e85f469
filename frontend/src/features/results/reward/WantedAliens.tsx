import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Behaviour, WantedAliens as Inferred } from "@/api/types";
import gridStyles from "@/components/game/AlienGrid.module.css";
import {
  ALL_CELLS,
  type Cell,
  CELL_SIZE,
  cellKey,
  cellName,
  columnX,
  GRID_SIZE,
  gridPath,
  rowY,
  SPRITE_SIZE,
} from "@/lib/game/aliens";

import styles from "./reward.module.css";

interface WantedAliensProps {
  inferred: Inferred;
  behaviour: Behaviour;
}

/** Labels nearer to 0 are not sure. */
const SURE = 0.5;
const SCALE = 3;

/** All cells, bottom row first, as labels are ordered. */
const CELLS: readonly Cell[] = [...ALL_CELLS].sort((a, b) => a[0] - b[0] || a[1] - b[1]);

/** Which aliens the reward was inferred to want, to leave alone, or not to know. */
export function WantedAliens({ inferred, behaviour }: WantedAliensProps) {
  const { wanted, others, unsure } = sorted(inferred);
  const rows = orderedRows(inferred);
  const numbers = rows.join(", ");
  const side = GRID_SIZE * SCALE;
  return (
    <section aria-label={t`What the reward wants`} className={styles.wanted}>
      <svg
        className={gridStyles.grid}
        viewBox={`0 0 ${GRID_SIZE} ${GRID_SIZE}`}
        width={side}
        height={side}
        role="img"
        aria-label={describe(wanted, unsure)}
      >
        {behaviour.target?.map(([row, column]) => (
          <rect
            key={cellKey([row, column])}
            className={gridStyles.target}
            x={columnX(column) - 1}
            y={rowY(row) - 1}
            width={CELL_SIZE}
            height={CELL_SIZE}
          />
        ))}
        <path className={gridStyles.standing} d={gridPath(others)} />
        <path className={gridStyles.missing} d={gridPath(wanted)} />
        <path className={styles.unsure} d={frames(unsure)} />
      </svg>
      <div className={styles.words}>
        <h3>
          <Trans>What the reward wants</Trans>
        </h3>
        <p>
          <Trans>
            From the order of your games, and from what the best of them hit: coloured aliens are to
            be hit, grey ones to be left alone.
          </Trans>{" "}
          {behaviour.target && (
            <Trans>Shaded places are the behaviour&rsquo;s targets, which it never sees.</Trans>
          )}
        </p>
        {unsure.length > 0 && (
          <p>
            {plural(unsure.length, {
              one: "It is not sure of # alien, which has a frame. Ranked games that hit it, and games that could have and did not, would tell.",
              other:
                "It is not sure of # aliens, which have a frame. Ranked games that hit them, and games that could have and did not, would tell.",
            })}
          </p>
        )}
        {rows.length > 0 && (
          <p>
            {plural(rows.length, {
              one: `In row ${numbers}, they count from left to right.`,
              other: `In rows ${numbers}, they count from left to right.`,
            })}
          </p>
        )}
      </div>
    </section>
  );
}

function sorted({ labels }: Inferred): { wanted: Cell[]; others: Cell[]; unsure: Cell[] } {
  const label = (index: number) => labels[index] ?? 0;
  return {
    wanted: CELLS.filter((_, index) => label(index) > 0),
    others: CELLS.filter((_, index) => label(index) <= 0),
    unsure: CELLS.filter((_, index) => Math.abs(label(index)) < SURE),
  };
}

/** The rows, from 1, in which a wanted alien counts only once all on its left are gone. */
function orderedRows({ labels, in_order: inOrder }: Inferred): number[] {
  const ordered = CELLS.filter(
    (_, index) => (labels[index] ?? 0) > 0 && (inOrder[index] ?? 0) > SURE,
  );
  return [...new Set(ordered.map(([row]) => row + 1))];
}

function describe(wanted: readonly Cell[], unsure: readonly Cell[]): string {
  const names = wanted.map(cellName).join("; ");
  const what = wanted.length === 0 ? t`No alien is to be hit` : t`To be hit: ${names}`;
  const doubts = unsure.map(cellName).join("; ");
  return unsure.length === 0 ? what : t`${what}. Not sure: ${doubts}`;
}

/** Frames around cells, as one SVG path. */
function frames(cells: readonly Cell[]): string {
  const side = SPRITE_SIZE + 1;
  return cells
    .map(([row, column]) => {
      const [x, y] = [columnX(column) - 0.5, rowY(row) - 0.5];
      return `M${x} ${y}h${side}v${side}h${-side}z`;
    })
    .join("");
}

import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { type KeyboardEvent, useRef, useState } from "react";

import { Button } from "@/components/controls/Button";
import { ordinal } from "@/lib/format";
import {
  ALL_CELLS,
  type Cell,
  cellKey,
  cellName,
  COLUMNS,
  ROWS,
  SPRITE_SIZE,
  spritePath,
} from "@/lib/game/aliens";

import styles from "./AlienPicker.module.css";
import { columnCells, neighbour, rowCells, toggleCell, toggleLine } from "./targets";

interface AlienPickerProps {
  /** The chosen cells, in order of choice. */
  value: readonly Cell[];
  onChange: (value: readonly Cell[]) => void;
  /** Whether the cells are numbered in order of choice. */
  ordered: boolean;
}

const TOP_ROW_FIRST = Array.from({ length: ROWS }, (_, index) => ROWS - 1 - index);

/** Chooses target cells on the grid of aliens, by mouse, touch or keyboard. */
export function AlienPicker({ value, onChange, ordered }: AlienPickerProps) {
  const [active, setActive] = useState<Cell>([0, 0]);
  const board = useRef<HTMLDivElement>(null);
  const places = new Map(value.map((cell, index) => [cellKey(cell), index + 1]));

  function move(event: KeyboardEvent, from: Cell) {
    const to = neighbour(from, event.key);
    if (!to) return;
    event.preventDefault();
    setActive(to);
    board.current?.querySelector<HTMLElement>(`[data-cell="${cellKey(to)}"]`)?.focus();
  }

  return (
    <div className={styles.picker}>
      <div className={styles.board} role="group" aria-label={t`Target aliens`} ref={board}>
        {TOP_ROW_FIRST.map((row) => (
          <div key={row} className={styles.line}>
            <button
              type="button"
              className={styles.header}
              aria-label={t`All of row ${row + 1}`}
              onClick={() => onChange(toggleLine(value, rowCells(row)))}
            >
              {row + 1}
            </button>
            {ALL_CELLS.filter((cell) => cell[0] === row).map((cell) => {
              const place = places.get(cellKey(cell));
              const isActive = cellKey(cell) === cellKey(active);
              const name = cellName(cell);
              return (
                <button
                  key={cellKey(cell)}
                  type="button"
                  className={styles.cell}
                  data-cell={cellKey(cell)}
                  aria-pressed={place !== undefined}
                  aria-label={
                    place && ordered
                      ? t`Alien in ${name}, ${ordinal(place)} in the order`
                      : t`Alien in ${name}`
                  }
                  tabIndex={isActive ? 0 : -1}
                  onFocus={() => setActive(cell)}
                  onKeyDown={(event) => move(event, cell)}
                  onClick={() => onChange(toggleCell(value, cell))}
                >
                  <Sprite row={row} />
                  {ordered && place && <span className={styles.order}>{place}</span>}
                </button>
              );
            })}
          </div>
        ))}
        <span />
        {Array.from({ length: COLUMNS }, (_, column) => (
          <button
            key={column}
            type="button"
            className={styles.header}
            aria-label={t`All of column ${column + 1}`}
            onClick={() => onChange(toggleLine(value, columnCells(column)))}
          >
            {column + 1}
          </button>
        ))}
      </div>
      <div className={styles.foot}>
        <span>
          <Trans>
            <Plural value={value.length} one="# alien" other="# aliens" /> chosen
          </Trans>
        </span>
        {value.length > 0 && (
          <Button kind="quiet" onClick={() => onChange([])}>
            <Trans>Clear</Trans>
          </Button>
        )}
      </div>
    </div>
  );
}

function Sprite({ row }: { row: number }) {
  return (
    <svg
      viewBox={`0 0 ${SPRITE_SIZE} ${SPRITE_SIZE}`}
      width={SPRITE_SIZE * 3}
      height={SPRITE_SIZE * 3}
      aria-hidden="true"
    >
      <path d={spritePath(row, 0, 0)} />
    </svg>
  );
}

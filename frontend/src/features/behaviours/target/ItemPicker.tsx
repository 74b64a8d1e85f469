import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { type CSSProperties, type KeyboardEvent, useRef, useState } from "react";

import type { TaughtGame } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { viewOf } from "@/games/views";
import { wordsOf } from "@/games/words";
import { ordinal } from "@/lib/format";
import { allCells, type Cell, cellKey, cellName, ITEM_SIZE, plainItem } from "@/lib/game/items";

import styles from "./ItemPicker.module.css";
import { columnCells, neighbour, rowCells, toggleCell, toggleLine } from "./targets";

interface ItemPickerProps {
  game: TaughtGame;
  items: NonNullable<TaughtGame["items"]>;
  /** The chosen cells, in order of choice. */
  value: readonly Cell[];
  onChange: (value: readonly Cell[]) => void;
  /** Whether the cells are numbered in order of choice. */
  ordered: boolean;
}

/** Chooses targets on the grid of a game's items, by mouse, touch or keyboard. */
export function ItemPicker({ game, items, value, onChange, ordered }: ItemPickerProps) {
  const words = wordsOf(game);
  const path = viewOf(game.name)?.itemPath ?? plainItem;
  const rows = Array.from({ length: items.rows }, (_, index) => items.rows - 1 - index);
  const [active, setActive] = useState<Cell>([0, 0]);
  const board = useRef<HTMLDivElement>(null);
  const places = new Map(value.map((cell, index) => [cellKey(cell), index + 1]));

  function move(event: KeyboardEvent, from: Cell) {
    const to = neighbour(from, event.key, items);
    if (!to) return;
    event.preventDefault();
    setActive(to);
    board.current?.querySelector<HTMLElement>(`[data-cell="${cellKey(to)}"]`)?.focus();
  }

  return (
    <div className={styles.picker}>
      <div
        className={styles.board}
        style={{ "--columns": items.columns } as CSSProperties}
        role="group"
        aria-label={words.targets()}
        ref={board}
      >
        {rows.map((row) => (
          <div key={row} className={styles.line}>
            <button
              type="button"
              className={styles.header}
              aria-label={t`All of row ${row + 1}`}
              onClick={() => onChange(toggleLine(value, rowCells(row, items)))}
            >
              {row + 1}
            </button>
            {allCells(items)
              .filter((cell) => cell[0] === row)
              .map((cell) => {
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
                        ? t`${words.at(name)}, ${ordinal(place)} in the order`
                        : words.at(name)
                    }
                    tabIndex={isActive ? 0 : -1}
                    onFocus={() => setActive(cell)}
                    onKeyDown={(event) => move(event, cell)}
                    onClick={() => onChange(toggleCell(value, cell))}
                  >
                    <svg
                      viewBox={`0 0 ${ITEM_SIZE} ${ITEM_SIZE}`}
                      width={ITEM_SIZE * 3}
                      height={ITEM_SIZE * 3}
                      aria-hidden="true"
                    >
                      <path d={path(row, 0, 0)} />
                    </svg>
                    {ordered && place && <span className={styles.order}>{place}</span>}
                  </button>
                );
              })}
          </div>
        ))}
        <span />
        {Array.from({ length: items.columns }, (_, column) => (
          <button
            key={column}
            type="button"
            className={styles.header}
            aria-label={t`All of column ${column + 1}`}
            onClick={() => onChange(toggleLine(value, columnCells(column, items)))}
          >
            {column + 1}
          </button>
        ))}
      </div>
      <div className={styles.foot}>
        <span>{words.chosen(value.length)}</span>
        {value.length > 0 && (
          <Button kind="quiet" onClick={() => onChange([])}>
            <Trans>Clear</Trans>
          </Button>
        )}
      </div>
    </div>
  );
}

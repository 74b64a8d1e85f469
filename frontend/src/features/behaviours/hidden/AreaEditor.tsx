import { t } from "@lingui/core/macro";
import { type KeyboardEvent, type PointerEvent, useRef } from "react";

import { useGame } from "@/games/game";

import { type Area, between, MOST_AREAS, moved, resized } from "./areas";
import styles from "./HiddenAreas.module.css";

interface AreaEditorProps {
  areas: readonly Area[];
  readOnly: boolean;
  /** Whether what is in the areas stays visible. */
  outlined?: boolean;
  onChange: (areas: readonly Area[]) => void;
}

/** What a pointer drags, and where from, in pixels of the screen. */
interface Drag {
  readonly kind: "draw" | "move" | "resize";
  readonly index: number;
  readonly from: { readonly x: number; readonly y: number };
  readonly before: readonly Area[];
}

const KEY_STEPS: Readonly<Record<string, { readonly x: number; readonly y: number }>> = {
  ArrowLeft: { x: -1, y: 0 },
  ArrowRight: { x: 1, y: 0 },
  ArrowUp: { x: 0, y: -1 },
  ArrowDown: { x: 0, y: 1 },
};

/**
 * The picture of the game with the covered areas: drawn, moved and resized by a pointer; moved by
 * the arrow keys, resized with Shift, removed by Delete.
 */
export function AreaEditor({ areas, readOnly, outlined, onChange }: AreaEditorProps) {
  const game = useGame();
  const stage = useRef<HTMLDivElement>(null);
  const drag = useRef<Drag | null>(null);
  const replace = (index: number, area: Area, all = areas) =>
    onChange(all.map((old, at) => (at === index ? area : old)));

  function at(event: PointerEvent) {
    const box = stage.current?.getBoundingClientRect();
    if (!box) return { x: 0, y: 0 };
    return {
      x: ((event.clientX - box.left) / Math.max(box.width, 1)) * game.width,
      y: ((event.clientY - box.top) / Math.max(box.height, 1)) * game.height,
    };
  }

  function begin(event: PointerEvent<HTMLElement>, kind: Drag["kind"], index: number) {
    if (readOnly || event.button !== 0) return;
    if (kind === "draw" && areas.length >= MOST_AREAS) return;
    event.stopPropagation();
    event.currentTarget.setPointerCapture(event.pointerId);
    drag.current = { kind, index, from: at(event), before: areas };
  }

  function onMove(event: PointerEvent) {
    if (!drag.current) return;
    const { kind, index, from, before } = drag.current;
    const to = at(event);
    const by = { x: to.x - from.x, y: to.y - from.y };
    const old = before[index];
    if (kind === "draw") onChange([...before, between(from, to, game)]);
    else if (old) replace(index, (kind === "move" ? moved : resized)(old, by, game), before);
  }

  const end = () => {
    drag.current = null;
  };

  function onKey(event: KeyboardEvent, index: number, area: Area) {
    if (readOnly) return;
    const by = KEY_STEPS[event.key];
    if (by) {
      event.preventDefault();
      replace(index, (event.shiftKey ? resized : moved)(area, by, game));
    } else if (event.key === "Delete" || event.key === "Backspace") {
      event.preventDefault();
      onChange(areas.filter((_, place) => place !== index));
    }
  }

  return (
    // Drawing has buttons and fields beside it.
    <div
      ref={stage}
      className={styles.stage}
      data-fixed={readOnly || undefined}
      data-outlined={outlined}
      style={{ aspectRatio: (game.width * game.pixel_aspect) / game.height }}
      onPointerDown={(event) => begin(event, "draw", areas.length)}
      onPointerMove={onMove}
      onPointerUp={end}
      onPointerCancel={end}
    >
      <img
        src={game.picture_url}
        alt={t`The game, some seconds after its start`}
        draggable={false}
      />
      {areas.map((area, index) => {
        const [left, top, right, bottom] = area;
        return (
          <button
            key={index}
            type="button"
            className={styles.area}
            aria-label={t`Area ${index + 1}: from ${left}, ${top} to ${right}, ${bottom}`}
            style={{
              left: `${(left / game.width) * 100}%`,
              top: `${(top / game.height) * 100}%`,
              width: `${((right - left) / game.width) * 100}%`,
              height: `${((bottom - top) / game.height) * 100}%`,
            }}
            onKeyDown={(event) => onKey(event, index, area)}
            onPointerDown={(event) => begin(event, "move", index)}
          >
            {!readOnly && (
              <span
                className={styles.corner}
                onPointerDown={(event) => begin(event, "resize", index)}
              />
            )}
          </button>
        );
      })}
    </div>
  );
}

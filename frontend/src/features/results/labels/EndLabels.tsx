import { type CSSProperties, type RefObject, useLayoutEffect, useRef } from "react";
import type uPlot from "uplot";

import { classes } from "@/lib/classes";

import { spreadLabels } from "./spread-labels";
import styles from "./EndLabels.module.css";

/** What stands at the end of a line. */
export interface EndLabel {
  readonly name: string;
  readonly colour: string;
  readonly dashed: boolean;
  /** The value shown, formatted. */
  readonly value: string;
  /** The lowest and highest value of the band around it, formatted; null without one. */
  readonly bounds: string | null;
  /** The last value of what is shown of the line, where the label stands; null if there is none. */
  readonly last: number | null;
}

/** Lines with labels of two rows; of more lines there is room for one row each. */
const MOST_IN_ROWS = 3;
const GAP_PX = 6;

interface EndLabelsProps {
  labels: readonly EndLabel[];
  /** Whether a single line has its name, too: the chart's title does not say whose it is. */
  isNamed: boolean;
  plot: RefObject<uPlot | null>;
  /** Called with the room that the labels take beside the lines, in pixels. */
  onWidth: (width: number) => void;
}

/** Names and values at the ends of a chart's lines, in their colours. */
export function EndLabels({ labels, isNamed, plot, onWidth }: EndLabelsProps) {
  const list = useRef<HTMLUListElement>(null);
  useLayoutEffect(() => {
    const over = plot.current?.over;
    if (!over || !list.current) return;
    const items = [...list.current.children].filter((item) => item instanceof HTMLElement);
    const centres = labels.map(
      ({ last }) => over.offsetTop + (last === null ? 0 : (plot.current?.valToPos(last, "y") ?? 0)),
    );
    const tops = spreadLabels(
      centres,
      items.map((item) => item.offsetHeight),
      over.offsetTop + over.offsetHeight,
    );
    for (const [index, item] of items.entries()) {
      item.style.insetBlockStart = `${tops[index] ?? 0}px`;
      item.style.insetInlineStart = `${over.offsetLeft + over.offsetWidth + GAP_PX}px`;
    }
    onWidth(GAP_PX + Math.max(0, ...items.map((item) => item.offsetWidth)));
  });
  const hasNames = isNamed || labels.length > 1;
  const inRows = hasNames && labels.length <= MOST_IN_ROWS;
  return (
    <ul ref={list} className={classes(styles.labels, inRows && styles.inRows)}>
      {labels.map(({ name, colour, dashed, value, bounds }) => (
        <li key={name} style={{ "--curve": colour } as CSSProperties}>
          {hasNames && (
            <span className={styles.name} title={name}>
              <i className={classes(dashed && styles.dashed)} aria-hidden="true" />
              {name}
            </span>
          )}
          <b>{value}</b>
          {bounds !== null && labels.length <= MOST_IN_ROWS && <small>{bounds}</small>}
        </li>
      ))}
    </ul>
  );
}

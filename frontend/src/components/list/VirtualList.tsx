/** Lists of any length, of which only what is in sight is in the document. */
import {
  defaultRangeExtractor,
  observeElementRect,
  type Range,
  useVirtualizer,
  useWindowVirtualizer,
  type Virtualizer,
} from "@tanstack/react-virtual";
import {
  type ReactNode,
  type RefObject,
  useCallback,
  useLayoutEffect,
  useRef,
  useState,
} from "react";

import { classes } from "@/lib/classes";

import styles from "./VirtualList.module.css";

interface VirtualListProps {
  label: string;
  ids: readonly number[];
  renderItem: (id: number) => ReactNode;
  /** Height of a row before it is laid out, in CSS pixels. */
  rowPx: number;
  /** Space between rows, in CSS pixels; that between columns is the class's. */
  gapPx: number;
  /** Class of the list and of each of its rows. A grid has as many columns as the class lays out. */
  className: string | undefined;
  /** Items that stay in the document wherever the list is scrolled to; so does what has the focus. */
  pinned?: readonly number[];
}

/** Rows beyond those in sight that are laid out, so that the Tab key finds what comes next. */
const OVERSCAN = 3;

/** A list that scrolls with the window. */
export function WindowList(props: VirtualListProps) {
  const list = useRef<HTMLDivElement>(null);
  const [top, setTop] = useState(0);
  const columns = useColumns(list);
  const range = useRange(props, columns);
  const keyOfRow = useRowKeys(props.ids, columns);
  // What stands above it may change with any rendering; the same number renders nothing.
  // eslint-disable-next-line react-hooks/exhaustive-deps
  useLayoutEffect(() => {
    const box = list.current?.getBoundingClientRect();
    // Whole pixels, so that rounding renders nothing anew.
    if (box) setTop(Math.round(box.top + window.scrollY));
  });
  const virtualizer = useWindowVirtualizer<HTMLDivElement>({
    ...optionsOf(props, columns),
    ...range.options,
    getItemKey: keyOfRow,
    scrollMargin: top,
  });
  return <Rows {...props} {...{ list, columns, virtualizer, top, onFocused: range.setFocused }} />;
}

/** A list within an element that scrolls. */
export function ScrolledList(props: VirtualListProps & { scroller: HTMLElement | null }) {
  const { scroller } = props;
  const list = useRef<HTMLDivElement>(null);
  const [top, setTop] = useState(0);
  const columns = useColumns(list);
  const range = useRange(props, columns);
  const keyOfRow = useRowKeys(props.ids, columns);
  // eslint-disable-next-line react-hooks/exhaustive-deps
  useLayoutEffect(() => {
    const box = list.current?.getBoundingClientRect();
    const outer = scroller?.getBoundingClientRect();
    if (box && outer && scroller) setTop(Math.round(box.top - outer.top + scroller.scrollTop));
  });
  // eslint-disable-next-line react-hooks/incompatible-library -- Rows get the virtualizer itself.
  const virtualizer = useVirtualizer<HTMLElement, HTMLDivElement>({
    ...optionsOf(props, columns),
    ...range.options,
    getItemKey: keyOfRow,
    getScrollElement: () => scroller,
    // What is not laid out yet may become as high as the window.
    observeElementRect: (instance, tell) =>
      observeElementRect(instance, ({ width, height }) =>
        tell({ width, height: height || window.innerHeight }),
      ),
    scrollMargin: top,
  });
  return <Rows {...props} {...{ list, columns, virtualizer, top, onFocused: range.setFocused }} />;
}

function optionsOf({ ids, rowPx, gapPx }: VirtualListProps, columns: number) {
  return {
    count: Math.ceil(ids.length / columns),
    estimateSize: () => rowPx,
    measureElement: (row: HTMLDivElement) => row.offsetHeight || rowPx,
    gap: gapPx,
    overscan: OVERSCAN,
  };
}

/**
 * Names a row by its items, so that rows whose items change are measured anew. All rows are, where the
 * function is another one.
 */
function useRowKeys(ids: readonly number[], columns: number): (row: number) => string {
  return useCallback(
    (row) => ids.slice(row * columns, (row + 1) * columns).join(" "),
    [ids, columns],
  );
}

/** Keeps the rows of pinned items, and of the one that has the focus, in the document. */
function useRange({ ids, pinned = [] }: VirtualListProps, columns: number) {
  const [focused, setFocused] = useState<number | null>(null);
  const kept = focused === null ? pinned : [...pinned, focused];
  const rows = kept.map((id) => Math.floor(ids.indexOf(id) / columns)).filter((row) => row >= 0);
  const rangeExtractor = (range: Range) =>
    [...new Set([...defaultRangeExtractor(range), ...rows])].sort((a, b) => a - b);
  return { options: { rangeExtractor }, setFocused };
}

/** Returns how many columns the class lays out in the list's width. */
function useColumns(list: RefObject<HTMLElement | null>): number {
  const [columns, setColumns] = useState(1);
  useLayoutEffect(() => {
    const element = list.current;
    if (!element) return undefined;
    const count = () => {
      const tracks = getComputedStyle(element).gridTemplateColumns;
      setColumns(/^\d/.test(tracks) ? tracks.split(" ").length : 1);
    };
    count();
    const observer = new ResizeObserver(count);
    observer.observe(element);
    return () => observer.disconnect();
  }, [list]);
  return columns;
}

function Rows<Scroller extends Element | Window>({
  label,
  ids,
  renderItem,
  className,
  list,
  columns,
  virtualizer,
  top,
  onFocused,
}: VirtualListProps & {
  list: RefObject<HTMLDivElement | null>;
  columns: number;
  virtualizer: Virtualizer<Scroller, HTMLDivElement>;
  /** Where the list begins in what scrolls. */
  top: number;
  onFocused: (id: number | null) => void;
}) {
  return (
    <div
      ref={list}
      role="list"
      aria-label={label}
      className={classes(styles.list, className)}
      style={{ height: virtualizer.getTotalSize() }}
    >
      {virtualizer.getVirtualItems().map(({ key, index, start }) => (
        <div
          key={key}
          ref={virtualizer.measureElement}
          data-index={index}
          role="presentation"
          className={classes(styles.row, className)}
          style={{ transform: `translateY(${start - top}px)` }}
        >
          {ids.slice(index * columns, (index + 1) * columns).map((id, column) => (
            <div
              key={id}
              role="listitem"
              aria-setsize={ids.length}
              aria-posinset={index * columns + column + 1}
              onFocus={() => onFocused(id)}
              onBlur={() => onFocused(null)}
            >
              {renderItem(id)}
            </div>
          ))}
        </div>
      ))}
    </div>
  );
}

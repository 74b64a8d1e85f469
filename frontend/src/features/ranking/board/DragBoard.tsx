/** Drag and drop by mouse, touch and keyboard; the only module that uses dnd-kit. */
import { t } from "@lingui/core/macro";
import {
  type Announcements,
  closestCenter,
  type CollisionDetection,
  DndContext,
  type DragEndEvent,
  DragOverlay,
  KeyboardSensor,
  type KeyboardCoordinateGetter,
  MouseSensor,
  pointerWithin,
  TouchSensor,
  useDraggable,
  useDroppable,
  useSensor,
  useSensors,
} from "@dnd-kit/core";
import {
  createContext,
  type ReactNode,
  useContext,
  useEffect,
  useEffectEvent,
  useMemo,
  useRef,
  useState,
} from "react";

import styles from "./DragBoard.module.css";

const MOUSE = { activationConstraint: { distance: 5 } };
// A short delay, so that touch can still scroll the page.
const TOUCH = { activationConstraint: { delay: 180, tolerance: 8 } };
const Dragged = createContext<number | null>(null);
const instructions = () => ({
  draggable: t`Press space to pick it up, the up and down arrow keys to choose a place, space to drop it, Escape to cancel.`,
});

interface DragBoardProps {
  /** All drop targets, in the order of the arrow keys. */
  places: readonly string[];
  /** Whether a place, such as the gap between two tiers, extends over its neighbours. */
  isThin: (place: string) => boolean;
  nameOfItem: (item: string) => string;
  nameOfPlace: (place: string) => string;
  /** Called when a drag begins, and when it is over, after `onDrop`. */
  onDragging: (dragging: boolean) => void;
  onDrop: (item: string, place: string, byKeyboard: boolean) => void;
  renderDragged: (item: string) => ReactNode;
  children: ReactNode;
}

/** Context for draggable items and drop places. */
export function DragBoard(props: DragBoardProps) {
  const { places, isThin, nameOfItem, nameOfPlace, onDragging, onDrop, renderDragged, children } =
    props;
  const [dragged, setDragged] = useState<string | null>(null);
  /** The place chosen by arrow key, which takes precedence over where the item is drawn. */
  const chosen = useRef<string | null>(null);
  const hasMoved = useRef(false);

  const coordinates: KeyboardCoordinateGetter = (event, { context, currentCoordinates }) => {
    const step = { ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1 }[event.code];
    if (step === undefined) return undefined;
    event.preventDefault();
    const at = places.indexOf(chosen.current ?? String(context.over?.id ?? ""));
    // Down from the games that are not ranked, which come last, is the best place.
    const wraps = chosen.current === null && at === places.length - 1 && step > 0;
    const next = wraps ? places[0] : places[Math.min(Math.max(at + step, 0), places.length - 1)];
    if (next === undefined) return undefined;
    chosen.current = next;
    context.droppableContainers.get(next)?.node.current?.scrollIntoView({ block: "nearest" });
    const rect = context.droppableRects.get(next);
    return rect ? { x: rect.left + 24, y: rect.top } : currentCoordinates;
  };

  const sensors = useSensors(
    useSensor(MouseSensor, MOUSE),
    useSensor(TouchSensor, TOUCH),
    useSensor(KeyboardSensor, { coordinateGetter: coordinates }),
  );

  const collision: CollisionDetection = (args) => {
    if (chosen.current !== null) {
      const container = args.droppableContainers.find(({ id }) => id === chosen.current);
      return container ? [{ id: container.id }] : [];
    }
    if (!args.pointerCoordinates) return closestCenter(args);
    return thinUnder(args, isThin) ?? pointerWithin(args);
  };

  const announcements = useMemo<Announcements>(
    () => ({
      onDragStart: ({ active }) => t`Picked up ${nameOfItem(String(active.id))}.`,
      onDragOver: ({ active, over }) => {
        const first = !hasMoved.current;
        hasMoved.current = true;
        // Announcing its own place at once would interrupt the announcement of the pick-up.
        if (first && over?.id === placeOf(active.data.current)) return undefined;
        return over ? t`Over ${nameOfPlace(String(over.id))}.` : t`Not over a place.`;
      },
      onDragEnd: ({ active, over }) =>
        over
          ? t`Dropped ${nameOfItem(String(active.id))}: ${nameOfPlace(String(over.id))}.`
          : t`${nameOfItem(String(active.id))} stays where it was.`,
      onDragCancel: ({ active }) => t`${nameOfItem(String(active.id))} stays where it was.`,
    }),
    [nameOfItem, nameOfPlace],
  );

  const end = () => {
    chosen.current = null;
    setDragged(null);
    onDragging(false);
  };
  const whenLeft = useEffectEvent(() => {
    if (dragged !== null) onDragging(false);
  });
  useEffect(() => () => whenLeft(), []);

  return (
    <DndContext
      sensors={sensors}
      collisionDetection={collision}
      accessibility={{ announcements, screenReaderInstructions: instructions() }}
      onDragStart={({ active, activatorEvent }) => {
        setDragged(String(active.id));
        onDragging(true);
        hasMoved.current = false;
        // The arrow keys start from the item's own place.
        chosen.current =
          activatorEvent instanceof KeyboardEvent ? placeOf(active.data.current) : null;
      }}
      onDragCancel={end}
      onDragEnd={({ active, over, activatorEvent }: DragEndEvent) => {
        const byKeyboard = activatorEvent instanceof KeyboardEvent;
        if (over) onDrop(String(active.id), String(over.id), byKeyboard);
        end();
      }}
    >
      <Dragged value={dragged === null ? null : Number(dragged)}>{children}</Dragged>
      <DragOverlay dropAnimation={null}>
        {dragged !== null && <div className={styles.overlay}>{renderDragged(dragged)}</div>}
      </DragOverlay>
    </DndContext>
  );
}

function placeOf(data: Record<string, unknown> | undefined): string | null {
  return typeof data?.place === "string" ? data.place : null;
}

/** How far a thin place extends over its neighbours. */
const REACH_PX = 13;

function thinUnder(
  { pointerCoordinates, droppableContainers, droppableRects }: Parameters<CollisionDetection>[0],
  isThin: (place: string) => boolean,
): ReturnType<CollisionDetection> | null {
  if (!pointerCoordinates) return null;
  const { x, y } = pointerCoordinates;
  for (const { id } of droppableContainers) {
    const rect = droppableRects.get(id);
    if (!rect || !isThin(String(id))) continue;
    const middle = rect.top + rect.height / 2;
    const reach = Math.max(rect.height / 2, REACH_PX);
    if (x >= rect.left && x <= rect.right && Math.abs(y - middle) <= reach) return [{ id }];
  }
  return null;
}

/** Makes an item draggable: anywhere by mouse or touch, by keyboard at its handle. */
export function useDragItem(item: string, place: string) {
  const { attributes, listeners, setNodeRef, setActivatorNodeRef, isDragging } = useDraggable({
    id: item,
    data: { place },
  });
  return {
    setItem: setNodeRef,
    setHandle: setActivatorNodeRef,
    listeners,
    descriptionId: attributes["aria-describedby"],
    isDragging,
  };
}

/** Returns the item that is dragged, by its number; null while none is. */
export function useDragged(): number | null {
  return useContext(Dragged);
}

/** Makes an element a drop place. */
export function useDropPlace(place: string) {
  const { setNodeRef, isOver } = useDroppable({ id: place });
  return { setPlace: setNodeRef, isOver };
}

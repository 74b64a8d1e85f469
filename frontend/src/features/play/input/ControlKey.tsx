import { type Control, useKeyMap, useKeyNames } from "./keys";

/** The first key of a control, on a button with the same effect. */
export function ControlKey({ control }: { control: Control }) {
  const [keys] = useKeyMap();
  const nameOf = useKeyNames();
  const code = keys[control]?.[0];
  return code === undefined ? null : <kbd>{nameOf(code)}</kbd>;
}

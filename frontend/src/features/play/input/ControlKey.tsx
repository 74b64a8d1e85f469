import { useSetting } from "@/features/play/settings/stored";

import { type Control, KEYS, useKeyNames } from "./keys";

/** The first key of a control, on a button with the same effect. */
export function ControlKey({ control }: { control: Control }) {
  const [keys] = useSetting(KEYS);
  const nameOf = useKeyNames();
  const [code] = keys[control];
  return code === undefined ? null : <kbd>{nameOf(code)}</kbd>;
}

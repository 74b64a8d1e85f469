/** Indexed as in the exchange format; two keys together are one action. */
const ACTION_NAMES = [
  "nothing",
  "fire",
  "right",
  "left",
  "right and fire",
  "left and fire",
] as const;

/** Names an action by its number. */
export function actionName(action: number): string {
  return ACTION_NAMES[action] ?? `action ${action}`;
}

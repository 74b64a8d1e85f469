import { t } from "@lingui/core/macro";

/** Indexed as in the exchange format; two keys together are one action. */
const actionNames = (): readonly string[] => [
  t`nothing`,
  t`fire`,
  t`right`,
  t`left`,
  t`right and fire`,
  t`left and fire`,
];

/** Names an action by its number. */
export function actionName(action: number): string {
  return actionNames()[action] ?? t`action ${action}`;
}

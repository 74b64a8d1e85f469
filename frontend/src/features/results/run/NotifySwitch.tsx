import { t } from "@lingui/core/macro";
import { useState } from "react";

import { Checkbox } from "@/components/controls/Field";
import {
  allowNotifications,
  areNotificationsOn,
  turnNotificationsOff,
} from "@/lib/browser/notifications";

const refusal = () =>
  t`The browser blocks notifications from this page. Allow them in its settings for this address.`;

/** The switch of the browser's notifications of runs that end. */
export function NotifySwitch() {
  const [on, setOn] = useState(areNotificationsOn);
  const [refused, setRefused] = useState(false);
  if (!("Notification" in globalThis)) return null;
  const change = async (wanted: boolean) => {
    if (!wanted) turnNotificationsOff();
    const allowed = wanted && (await allowNotifications());
    setOn(allowed);
    setRefused(wanted && !allowed);
  };
  return (
    <Checkbox
      label={t`Notify me when a run ends`}
      hint={refused ? refusal() : t`Shown by the browser while a page of Tril is open.`}
      checked={on}
      onChange={(wanted) => void change(wanted)}
    />
  );
}

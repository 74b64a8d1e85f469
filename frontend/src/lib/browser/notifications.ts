/** Notifications by the browser, if the person turned them on and the browser allows them. */
import { ofBrowser } from "@/lib/browser/storage";

const KEY = "tril-notify";

export function areNotificationsOn(): boolean {
  return (
    "Notification" in globalThis &&
    Notification.permission === "granted" &&
    ofBrowser.read(KEY) === "on"
  );
}

/** Asks the browser for permission; returns whether it was given. */
export async function allowNotifications(): Promise<boolean> {
  const allowed = (await Notification.requestPermission()) === "granted";
  if (allowed) ofBrowser.write(KEY, "on");
  return allowed;
}

export function turnNotificationsOff(): void {
  ofBrowser.remove(KEY);
}

/**
 * Shows a notification, if they are on.
 *
 * @param tag Of several tabs that show one with the same tag, one is seen.
 */
export function notify(title: string, body: string, tag: string, onClick: () => void): void {
  if (!areNotificationsOn()) return;
  const shown = new Notification(title, { body, tag, icon: "/icon.svg" });
  shown.onclick = () => {
    window.focus();
    onClick();
    shown.close();
  };
}

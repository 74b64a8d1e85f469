/** Whether this browser has shown the tour. */
import { ofBrowser } from "@/lib/browser/storage";

const KEY = "tril.tour";

export function hasSeenTour(): boolean {
  return ofBrowser.read(KEY) !== null;
}

export function noteTourSeen(): void {
  ofBrowser.write(KEY, "seen");
}

/** Whether this browser has shown the tour. */

const KEY = "tril.tour";

export function hasSeenTour(): boolean {
  try {
    return localStorage.getItem(KEY) !== null;
  } catch {
    return false;
  }
}

export function noteTourSeen(): void {
  try {
    localStorage.setItem(KEY, "seen");
  } catch {
    // Without storage the tour is shown again.
  }
}

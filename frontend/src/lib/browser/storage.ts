/**
 * What this browser keeps for the page. Access itself throws where a person or an administrator
 * denies storage; values then last until the page is closed.
 */
class BrowserStorage {
  /** Values that the browser did not keep. */
  private readonly unsaved = new Map<string, string>();
  private readonly open: () => Storage;

  constructor(open: () => Storage) {
    this.open = open;
  }

  read(key: string): string | null {
    const value = this.unsaved.get(key);
    if (value !== undefined) return value;
    try {
      return this.open().getItem(key);
    } catch {
      return null;
    }
  }

  write(key: string, value: string): void {
    try {
      this.open().setItem(key, value);
      this.unsaved.delete(key);
    } catch {
      this.unsaved.set(key, value);
    }
  }

  remove(key: string): void {
    this.unsaved.delete(key);
    try {
      this.open().removeItem(key);
    } catch {
      // Nothing is kept there.
    }
  }
}

/** Kept by this browser until it is removed. */
export const ofBrowser = new BrowserStorage(() => localStorage);
/** Kept by this tab, also when it is reloaded. */
export const ofTab = new BrowserStorage(() => sessionStorage);

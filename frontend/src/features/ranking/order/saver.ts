/**
 * Saves an order as it is changed: shown at once, sent one after the other, each on the revision
 * that it was made from. However slow saving is, each change becomes a revision of its own, so that
 * undo takes back one change at a time; only where saving fails, the last one alone is sent again.
 * Knows neither React nor HTTP.
 */
import { sameOrder, type Tiers } from "./order";

export interface Revision {
  readonly revision: number;
  readonly tiers: Tiers;
  readonly unranked: readonly number[];
  readonly can_undo: boolean;
  readonly can_redo: boolean;
}

export interface SaverState {
  readonly saved: Revision;
  /** What is shown: what was last done, saved or not. */
  readonly tiers: Tiers;
  readonly saving: boolean;
  /** Why the last save failed; what was done is still shown and can be sent again. */
  readonly error: unknown;
  /** What somebody else saved meanwhile. */
  readonly conflict: Revision | null;
}

export interface SaverDoors {
  save(baseRevision: number, tiers: Tiers): Promise<Revision>;
  step(baseRevision: number, step: "undo" | "redo"): Promise<Revision>;
  /** What stands instead, if the error says that somebody else saved first. */
  conflictOf(error: unknown): Revision | null;
}

export class RankingSaver {
  private state: SaverState;
  private readonly doors: SaverDoors;
  private readonly listeners = new Set<() => void>();
  /** The orders that are not saved yet, the newest last. */
  private wanted: Tiers[] = [];
  private work: Promise<void> | null = null;

  constructor(saved: Revision, doors: SaverDoors) {
    this.doors = doors;
    this.state = { saved, tiers: saved.tiers, saving: false, error: null, conflict: null };
  }

  readonly subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  readonly snapshot = (): SaverState => this.state;

  /** Shows an order and saves it. Until a conflict is settled, nothing is changed. */
  change(tiers: Tiers): void {
    if (this.state.conflict || sameOrder(tiers, this.state.tiers)) return;
    // What was refused may never be taken: what is done about it takes its place.
    if (this.state.error !== null) this.wanted = [tiers];
    else this.wanted.push(tiers);
    this.update({ tiers, error: null });
    this.run();
  }

  /** Sends again what could not be saved. */
  retry(): void {
    this.update({ error: null });
    this.run();
  }

  /** Takes the last change back or makes it again, after all that is still to be saved. */
  async step(step: "undo" | "redo"): Promise<void> {
    while (this.work) await this.work;
    if (this.state.conflict || this.wanted.length > 0) return;
    this.work = this.saveStep(step).finally(() => {
      this.work = null;
      if (this.wanted.length > 0 && !this.state.conflict) this.run();
    });
    await this.work;
  }

  /** The server's ranking was read again: shown unless something is still to be saved. */
  receive(saved: Revision): void {
    if (this.wanted.length > 0 || this.work || this.state.conflict) return;
    if (saved.revision < this.state.saved.revision) return;
    this.update({ saved, tiers: saved.tiers });
  }

  /** Settles a conflict: the other order stays, or this one replaces it. */
  settle(whose: "theirs" | "mine"): void {
    const { conflict, tiers } = this.state;
    if (!conflict) return;
    if (whose === "theirs") {
      this.wanted = [];
      this.update({ saved: conflict, tiers: conflict.tiers, conflict: null });
    } else {
      this.wanted = [tiers];
      this.update({ saved: conflict, conflict: null });
      this.run();
    }
  }

  private run(): void {
    if (this.work) return;
    this.work = this.saveAll().finally(() => {
      this.work = null;
    });
  }

  private async saveAll(): Promise<void> {
    this.update({ saving: true });
    for (let sent = this.wanted[0]; sent; sent = this.wanted[0]) {
      try {
        const saved = await this.doors.save(this.state.saved.revision, sent);
        this.wanted.shift();
        this.update({ saved });
      } catch (error) {
        this.refused(error);
        break;
      }
    }
    this.update({ saving: false });
  }

  private async saveStep(step: "undo" | "redo"): Promise<void> {
    this.update({ saving: true, error: null });
    try {
      const saved = await this.doors.step(this.state.saved.revision, step);
      if (this.wanted.length > 0) this.update({ saved });
      else this.update({ saved, tiers: saved.tiers });
    } catch (error) {
      const conflict = this.doors.conflictOf(error);
      // There is nothing of one's own to lose: what stands is shown.
      if (conflict && this.wanted.length === 0)
        this.update({ saved: conflict, tiers: conflict.tiers });
      else this.refused(error);
    }
    this.update({ saving: false });
  }

  private refused(error: unknown): void {
    const conflict = this.doors.conflictOf(error);
    if (!conflict) {
      // What was refused may never be taken; what is shown has to be.
      this.wanted = this.wanted.slice(-1);
      this.update({ error });
    } else if (sameOrder(conflict.tiers, this.state.tiers)) {
      this.wanted = [];
      this.update({ saved: conflict });
    } else {
      this.update({ conflict });
    }
  }

  private update(change: Partial<SaverState>): void {
    this.state = { ...this.state, ...change };
    this.listeners.forEach((listener) => listener());
  }
}

/**
 * Saves an order as it changes: shown at once, saved in sequence, each change on the revision
 * before it. However slow saving is, each change becomes its own revision, so that undo reverts one
 * at a time; only if saving fails is the last one alone sent again. Independent of React and HTTP.
 */
import { sameOrder, type Tiers } from "./order";

export interface Revision {
  readonly revision: number;
  readonly tiers: Tiers;
  readonly can_undo: boolean;
  readonly can_redo: boolean;
}

export interface SaverState {
  readonly saved: Revision;
  /** The order shown, saved or not. */
  readonly tiers: Tiers;
  readonly saving: boolean;
  /** Why the last save failed; the order is still shown and can be saved again. */
  readonly error: unknown;
  /** What was saved elsewhere in the meantime. */
  readonly conflict: Revision | null;
  /** Whether an order saved elsewhere waits until a drag is over. */
  readonly waiting: boolean;
  /** How often the order shown gave way to one that was saved elsewhere. */
  readonly nReplaced: number;
}

/** The orders before and after an undo or redo. */
export interface Stepped {
  readonly from: Tiers;
  readonly to: Tiers;
}

export interface RankingBackend {
  save(baseRevision: number, tiers: Tiers): Promise<Revision>;
  step(baseRevision: number, step: "undo" | "redo"): Promise<Revision>;
  /** Returns the current revision if an error is a conflict, else null. */
  conflictOf(error: unknown): Revision | null;
}

export class RankingSaver {
  private state: SaverState;
  private readonly backend: RankingBackend;
  private readonly listeners = new Set<() => void>();
  /** Orders not saved yet, newest last. */
  private pending: Tiers[] = [];
  private work: Promise<unknown> | null = null;
  private holding = false;
  /** The newest revision received while the order shown is held. */
  private received: Revision | null = null;

  /** Begins with the revision that is saved, and an order based on it that is not, if any. */
  constructor(saved: Revision, backend: RankingBackend, unsaved?: Tiers) {
    this.backend = backend;
    if (unsaved) this.pending.push(unsaved);
    this.state = {
      saved,
      tiers: unsaved ?? saved.tiers,
      saving: false,
      error: null,
      conflict: null,
      waiting: false,
      nReplaced: 0,
    };
  }

  readonly subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  readonly snapshot = (): SaverState => this.state;

  /** Shows an order and saves it; ignored while a conflict is shown. */
  change(tiers: Tiers): void {
    if (sameOrder(tiers, this.state.tiers)) return;
    if (this.state.conflict) {
      // It arose during a drag, which is part of what the person decides about.
      if (this.holding) this.update({ tiers });
      return;
    }
    // A refused order may never be accepted, so the new one replaces it.
    if (this.state.error !== null) this.pending = [tiers];
    else this.pending.push(tiers);
    this.update({ tiers, error: null });
    this.run();
  }

  /** Whether the order shown would be lost with the page. */
  isUnsaved(): boolean {
    return this.pending.length > 0 || this.state.conflict !== null;
  }

  /** Saves what it began with. */
  begin(): void {
    if (this.pending.length > 0 && this.state.error === null && !this.state.conflict) this.run();
  }

  /** Gives the order shown up for the one that is saved. */
  giveUp(): void {
    this.pending = [];
    this.update({ tiers: this.state.saved.tiers, error: null });
  }

  /** Saves again after an error. */
  retry(): void {
    this.update({ error: null });
    this.run();
  }

  /**
   * Undoes or redoes the last change, after saving what is pending. Returns what that changed; null
   * if nothing was undone or redone.
   */
  async step(step: "undo" | "redo"): Promise<Stepped | null> {
    while (this.work) await this.work;
    const { conflict, saved } = this.state;
    if (conflict || this.pending.length > 0) return null;
    if (!(step === "undo" ? saved.can_undo : saved.can_redo)) return null;
    const work = this.saveStep(step).finally(() => {
      this.work = null;
      if (this.pending.length > 0 && !this.state.conflict) this.run();
    });
    this.work = work;
    return work;
  }

  /** Takes over the server's ranking, unless a save is pending. */
  receive(saved: Revision): void {
    if (this.pending.length > 0 || this.work || this.state.conflict) return;
    if (saved.revision < (this.received ?? this.state.saved).revision) return;
    this.replace(saved, "elsewhere");
  }

  /**
   * Keeps the order shown as it is, for a drag: what it leads to is based on the revision that the
   * person saw when it began.
   */
  hold(): void {
    this.holding = true;
  }

  /** Shows what was saved elsewhere during a drag, unless the drag changed something. */
  release(): void {
    const { received } = this;
    this.holding = false;
    this.received = null;
    if (!received) return;
    this.update({ waiting: false });
    // Otherwise saving the change finds out.
    if (this.pending.length === 0 && !this.state.conflict) this.replace(received, "elsewhere");
  }

  /** Resolves a conflict: keeps the other order, or replaces it by this one. */
  settle(whose: "theirs" | "mine"): void {
    const { conflict, tiers } = this.state;
    if (!conflict) return;
    if (whose === "theirs") {
      this.pending = [];
      this.update({ saved: conflict, tiers: conflict.tiers, conflict: null });
    } else {
      this.pending = [tiers];
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
    for (let sent = this.pending[0]; sent; sent = this.pending[0]) {
      try {
        const saved = await this.backend.save(this.state.saved.revision, sent);
        this.pending.shift();
        this.update({ saved });
      } catch (error) {
        this.refused(error);
        break;
      }
    }
    this.update({ saving: false });
  }

  private async saveStep(step: "undo" | "redo"): Promise<Stepped | null> {
    const from = this.state.saved.tiers;
    let stepped: Stepped | null = null;
    this.update({ saving: true, error: null });
    try {
      const saved = await this.backend.step(this.state.saved.revision, step);
      if (this.pending.length > 0) this.update({ saved });
      else this.replace(saved, "here");
      stepped = { from, to: saved.tiers };
    } catch (error) {
      const conflict = this.backend.conflictOf(error);
      // No local change is lost, so show the current revision.
      if (conflict && this.pending.length === 0) this.replace(conflict, "elsewhere");
      else this.refused(error);
    }
    this.update({ saving: false });
    return stepped;
  }

  private refused(error: unknown): void {
    const conflict = this.backend.conflictOf(error);
    if (!conflict) {
      // Refused orders may never be accepted; keep only the one shown.
      this.pending = this.pending.slice(-1);
      this.update({ error });
    } else if (sameOrder(conflict.tiers, this.state.tiers)) {
      this.pending = [];
      this.update({ saved: conflict });
    } else {
      this.update({ conflict });
    }
  }

  /** Shows a revision, or lets it wait for the end of a drag. */
  private replace(saved: Revision, changed: "here" | "elsewhere"): void {
    const differs = !sameOrder(saved.tiers, this.state.tiers);
    if (this.holding && (differs || this.received)) {
      this.received = saved;
      this.update({ waiting: differs });
      return;
    }
    const nReplaced = this.state.nReplaced + (differs && changed === "elsewhere" ? 1 : 0);
    this.update({ saved, tiers: saved.tiers, nReplaced });
  }

  private update(change: Partial<SaverState>): void {
    this.state = { ...this.state, ...change };
    this.listeners.forEach((listener) => listener());
  }
}

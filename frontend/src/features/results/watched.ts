import type { Recording } from "@/api/types";

/** A recording that is being watched in a dialog. */
export interface Watched {
  readonly recording: Recording;
  readonly title: string;
  /** The frame to begin at, paused; without it the recording plays from its start. */
  readonly frame?: number;
}

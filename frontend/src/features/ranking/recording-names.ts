/** Names recordings by their ids where only these are known, as in a ranking. */
import { createContext, useContext } from "react";

import { type Named, recordingName } from "@/lib/recordings";

/** The recordings that a page knows, by their ids. */
export const KnownRecordings = createContext<ReadonlyMap<number, Named>>(new Map());

/** Returns how to name a recording by its id. */
export function useRecordingName(): (id: number) => string {
  const known = useContext(KnownRecordings);
  return (id) => recordingName(known.get(id));
}

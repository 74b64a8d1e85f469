import { useQuery } from "@tanstack/react-query";

import { ghostQuery } from "@/api/behaviours";
import type { Behaviour } from "@/api/types";
import { SHOW_GHOST, SHOW_TARGETS } from "@/features/play/settings/settings";
import { useSetting } from "@/features/play/settings/stored";
import { viewOf } from "@/games/views";
import type { Marks } from "@/games/view";

/** The marks that are switched on, and whether there is a recording to show as a ghost. */
export function useMarks(behaviour: Behaviour): Marks & { readonly hasGhost: boolean } {
  const [showTargets] = useSetting(SHOW_TARGETS);
  const [showGhost] = useSetting(SHOW_GHOST);
  const isDrawn = viewOf(behaviour.game) !== null;
  const mayHaveGhost = isDrawn && (behaviour.n_ranked > 0 || behaviour.n_perfect > 0);
  const { data: ghost } = useQuery({
    ...ghostQuery(behaviour.id),
    enabled: showGhost && mayHaveGhost,
  });
  return {
    target: showTargets && isDrawn ? behaviour.target : null,
    ghost: showGhost && mayHaveGhost ? (ghost ?? null) : null,
    hasGhost: mayHaveGhost && ghost !== null,
  };
}

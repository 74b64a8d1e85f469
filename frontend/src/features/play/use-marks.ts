import { useQuery } from "@tanstack/react-query";

import { SHOW_GHOST, SHOW_TARGETS } from "./choices";
import type { Marks } from "./marks";

import { ghostQuery } from "@/api/behaviours";
import type { Behaviour } from "@/api/types";
import { useChoice } from "@/lib/stored";

/** What is wanted over the game, and whether there is a recording whose ghost could be shown. */
export function useMarks(behaviour: Behaviour): Marks & { readonly hasGhost: boolean } {
  const [wantsTargets] = useChoice(SHOW_TARGETS);
  const [wantsGhost] = useChoice(SHOW_GHOST);
  const mayHaveGhost = behaviour.n_ranked > 0 || behaviour.n_perfect > 0;
  const { data: ghost } = useQuery({
    ...ghostQuery(behaviour.id),
    enabled: wantsGhost && mayHaveGhost,
  });
  return {
    target: wantsTargets ? behaviour.target : null,
    ghost: wantsGhost && mayHaveGhost ? (ghost ?? null) : null,
    hasGhost: mayHaveGhost && ghost !== null,
  };
}

import { useQuery } from "@tanstack/react-query";

import { ghostQuery } from "@/api/behaviours";
import type { Behaviour } from "@/api/types";
import { SHOW_GHOST, SHOW_TARGETS } from "@/features/play/settings/settings";
import { useSetting } from "@/features/play/settings/stored";

import type { Marks } from "./marks";

/** What is wanted over the game, and whether there is a recording whose ghost could be shown. */
export function useMarks(behaviour: Behaviour): Marks & { readonly hasGhost: boolean } {
  const [wantsTargets] = useSetting(SHOW_TARGETS);
  const [wantsGhost] = useSetting(SHOW_GHOST);
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

import { useQuery } from "@tanstack/react-query";

import { playerQuery } from "@/api/system";

/**
 * Returns whether the viewer may only play, or undefined while that is unknown. What players may not
 * ask for is asked for once this is false.
 */
export function useOnlyPlays(): boolean | undefined {
  const { data: player } = useQuery(playerQuery);
  return player === undefined ? undefined : player.role === "participant";
}

import { plural, t } from "@lingui/core/macro";

import type { GameWords } from "@/games/view";

export const words: GameWords = {
  ends: () => ({
    hit: t`hit by a bomb`,
    lives: t`hit by a bomb`,
    landed: t`the aliens landed`,
    cleared: t`all aliens gone`,
  }),
  rules: () => ({
    hit: t`when the cannon is hit`,
    life_counter: t`when the count of lives drops`,
  }),
  titles: () => ({
    cannon: t`cannon`,
    missile: t`missile`,
    "missiles fired": t`missiles fired`,
  }),
  takenTitle: () => t`Aliens hit`,
  noneTaken: () => t`No alien was hit.`,
  at: (cell) => t`Alien in ${cell}`,
  chosen: (count) => plural(count, { one: "# alien chosen", other: "# aliens chosen" }),
  targets: () => t`Target aliens`,
  choosesTargets: () => t`Target certain aliens`,
  noTarget: () => t`Pick at least one alien, or turn the target off.`,
};

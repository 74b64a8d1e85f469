import type { GameView } from "@/games/view";

import { alienGeometry } from "./formation";
import { AlienMarks } from "./marks";
import { spritePath } from "./sprites";
import { WantedAliens } from "./WantedAliens";
import { words } from "./words";

export const spaceInvaders: GameView = {
  words,
  itemPath: spritePath,
  Wanted: WantedAliens,
  marksPainter: (canvas, marks, colours, overlay) => {
    const aliens = alienGeometry(overlay);
    return aliens && new AlienMarks(canvas, marks, colours, aliens);
  },
};

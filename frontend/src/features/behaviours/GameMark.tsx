import { useQuery } from "@tanstack/react-query";

import { ItemGrid } from "@/components/game/ItemGrid";
import { gameQuery } from "@/games/catalogue";
import type { Behaviour } from "@/api/types";
import { GameProvider, useGame } from "@/games/game";

import styles from "./GameMark.module.css";

/** Width of a picture that stands for a game, in CSS pixels. */
const PICTURE_PX = 58;

/** What stands for a behaviour: its targets, or else a picture of its game. Decorative. */
export function GameMark({ target }: Pick<Behaviour, "target">) {
  const game = useGame();
  if (game.items && target) return <ItemGrid target={target} label="" />;
  return <Picture />;
}

/** A picture of the game. Decorative. */
function Picture() {
  const game = useGame();
  return (
    <img
      className={styles.picture}
      src={game.picture_url}
      alt=""
      loading="lazy"
      width={PICTURE_PX}
      height={PICTURE_PX}
    />
  );
}

/** The same where the page is of no game; beside other games its picture goes with the targets. */
export function BehaviourMark({
  behaviour,
  besideOthers,
}: {
  behaviour: Behaviour;
  besideOthers: boolean;
}) {
  const { data: game } = useQuery(gameQuery(behaviour.game));
  if (!game) return <span className={styles.picture} style={{ width: PICTURE_PX }} />;
  return (
    <GameProvider game={game} settings={behaviour.settings}>
      <span className={styles.both}>
        {besideOthers && game.items && behaviour.target && <Picture />}
        <GameMark target={behaviour.target} />
      </span>
    </GameProvider>
  );
}

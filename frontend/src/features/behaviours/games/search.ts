/** Finds games by what is typed. */
import type { Title } from "@/api/types";

/** Returns the games whose titles have each typed word, or whose name does. */
export function foundGames(games: readonly Title[], typed: string): readonly Title[] {
  const words = plain(typed).split(/\s+/).filter(Boolean);
  return games.filter(({ title, name }) => {
    const text = `${plain(title)} ${plain(name)}`;
    return words.every((word) => text.includes(word));
  });
}

/** Leaves case, accents and marks between words out of account. */
function plain(text: string): string {
  return text
    .normalize("NFKD")
    .replaceAll(/[\u0300-\u036f.'’]/g, "")
    .replaceAll(/[-_]/g, " ")
    .toLowerCase();
}

/** Returns the index of the card that a key leads to in a grid; null if the key does not move. */
export function cardAt(index: number, key: string, columns: number, count: number): number | null {
  const steps: Readonly<Record<string, number>> = {
    ArrowLeft: -1,
    ArrowRight: 1,
    ArrowUp: -columns,
    ArrowDown: columns,
    Home: -index,
    End: count - 1 - index,
  };
  const step = steps[key];
  if (step === undefined) return null;
  const to = index + step;
  return to >= 0 && to < count ? to : index;
}

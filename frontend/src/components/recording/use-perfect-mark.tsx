import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { type ReactNode, useCallback, useState } from "react";

import type { Behaviour } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";

import { useGame } from "@/games/game";
import { imperfections } from "@/games/outcomes";
import styles from "./KeepOrDiscard.module.css";

type Played = Parameters<typeof imperfections>[0];

interface PerfectMark {
  /** Marks games as perfect; asks first if one of them is not. */
  mark: (games: readonly Played[], confirmed: () => void) => void;
  /** The question, while it is asked. */
  question: ReactNode;
}

/** Asks before games are marked as perfect that missed targets, hit strays or ended by death. */
export function usePerfectMark(behaviour: Behaviour): PerfectMark {
  const game = useGame();
  const [asked, setAsked] = useState<{ sentence: string; confirmed: () => void } | null>(null);

  const mark = useCallback(
    (games: readonly Played[], confirmed: () => void) => {
      const found = games
        .map((one) => imperfections(one, behaviour, game))
        .filter((one) => one.length > 0);
      if (found.length === 0) confirmed();
      else setAsked({ sentence: sentenceOf(found, games.length), confirmed });
    },
    [behaviour, game],
  );

  const question = asked && (
    <Dialog title={t`Mark as perfect?`} width="26rem" onClose={() => setAsked(null)}>
      <div className={styles.prompt}>
        <p>
          <Trans>{asked.sentence} The clone copies what is marked as perfect.</Trans>
        </p>
        <div className={styles.buttons}>
          <Button kind="primary" data-first onClick={() => setAsked(null)}>
            <Trans>Don&rsquo;t mark</Trans>
          </Button>
          <Button
            onClick={() => {
              setAsked(null);
              asked.confirmed();
            }}
          >
            <Trans>Mark all the same</Trans>
          </Button>
        </div>
      </div>
    </Dialog>
  );
  return { mark, question };
}

function sentenceOf(found: readonly (readonly string[])[], n: number): string {
  const [first = []] = found;
  if (n === 1) return t`This game isn’t perfect: ${first.join(", ")}.`;
  return plural(found.length, {
    one: `# of ${n} games isn’t perfect: it missed targets, hit strays or was lost.`,
    other: `# of ${n} games aren’t perfect: they missed targets, hit strays or were lost.`,
  });
}

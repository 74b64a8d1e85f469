import { t } from "@lingui/core/macro";

import type { Behaviour, Recording } from "@/api/types";
import { Icon } from "@/components/controls/Icon";
import { useGame } from "@/games/game";
import { measuredText, measureSentence } from "@/games/measures";

import styles from "./MeasureChecklist.module.css";

/** What a behaviour measures, with the values of a game and whether they are met. */
export function MeasureChecklist({
  recording,
  behaviour,
}: {
  recording: Pick<Recording, "measured">;
  behaviour: Behaviour;
}) {
  const game = useGame();
  if (behaviour.measures.length === 0) return null;
  return (
    <ul className={styles.list} aria-label={t`Measures`}>
      {behaviour.measures.map((measure, index) => {
        const value = recording.measured[index];
        return (
          <li key={index} data-met={value?.met ?? undefined}>
            <Mark met={value?.met ?? null} />
            <span>{measureSentence(measure, game)}</span>
            <span className={styles.value}>{value ? measuredText(value, measure) : ""}</span>
          </li>
        );
      })}
    </ul>
  );
}

function Mark({ met }: { met: boolean | null }) {
  if (met === null) return <span className={styles.mark} />;
  return (
    <span className={styles.mark} role="img" aria-label={met ? t`met` : t`not met`}>
      <Icon name={met ? "check" : "close"} />
    </span>
  );
}

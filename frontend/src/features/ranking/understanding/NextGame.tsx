import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";

import { messageOf } from "@/api/client";
import { Button } from "@/components/controls/Button";
import type { Tiers } from "@/features/ranking/order/order";
import { percent, percentDone } from "@/lib/format";
import { useRecordingName } from "@/features/ranking/recording-names";

import { Progress } from "./Progress";
import styles from "./UnderstandingPanel.module.css";
import { nextGameQuery } from "./use-understanding";

interface NextGameProps {
  behaviourId: number;
  tiers: Tiers;
  /** Places a game; null while games cannot be compared. */
  onRank: ((id: number) => void) | null;
}

/** Names the unranked game whose place says most of which statement is meant. */
export function NextGame({ behaviourId, tiers, onRank }: NextGameProps) {
  const nameOf = useRecordingName();
  const { data, error } = useQuery(nextGameQuery(behaviourId, tiers));
  if (error !== null && !data) return <p>{t`It could not be worked out: ${messageOf(error)}`}</p>;
  if (!data) return <p>{t`Working it out…`}</p>;
  if (data.state === "watching")
    return (
      <Progress share={data.progress}>
        {t`Tril watches your unranked games: ${percentDone(data.progress)}.`}
      </Progress>
    );
  const { next_game: next, statements } = data;
  const [first, other] = [statements[0]?.sentence, next && statements[next.other]?.sentence];
  if (!next || first === undefined || other === undefined)
    return (
      <p>
        <Trans>
          No unranked game tells these statements apart. Play one that does, or add varied games.
        </Trans>
      </p>
    );
  const name = nameOf(next.recording_id);
  const [byFirst, byOther] = [percent(next.better_than, 0), percent(next.better_than_by_other, 0)];
  return (
    <div className={styles.next}>
      <p>
        <Trans>
          Ranking {name} would help most. If you mean “{first}”, it is better than {byFirst} of your
          ranked games; if you mean “{other}”, it is better than {byOther}.
        </Trans>
      </p>
      {onRank && (
        <Button icon="compare" onClick={() => onRank(next.recording_id)}>
          <Trans>Rank this one next</Trans>
        </Button>
      )}
    </div>
  );
}

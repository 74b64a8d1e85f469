import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useEffect, useRef } from "react";

import { useShown } from "@/api/library";
import type { Behaviour, GameOpinion, LibraryEntry } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { Loading } from "@/components/feedback/States";
import { focusTray } from "@/features/ranking/board/Board";
import type { RankingSaver, SaverState } from "@/features/ranking/order/saver";
import { SaveError } from "@/features/ranking/SaveBar";

import styles from "./CompareDialog.module.css";
import { Comparison } from "./Comparison";
import type { Question } from "./session";
import { type Comparing, useComparing } from "./use-comparing";

interface CompareDialogProps {
  /** The unranked recordings to place. */
  ids: readonly number[];
  behaviour: Behaviour;
  recordings: ReadonlyMap<number, LibraryEntry>;
  opinions: ReadonlyMap<number, GameOpinion>;
  state: SaverState;
  saver: RankingSaver;
  onClose: () => void;
}

/** Places unranked recordings: each is shown beside ranked ones until its place is found. */
export function CompareDialog(props: CompareDialogProps) {
  const { ids, behaviour, recordings, opinions, state, saver, onClose } = props;
  const { tiers } = state;
  const comparing = useComparing(
    ids,
    { tiers, recordings, opinions },
    saver,
    `comparing ${behaviour.id}`,
  );
  const { question } = comparing;
  const upcoming = question ? upcomingOf(comparing, question) : [];
  const shown = useShown(
    behaviour.id,
    question ? [question.id, question.opponent, ...upcoming] : [],
  );
  const game = question && shown.get(question.id);
  const opponent = question && shown.get(question.opponent);
  // The button that opened it goes with the last unranked recording.
  useEffect(
    () => () => {
      if (document.activeElement === document.body) focusTray();
    },
    [],
  );
  return (
    <Dialog
      title={question ? t`Which is better?` : t`Place by comparing`}
      width={question ? "160rem" : undefined}
      onClose={onClose}
    >
      <div className={styles.body}>
        {state.error !== null && <SaveError error={state.error} saver={saver} />}
        {question && game && opponent ? (
          <Comparison
            comparing={comparing}
            question={question}
            game={game}
            opponent={opponent}
            upcoming={upcoming.flatMap((id) => shown.get(id) ?? [])}
            behaviour={behaviour}
            nTiers={tiers.length}
            nGames={ids.length}
          />
        ) : question ? (
          <Loading what={t`the recordings`} rows={1} height="20rem" />
        ) : (
          <Ended comparing={comparing} onClose={onClose} />
        )}
        <p role="status" className="visually-hidden">
          {comparing.spoken}
        </p>
      </div>
    </Dialog>
  );
}

/** Returns the recordings that the next questions may add to those of this one. */
function upcomingOf({ upcoming }: Comparing, shown: Question): readonly number[] {
  const ids = new Set(upcoming.flatMap(({ id, opponent }) => [id, opponent]));
  return [...ids].filter((id) => id !== shown.id && id !== shown.opponent);
}

/** What came of it, once nothing is left to ask. */
function Ended({ comparing, onClose }: { comparing: Comparing; onClose: () => void }) {
  const { nLeft, nPlaced, nSkipped, canUndo, undo } = comparing;
  const back = useRef<HTMLButtonElement>(null);
  // The buttons that had the focus are gone.
  useEffect(() => back.current?.focus(), []);
  return (
    <div className={styles.ended}>
      <p>{summary({ nLeft, nPlaced, nSkipped })}</p>
      <div className={styles.buttons}>
        <Button kind="primary" ref={back} onClick={onClose}>
          <Trans>Back to the ranking</Trans>
        </Button>
        {canUndo && (
          <Button icon="undo" onClick={undo}>
            <Trans>Undo the last answer</Trans>
          </Button>
        )}
      </div>
    </div>
  );
}

function summary({ nLeft, nPlaced, nSkipped }: Pick<Comparing, "nLeft" | "nPlaced" | "nSkipped">) {
  if (nLeft > 0) return t`No ranked recording is left to compare with.`;
  const sentences = [
    nPlaced > 0 &&
      plural(nPlaced, {
        one: "# recording has its place.",
        other: "# recordings have their place.",
      }),
    nSkipped > 0 &&
      plural(nSkipped, {
        one: "# was skipped and stays unranked.",
        other: "# were skipped and stay unranked.",
      }),
  ];
  return sentences.filter(Boolean).join(" ") || t`No recording is left to place.`;
}

/** Whether recordings can be placed by comparing them: there is something to compare with. */
export function canCompare({ tiers }: Pick<SaverState, "tiers">, unranked: readonly number[]) {
  return tiers.length >= 2 && unranked.length > 0;
}

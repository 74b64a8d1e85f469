import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useId, useRef, useState } from "react";

import { messageOf } from "@/api/client";
import type { Understanding } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { StatementList } from "@/components/statements/StatementList";
import { isAbout, shownOf } from "@/components/statements/statements";
import { useAnswering } from "@/components/statements/use-answering";
import type { Tiers } from "@/features/ranking/order/order";
import { useGame } from "@/games/game";
import { percentDone } from "@/lib/format";
import { useRecordingName } from "@/features/ranking/recording-names";

import { NextGame } from "./NextGame";
import { PointDialog } from "./PointDialog";
import { Progress } from "./Progress";
import styles from "./UnderstandingPanel.module.css";
import { useUnderstanding } from "./use-understanding";

interface UnderstandingPanelProps {
  behaviourId: number;
  tiers: Tiers;
  /** The best efforts, which the order is understood from, too; null while they are not known. */
  perfect: readonly number[] | null;
  /** Places an unranked game; null while games cannot be compared. */
  onRank?: ((id: number) => void) | null;
}

/** What Tril understood of the order, as statements that a person can agree with or reject. */
export function UnderstandingPanel(props: UnderstandingPanelProps) {
  const { behaviourId, tiers, perfect, onRank = null } = props;
  const titleId = useId();
  const title = useRef<HTMLHeadingElement>(null);
  const { told, error } = useUnderstanding(behaviourId, tiers, perfect);
  const answering = useAnswering(behaviourId);
  const statements = told ? shownOf(told.statements) : [];
  // As many places as were needed so far, so that the board below stays where it is.
  const [nPlaces, setNPlaces] = useState(0);
  if (statements.length > nPlaces) setNPlaces(statements.length);
  const apart = told?.answers.filter((one) => !statements.some((shown) => isAbout(one, shown)));
  const [pointing, setPointing] = useState(false);
  const [choosing, setChoosing] = useState(false);
  const focusTitle = () => title.current?.focus();

  return (
    <section className={styles.panel} aria-labelledby={titleId}>
      <h3 id={titleId} ref={title} tabIndex={-1}>
        <Trans>What Tril understood</Trans>
      </h3>
      <Situation told={told} error={error} />
      {nPlaces > 0 && told && (
        <StatementList
          behaviourId={behaviourId}
          statements={statements}
          answers={told.answers}
          answering={answering}
          nPlaces={nPlaces}
          onGone={focusTitle}
        />
      )}
      {told?.state === "ready" && (
        <div className={styles.none}>
          <p>
            <Trans>None of these, or not sure?</Trans>
          </p>
          <Button icon="eye" onClick={() => setPointing(true)}>
            <Trans>Point at it</Trans>
          </Button>
          {statements.length > 1 && !choosing && (
            <Button icon="help" onClick={() => setChoosing(true)}>
              <Trans>Which game should I rank next?</Trans>
            </Button>
          )}
        </div>
      )}
      {told?.state === "ready" && choosing && (
        <NextGame behaviourId={behaviourId} tiers={tiers} onRank={onRank} />
      )}
      {told && <Doubt told={told} />}
      {apart && apart.length > 0 && (
        <ul className={styles.answers} aria-label={t`Your answers`}>
          {apart.map((one) => (
            <li key={one.subjects.join()}>
              <span>
                {one.meant ? (
                  <Trans>You said that this is it: {one.sentence}</Trans>
                ) : (
                  <Trans>Not this: {one.sentence}</Trans>
                )}
              </span>
              <Button
                kind="quiet"
                icon="undo"
                aria-label={t`Take back: ${one.sentence}`}
                aria-disabled={answering.isAnswering}
                onClick={() => {
                  answering.say(one, null);
                  focusTitle();
                }}
              >
                <Trans>Take back</Trans>
              </Button>
            </li>
          ))}
        </ul>
      )}
      <p role="status" className="visually-hidden">
        {answering.spoken}
      </p>
      {pointing && (
        <PointDialog
          behaviourId={behaviourId}
          recordingIds={tiers.flat()}
          onMean={(meaning) => {
            answering.say(meaning, true);
            setPointing(false);
          }}
          onClose={() => setPointing(false)}
        />
      )}
    </section>
  );
}

/** Says how far Tril is with the order, or how to read what it understood. */
function Situation({ told, error }: { told: Understanding | undefined; error: unknown }) {
  const { title } = useGame();
  if (error !== null && !told) return <p>{t`It could not be worked out: ${messageOf(error)}`}</p>;
  if (!told) return <p>{t`Working it out…`}</p>;
  const done = percentDone(told.progress);
  switch (told.state) {
    case "learning":
      return (
        <Progress share={told.progress}>
          {t`Tril learns to see ${title}: ${done}. This takes a minute or two, once for each game. You can go on ranking.`}
        </Progress>
      );
    case "watching":
      return (
        <Progress share={told.progress}>{t`Tril watches your ranked games: ${done}.`}</Progress>
      );
    case "failed":
      return (
        <p>
          <Trans>
            Tril could not look at this game; the server&rsquo;s log says why. It tries again when
            the server starts. You can still rank and train.
          </Trans>
        </p>
      );
    case "waiting":
      return (
        <p>
          <Trans>
            Rank four games in at least two tiers, and Tril says here what it thinks the better ones
            have in common.
          </Trans>
        </p>
      );
    case "ready":
      if (told.statements.length === 0)
        return (
          <p>
            <Trans>
              Nothing is left that Tril could see in these games. Take one of your answers back.
            </Trans>
          </p>
        );
      if (told.answers.some(({ meant }) => meant))
        return (
          <p>
            <Trans>
              What you said counts for sure. The shares say how likely something else counts with
              it.
            </Trans>
          </p>
        );
      return (
        <p>
          <Trans>What the better games have, the most likely first. You need not answer.</Trans>
        </p>
      );
  }
}

/** Warns of an order that may be chance, and names the games that contradict it most. */
function Doubt({ told: { is_sense: isSense, contradiction } }: { told: Understanding }) {
  const nameOf = useRecordingName();
  if (isSense === null || (isSense && !contradiction)) return null;
  const better = contradiction && nameOf(contradiction.better);
  const worse = contradiction && nameOf(contradiction.worse);
  return (
    <div className={styles.doubt}>
      <Icon name="alert" />
      <div>
        {!isSense && (
          <p>
            <Trans>
              Shuffled orders of these games fit as well, so this may be chance. Rank a few more
              games that differ in what you mean, or train anyway.
            </Trans>
          </p>
        )}
        {contradiction && (
          <p>
            <Trans>
              These two contradict it most: {better} is ranked above {worse}, which has more of what
              the better games have.
            </Trans>
          </p>
        )}
      </div>
    </div>
  );
}

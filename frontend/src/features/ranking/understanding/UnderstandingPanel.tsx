import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useId, useRef, useState } from "react";

import { messageOf } from "@/api/client";
import type { StatementAnswer, Understanding, UnderstoodStatement } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { ShareBar } from "@/components/ShareBar";
import type { Tiers } from "@/features/ranking/order/order";
import { useGame } from "@/games/game";
import { percent, percentDone } from "@/lib/format";
import { recordingName } from "@/lib/recordings";

import styles from "./UnderstandingPanel.module.css";
import { useUnderstanding } from "./use-understanding";

/** Statements that are shown however improbable they are, and from which probability on others. */
const LEAST_SHOWN = 3;
const SHOWN_FROM = 0.02;

interface UnderstandingPanelProps {
  behaviourId: number;
  tiers: Tiers;
  /** The best efforts, which the order is understood from, too; null while they are not known. */
  perfect: readonly number[] | null;
}

/** What Tril understood of the order, as statements that a person can agree with or reject. */
export function UnderstandingPanel({ behaviourId, tiers, perfect }: UnderstandingPanelProps) {
  const titleId = useId();
  const title = useRef<HTMLHeadingElement>(null);
  const { told, error, answer, isAnswering } = useUnderstanding(behaviourId, tiers, perfect);
  const [spoken, setSpoken] = useState("");
  const statements = told ? shownOf(told.statements) : [];
  // As many places as were needed so far, so that the board below stays where it is.
  const [nPlaces, setNPlaces] = useState(0);
  if (statements.length > nPlaces) setNPlaces(statements.length);
  const apart = told?.answers.filter(
    (one) => !one.meant || !statements.some((shown) => isAbout(one, shown)),
  );

  /** Answers; the button of what goes takes the focus with it. */
  function say({ subjects, sentence }: Said, meant: boolean | null, goes = false) {
    if (isAnswering) return;
    answer({ subjects, sentence, meant });
    if (meant === null) setSpoken(t`Taken back: ${sentence}.`);
    else if (meant) setSpoken(t`Noted as what you mean: ${sentence}.`);
    else setSpoken(t`Noted as not what you mean: ${sentence}.`);
    if (goes) title.current?.focus();
  }

  return (
    <section className={styles.panel} aria-labelledby={titleId}>
      <h3 id={titleId} ref={title} tabIndex={-1}>
        <Trans>What Tril understood</Trans>
      </h3>
      <Situation told={told} error={error} />
      {nPlaces > 0 && told && (
        <ol className={styles.statements} data-places={nPlaces}>
          {statements.map((statement) => {
            const said = told.answers.find((one) => one.meant && isAbout(one, statement));
            return (
              <li key={statement.subjects.join()}>
                <Pictures urls={statement.pictures} />
                <span className={styles.sentence}>
                  {statement.sentence}
                  {said && (
                    <span className={styles.said}>
                      <Icon name="check" />
                      <Trans>You said that this is it.</Trans>
                    </span>
                  )}
                </span>
                <span className={styles.share}>
                  <ShareBar share={statement.probability} />
                  {percent(statement.probability, 0)}
                </span>
                <span className={styles.choice}>
                  {/* One button, so that it keeps the focus. */}
                  <Button
                    kind={said ? "quiet" : "secondary"}
                    aria-label={
                      said
                        ? t`Take back: ${statement.sentence}`
                        : t`This is it: ${statement.sentence}`
                    }
                    aria-disabled={isAnswering}
                    onClick={() => say(statement, said ? null : true)}
                  >
                    {said ? <Trans>Take back</Trans> : <Trans>This is it</Trans>}
                  </Button>
                  {!said && (
                    <Button
                      kind="quiet"
                      aria-label={t`Not this: ${statement.sentence}`}
                      aria-disabled={isAnswering}
                      onClick={() => say(statement, false, true)}
                    >
                      <Trans>Not this</Trans>
                    </Button>
                  )}
                </span>
              </li>
            );
          })}
        </ol>
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
                aria-disabled={isAnswering}
                onClick={() => say(one, null, true)}
              >
                <Trans>Take back</Trans>
              </Button>
            </li>
          ))}
        </ul>
      )}
      <p role="status" className="visually-hidden">
        {spoken}
      </p>
    </section>
  );
}

type Said = Pick<UnderstoodStatement, "subjects" | "sentence">;

function isAbout(answer: StatementAnswer, { subjects }: Said): boolean {
  return answer.subjects.join() === subjects.join();
}

function shownOf(statements: readonly UnderstoodStatement[]): readonly UnderstoodStatement[] {
  return statements.filter(
    ({ probability }, place) => place < LEAST_SHOWN || probability >= SHOWN_FROM,
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
            Tril could not learn to see this game; the server&rsquo;s log says why. It tries again
            when the server is started again. You can rank and train all the same.
          </Trans>
        </p>
      );
    case "waiting":
      return (
        <p>
          <Trans>
            Rank four games in at least two tiers, and Tril says here what it thinks that the better
            ones have.
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
      return (
        <p>
          <Trans>What the better games have, the most likely first. You need not answer.</Trans>
        </p>
      );
  }
}

function Progress({ share, children }: { share: number; children: string }) {
  const labelId = useId();
  return (
    <div className={styles.progress}>
      <p id={labelId}>{children}</p>
      <progress aria-labelledby={labelId} value={share} max={1} />
    </div>
  );
}

function Pictures({ urls }: { urls: readonly string[] }) {
  return (
    <span className={styles.pictures}>
      {urls.map((url) => (
        <img key={url} src={url} alt="" />
      ))}
    </span>
  );
}

/** Warns of an order that may be chance, and names the games that contradict it most. */
function Doubt({ told: { is_sense: isSense, contradiction } }: { told: Understanding }) {
  if (isSense === null || (isSense && !contradiction)) return null;
  const better = contradiction && recordingName({ id: contradiction.better });
  const worse = contradiction && recordingName({ id: contradiction.worse });
  return (
    <div className={styles.doubt}>
      <Icon name="alert" />
      <div>
        {!isSense && (
          <p>
            <Trans>
              Shuffled orders of these games are explained as well, so this may be chance. A few
              more games that differ in what you mean tell more. You can train all the same.
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

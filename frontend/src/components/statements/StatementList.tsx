import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useId, useState } from "react";

import type { StatementAnswer, UnderstoodStatement } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { ShareBar } from "@/components/ShareBar";
import { classes } from "@/lib/classes";
import { percent } from "@/lib/format";

import { Moments } from "./Moments";
import styles from "./StatementList.module.css";
import { isAbout, type Said } from "./statements";
import type { Answering } from "./use-answering";

interface StatementListProps {
  behaviourId: number;
  /** The most probable first. */
  statements: readonly UnderstoodStatement[];
  answers: readonly StatementAnswer[];
  /** Null where nothing can be answered. */
  answering: Answering | null;
  /** Room that is kept, in statements. */
  nPlaces?: number;
  /** Called when a control goes that may have the focus. */
  onGone?: () => void;
}

/** Statements with how probable they are, moments that show them, and what a person says of them. */
export function StatementList(props: StatementListProps) {
  const { behaviourId, statements, answers, answering, nPlaces = 0, onGone } = props;
  return (
    <div className={styles.list}>
      <ol className={styles.statements} data-places={nPlaces}>
        {statements.map((statement) => (
          <Row
            key={statement.subjects.join() || statement.sentence}
            behaviourId={behaviourId}
            statement={statement}
            said={answers.find((one) => isAbout(one, statement))}
            answering={answering}
            onGone={onGone}
          />
        ))}
      </ol>
    </div>
  );
}

interface RowProps {
  behaviourId: number;
  statement: UnderstoodStatement;
  said: StatementAnswer | undefined;
  answering: Answering | null;
  onGone: (() => void) | undefined;
}

function Row({ behaviourId, statement, said, answering, onGone }: RowProps) {
  const { sentence, detail, probability, shown, contrast, pictures } = statement;
  const [open, setOpen] = useState(false);
  const momentsId = useId();
  const hasMoments = shown !== null && contrast !== null;
  // Of what has no picture, or none yet, the sentence begins where the picture would.
  const isPlain = !hasMoments && pictures.length === 0;
  return (
    <li className={classes(answering !== null && styles.answerable, isPlain && styles.plain)}>
      {hasMoments ? (
        <button
          type="button"
          className={styles.tile}
          aria-label={open ? t`Hide: ${sentence}` : t`Show: ${sentence}`}
          aria-expanded={open}
          aria-controls={momentsId}
          onClick={() => setOpen(!open)}
        >
          <Pictures urls={pictures} />
          <span className={styles.badge}>
            <Icon name={open ? "close" : "play"} />
          </span>
        </button>
      ) : (
        !isPlain && (
          <span className={styles.tile}>
            <Pictures urls={pictures} />
          </span>
        )
      )}
      <span className={styles.sentence}>
        {sentence}
        {detail && <span className={styles.detail}>{detail}</span>}
        {said && <SaidOf answer={said} />}
      </span>
      <span className={styles.share}>
        {said ? (
          <span className={styles.certain}>{said.meant ? t`Counts for sure` : t`Left out`}</span>
        ) : (
          <>
            <ShareBar share={probability} />
            {percent(probability, 0)}
          </>
        )}
      </span>
      {answering && (
        <span className={styles.choice}>
          <Choice statement={statement} said={said} answering={answering} onGone={onGone} />
        </span>
      )}
      <div id={momentsId} className={styles.moments} hidden={!open}>
        {open && shown && contrast && (
          <Moments behaviourId={behaviourId} shown={shown} contrast={contrast} />
        )}
      </div>
    </li>
  );
}

function SaidOf({ answer }: { answer: StatementAnswer }) {
  return (
    <span className={answer.meant ? styles.meant : styles.rejected}>
      <Icon name={answer.meant ? "check" : "close"} />
      {answer.meant ? <Trans>You said: this is it.</Trans> : <Trans>You said: not this.</Trans>}
    </span>
  );
}

function Choice({
  statement,
  said,
  answering: { say, isAnswering },
  onGone,
}: {
  statement: Said;
  said: StatementAnswer | undefined;
  answering: Answering;
  onGone: (() => void) | undefined;
}) {
  const { sentence } = statement;
  return (
    <>
      {/* One button, so that it keeps the focus. */}
      <Button
        kind={said ? "quiet" : "secondary"}
        aria-label={said ? t`Take back: ${sentence}` : t`This is it: ${sentence}`}
        aria-disabled={isAnswering}
        onClick={() => say(statement, said ? null : true)}
      >
        {said ? <Trans>Take back</Trans> : <Trans>This is it</Trans>}
      </Button>
      {!said && (
        <Button
          kind="quiet"
          aria-label={t`Not this: ${sentence}`}
          aria-disabled={isAnswering}
          onClick={() => {
            say(statement, false);
            onGone?.();
          }}
        >
          <Trans>Not this</Trans>
        </Button>
      )}
    </>
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

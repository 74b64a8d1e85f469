import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { Link, useNavigate, useSearchParams } from "react-router";

import { courseQuery, framesQuery } from "@/api/recordings";
import type { Behaviour, Recording, RecordingCourse, TaughtGame } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { Failed, Loading, Notice } from "@/components/feedback/States";
import { PageTitle } from "@/components/PageTitle";
import { KeepOrDiscard } from "@/components/recording/KeepOrDiscard";
import { RecordingPlayer } from "@/components/recording/RecordingPlayer";
import { SourceBadge } from "@/components/recording/SourceBadge";
import { RunName } from "@/components/RunName";
import { usePerfectMark } from "@/components/recording/use-perfect-mark";
import { useRecordingActions } from "@/components/recording/use-recording-actions";
import { ValueTable } from "@/components/ValueTable";
import { ActionLanes } from "@/features/recordings/detail/ActionLanes";
import { Downloads } from "@/features/recordings/detail/Downloads";
import { MemoryView } from "@/features/recordings/detail/MemoryView";
import { useRewardRun } from "@/features/recordings/detail/use-reward-run";
import { useGame } from "@/games/game";
import { describeCourse, describeResult } from "@/games/outcomes";
import { wordsOf } from "@/games/words";
import { inSentence, moment, seconds } from "@/lib/format";
import { cellName } from "@/lib/game/items";
import type { Playback } from "@/lib/game/playback";
import { valueRows } from "@/lib/recipe-values";
import { numberedName, recordingName } from "@/lib/recordings";
import { actorNames } from "@/lib/actors";

import { VerifiedBadge } from "./badges";
import { ColumnBars } from "./ColumnBars";
import { MeasureChecklist } from "./MeasureChecklist";
import { NotesDialog } from "./NotesDialog";
import styles from "./RecordingPage.module.css";

/** The window's height without the rest of the page. */
const screenHeight = (windowHeight: number) => Math.max(windowHeight - 370, 210);

/** A recording frame by frame: its actions, hits, memory and origin. */
export function RecordingPage({
  recording,
  behaviour,
}: {
  recording: Recording;
  behaviour: Behaviour;
}) {
  const game = useGame();
  const frames = useQuery(framesQuery(recording));
  const course = useQuery(courseQuery(recording.id));
  const [search] = useSearchParams();
  const { restore } = useRecordingActions(behaviour.id);
  const { runId, control } = useRewardRun(behaviour);
  const name = recordingName(recording);
  return (
    <>
      <PageTitle>{t`${name} · ${behaviour.name} · Tril`}</PageTitle>
      <div className={styles.head}>
        <h2>{name}</h2>
        <Actions recording={recording} behaviour={behaviour} />
      </div>
      {recording.deleted && (
        <Notice tone="calm">
          <p>
            <Trans>This recording was deleted. Runs that used it keep it.</Trans>
          </p>
          <Button icon="undo" onClick={() => restore(recording)}>
            <Trans>Restore</Trans>
          </Button>
        </Notice>
      )}
      <div className={styles.page}>
        {frames.data ? (
          <RecordingPlayer
            frames={frames.data}
            hits={behaviour.target ? recording.hits : undefined}
            reward={
              runId === null ? undefined : { runId, recordingId: recording.id, menu: control }
            }
            startFrame={frameOf(search, game)}
            screenHeight={screenHeight}
          >
            {(playback) => (
              <>
                {runId === null && control}
                {course.data && <ActionLanes playback={playback} actions={course.data.actions} />}
                {behaviour.target && <Hits playback={playback} recording={recording} />}
                {course.data && game.has_memory && (
                  <MemoryView playback={playback} course={course.data} />
                )}
              </>
            )}
          </RecordingPlayer>
        ) : frames.error ? (
          <Failed
            what={t`The recording`}
            error={frames.error}
            onRetry={() => void frames.refetch()}
          />
        ) : (
          // What is beside it stays below it on a phone.
          <Loading what={t`the recording`} rows={1} height="100dvh" />
        )}
        <aside className={styles.side} aria-label={t`About this recording`}>
          <Facts recording={recording} behaviour={behaviour} />
          {course.error && (
            <Failed
              what={t`Its actions`}
              error={course.error}
              onRetry={() => void course.refetch()}
            />
          )}
          {course.data && <Relatives course={course.data} />}
          <section>
            <h3>
              <Trans>Download</Trans>
            </h3>
            <Downloads recording={recording} />
          </section>
          {course.data && <Conditions course={course.data} />}
        </aside>
      </div>
    </>
  );
}

/** Returns the frame that an address names by frame or step, so that a moment can be linked to. */
function frameOf(search: URLSearchParams, game: TaughtGame): number {
  const step = search.get("step");
  const frame =
    step === null ? Number(search.get("frame") ?? 0) : Number(step) * game.frames_per_step;
  return Number.isInteger(frame) && frame > 0 ? frame : 0;
}

function Actions({ recording, behaviour }: { recording: Recording; behaviour: Behaviour }) {
  const { mark, question } = usePerfectMark(behaviour);
  const actions = useRecordingActions(recording.behaviour_id);
  const navigate = useNavigate();
  const [writing, setWriting] = useState(false);
  return (
    <div className={styles.buttons}>
      {recording.run_id === null && (
        <Button
          aria-pressed={recording.perfect}
          disabled={recording.deleted}
          onClick={() => {
            if (recording.perfect) actions.setPerfect(recording, false);
            else mark([recording], () => actions.setPerfect(recording, true));
          }}
        >
          <Icon name="star" filled={recording.perfect} />
          {recording.perfect ? t`Perfect` : t`Mark as perfect`}
        </Button>
      )}
      {question}
      <Button icon="note" onClick={() => setWriting(true)}>
        {recording.notes ? t`Change the note` : t`Write a note`}
      </Button>
      {recording.run_id === null && !recording.deleted && (
        <Button
          icon="trash"
          onClick={() => {
            actions.remove(recording);
            void navigate(`/behaviours/${recording.behaviour_id}/recordings`);
          }}
        >
          <Trans>Delete</Trans>
        </Button>
      )}
      {writing && (
        <NotesDialog
          recording={recording}
          onSave={(notes) => actions.setNotes(recording, notes)}
          onClose={() => setWriting(false)}
        />
      )}
    </div>
  );
}

function Facts({ recording, behaviour }: { recording: Recording; behaviour: Behaviour }) {
  const game = useGame();
  const result = describeResult(recording, behaviour, game);
  return (
    <section className={styles.facts}>
      {result && (
        <p>
          <strong>{result}</strong>
        </p>
      )}
      <p>{describeCourse(recording, game)}</p>
      <ColumnBars counts={recording.hits_per_column} target={behaviour.target} />
      <MeasureChecklist recording={recording} behaviour={behaviour} />
      <p className={styles.badges}>
        <SourceBadge recording={recording} />
        <VerifiedBadge recording={recording} />
      </p>
      <p className={styles.hint}>
        {moment(recording.created_at)} · {countersOf(recording, game)}
        {recording.start.idle_frames !== undefined &&
          plural(recording.start.idle_frames, {
            one: "start after # idle frame",
            other: "start after # idle frames",
          })}
        {recording.evaluation_start !== null && (
          <>
            , <Trans>which is evaluation start {recording.evaluation_start}</Trans>
          </>
        )}
      </p>
      {recording.run_id === null && <KeepOrDiscard recording={recording} />}
      {recording.notes && <p className={styles.note}>{recording.notes}</p>}
      {recording.run_id !== null && (
        <p>
          <Link to={`/runs/${recording.run_id}`}>
            <Trans>The run whose imitator or clone played it</Trans>
          </Link>
        </p>
      )}
      {recording.begun_by && (
        <p>
          <Trans>
            The {inSentence(actorNames()[recording.begun_by.policy])} of{" "}
            <Link to={`/runs/${recording.begun_by.run_id}`}>
              <RunName id={recording.begun_by.run_id} />
            </Link>{" "}
            played the first {seconds(recording.begun_by.frames / game.frame_rate_hz)}.
          </Trans>
        </p>
      )}
    </section>
  );
}

/** What the game counted, and its score where it can be told apart. */
function countersOf({ counters, score }: Recording, game: TaughtGame): string {
  const words = Object.entries(counters).map(([name, count]) =>
    name === "shots"
      ? plural(count, { one: "# shot", other: "# shots" })
      : `${game.counters[name] ?? name}: ${count}`,
  );
  if (game.items && score !== null) words.push(t`score ${score}`);
  return words.map((one) => `${one} · `).join("");
}

/** The hits, as links into the recording. */
function Hits({ playback, recording }: { playback: Playback; recording: Recording }) {
  const game = useGame();
  if (!game.items) return null;
  if (recording.hits.length === 0)
    return <p className={styles.hint}>{wordsOf(game).noneTaken()}</p>;
  return (
    <ol className={styles.hits} aria-label={t`Hits`}>
      {recording.hits.map((hit) => (
        <li key={`${hit.frame}-${hit.row}-${hit.column}`}>
          <Button
            kind="quiet"
            onClick={() => {
              playback.pause();
              playback.seek(hit.frame);
            }}
          >
            {seconds(hit.frame / game.frame_rate_hz, 2)} {cellName([hit.row, hit.column])}
            {hit.on_target === false && (
              <strong>
                {" "}
                × <Trans>stray</Trans>
              </strong>
            )}
          </Button>
        </li>
      ))}
    </ol>
  );
}

function Relatives({ course }: { course: RecordingCourse }) {
  const { parent, branches } = course;
  if (!parent && branches.length === 0) return null;
  return (
    <section>
      <h3>
        <Trans>Related</Trans>
      </h3>
      <ul className={styles.relatives}>
        {parent && (
          <li>
            <Trans>
              Branches off{" "}
              <Link to={`/recordings/${parent.recording_id}?frame=${parent.frame}`}>
                {inSentence(numberedName(parent.number))}, frame {parent.frame}
              </Link>
            </Trans>
          </li>
        )}
        {branches.map((branch) => (
          <li key={branch.recording_id}>
            <Trans>
              <Link to={`/recordings/${branch.recording_id}?frame=${branch.frame}`}>
                {numberedName(branch.number)}
              </Link>{" "}
              branches off at frame {branch.frame}
            </Trans>
          </li>
        ))}
      </ul>
    </section>
  );
}

/** The conditions that were recorded or imported with it. */
function Conditions({ course }: { course: RecordingCourse }) {
  if (Object.keys(course.conditions).length === 0) return null;
  return (
    <details>
      <summary>
        <Trans>How it was played</Trans>
      </summary>
      <div className={styles.conditions}>
        <ValueTable rows={valueRows(course.conditions)} label={t`How it was played`} />
      </div>
    </details>
  );
}

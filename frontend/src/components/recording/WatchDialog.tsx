import { useQuery } from "@tanstack/react-query";
import type { ReactNode } from "react";
import { Link } from "react-router";

import { messageOf } from "@/api/client";
import { framesQuery } from "@/api/recordings";
import { rewardTraceQuery } from "@/api/runs";
import type { Recording } from "@/api/types";
import { Dialog } from "@/components/controls/Dialog";
import { Failed, Loading, Notice } from "@/components/feedback/States";
import { courseInWords, recordingName, scoreInWords } from "@/lib/recordings";

import { RecordingPlayer } from "./RecordingPlayer";
import styles from "./WatchDialog.module.css";

interface WatchDialogProps {
  recording: Recording;
  /** Target aliens of the behaviour, if it has a target. */
  nTargets: number | null;
  title?: ReactNode;
  /** Shows this run's R along time. */
  runId?: string | undefined;
  /** Where to begin, standing still. */
  startFrame?: number | undefined;
  onClose: () => void;
}

/** Watches a recording: play, pause, any frame, any speed. */
export function WatchDialog(props: WatchDialogProps) {
  const { recording, nTargets, title, runId, startFrame, onClose } = props;
  const frames = useQuery(framesQuery(recording));
  const trace = useQuery({
    ...rewardTraceQuery(runId ?? "", recording.id),
    enabled: runId !== undefined,
  });
  return (
    <Dialog title={title ?? recordingName(recording)} onClose={onClose} width="56rem">
      <div className={styles.watch}>
        {frames.data ? (
          <RecordingPlayer
            frames={frames.data}
            hits={recording.hits}
            rewards={trace.data?.rewards}
            startFrame={startFrame}
            screenHeight={screenHeight}
          />
        ) : frames.error ? (
          <Failed what="The recording" error={frames.error} onRetry={() => void frames.refetch()} />
        ) : (
          <Loading what="the recording" rows={1} height="20rem" />
        )}
        {trace.error && (
          <Notice tone="calm" live>
            <p>R along time can&rsquo;t be shown: {messageOf(trace.error)}</p>
          </Notice>
        )}
        <p className={styles.facts}>
          <span>{scoreInWords(recording, nTargets)}</span>
          <span>{courseInWords(recording)}</span>
          <Link to={`/recordings/${recording.id}`}>Its page: actions, memory, downloads</Link>
        </p>
      </div>
    </Dialog>
  );
}

/** The dialog's chrome takes this much of the window's height, with R and without. */
const CHROME_PX = 300;
const screenHeight = (windowHeight: number) => windowHeight - CHROME_PX;

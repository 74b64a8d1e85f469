import { useQuery } from "@tanstack/react-query";
import type { ReactNode } from "react";
import { Link } from "react-router";

import { messageOf } from "@/api/client";
import { framesQuery } from "@/api/recordings";
import { rewardTraceQuery } from "@/api/runs";
import type { Recording } from "@/api/types";
import { Dialog } from "@/components/controls/Dialog";
import { Failed, Loading, Notice } from "@/components/feedback/States";
import { describeCourse, recordingName, describeScore } from "@/lib/recordings";

import { RecordingPlayer } from "./RecordingPlayer";
import styles from "./WatchDialog.module.css";

interface WatchDialogProps {
  recording: Recording;
  /** Number of target aliens; null without a target. */
  nTargets: number | null;
  title?: ReactNode;
  /** The run whose R is plotted over time. */
  runId?: string | undefined;
  /** The frame to begin at, paused. */
  startFrame?: number | undefined;
  /** Shown below the player. */
  actions?: ReactNode;
  onClose: () => void;
}

/** Plays a recording back in a dialog. */
export function WatchDialog(props: WatchDialogProps) {
  const { recording, nTargets, title, runId, startFrame, actions, onClose } = props;
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
            <p>R over time can&rsquo;t be shown: {messageOf(trace.error)}</p>
          </Notice>
        )}
        <p className={styles.facts}>
          <span>{describeScore(recording, nTargets)}</span>
          <span>{describeCourse(recording)}</span>
          <Link to={`/recordings/${recording.id}`}>Details: actions, memory, downloads</Link>
        </p>
        {actions && <div>{actions}</div>}
      </div>
    </Dialog>
  );
}

/** The part of the window's height that the rest of the dialog needs. */
const CHROME_PX = 300;
const screenHeight = (windowHeight: number) => windowHeight - CHROME_PX;

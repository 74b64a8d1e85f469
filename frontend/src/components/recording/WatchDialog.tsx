import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import type { ReactNode } from "react";
import { Link } from "react-router";

import { framesQuery } from "@/api/recordings";
import type { Behaviour, Recording } from "@/api/types";
import { Dialog } from "@/components/controls/Dialog";
import { Failed, Loading } from "@/components/feedback/States";
import { useGame } from "@/games/game";
import { describeCourse, describeResult } from "@/games/outcomes";
import { recordingName } from "@/lib/recordings";

import { RecordingPlayer } from "./RecordingPlayer";
import styles from "./WatchDialog.module.css";

interface WatchDialogProps {
  recording: Recording;
  behaviour: Behaviour;
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
  const game = useGame();
  const { recording, behaviour, title, runId, startFrame, actions, onClose } = props;
  const frames = useQuery(framesQuery(recording));
  return (
    <Dialog title={title ?? recordingName(recording)} onClose={onClose} width="56rem">
      <div className={styles.watch}>
        {frames.data ? (
          <RecordingPlayer
            frames={frames.data}
            hits={behaviour.target ? recording.hits : undefined}
            reward={runId === undefined ? undefined : { runId, recordingId: recording.id }}
            startFrame={startFrame}
            screenHeight={screenHeight}
          />
        ) : frames.error ? (
          <Failed
            what={t`The recording`}
            error={frames.error}
            onRetry={() => void frames.refetch()}
          />
        ) : (
          <Loading what={t`the recording`} rows={1} height="20rem" />
        )}
        <p className={styles.facts}>
          <span>{describeResult(recording, behaviour, game)}</span>
          <span>{describeCourse(recording, game)}</span>
          <Link to={`/recordings/${recording.id}`}>
            <Trans>Details: actions, memory, downloads</Trans>
          </Link>
        </p>
        {actions && <div>{actions}</div>}
      </div>
    </Dialog>
  );
}

/** The part of the window's height that the rest of the dialog needs. */
const CHROME_PX = 420;
const screenHeight = (windowHeight: number) => Math.max(windowHeight - CHROME_PX, 210);

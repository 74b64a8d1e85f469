import { t } from "@lingui/core/macro";
import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { useState } from "react";

import { shownQuery } from "@/api/library";
import type { Behaviour } from "@/api/types";
import { WatchDialog } from "@/components/recording/WatchDialog";
import { useGame } from "@/games/game";
import { describeCourse, describeResult } from "@/games/outcomes";
import { useMedia } from "@/lib/browser/use-media";
import { recordingName } from "@/lib/recordings";

import styles from "./Preview.module.css";
import { RecordingScreen } from "./RecordingScreen";

const PREVIEW = { width: 320, height: 210 } as const;
/** Where 320 pixels have no room. */
const NARROW_PREVIEW = { width: 232, height: 152 } as const;

/** A preview of the recording that is pointed at. */
export function Preview({
  recordingId,
  playing,
  behaviour,
}: {
  recordingId: number | undefined;
  playing: boolean;
  behaviour: Behaviour;
}) {
  const game = useGame();
  const size = useMedia("(max-width: 27rem)") ? NARROW_PREVIEW : PREVIEW;
  const [watching, setWatching] = useState(false);
  const { data: recording } = useQuery({
    ...shownQuery(behaviour.id, recordingId ?? 0),
    enabled: recordingId !== undefined,
    // The one before stays until the next is there, so that nothing jumps.
    placeholderData: keepPreviousData,
  });
  if (!recording) return null;
  return (
    <section className={styles.preview} aria-label={t`Preview`}>
      <button
        type="button"
        className={styles.screen}
        aria-label={t`Watch ${recordingName(recording)}`}
        onClick={() => setWatching(true)}
      >
        <RecordingScreen key={recording.id} recording={recording} playing={playing} {...size} />
      </button>
      <p className={styles.caption}>
        <strong>{recordingName(recording)}</strong>
        <span>
          {playing
            ? describeResult(recording, behaviour, game) || describeCourse(recording, game)
            : t`Point at a recording to play it here.`}
        </span>
      </p>
      {watching && (
        <WatchDialog
          recording={recording}
          behaviour={behaviour}
          onClose={() => setWatching(false)}
        />
      )}
    </section>
  );
}

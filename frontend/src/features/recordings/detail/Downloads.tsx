import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useState } from "react";

import { messageOf } from "@/api/client";
import { type ClipKind, fetchClip, recordingExportUrl } from "@/api/recordings";
import type { Recording } from "@/api/types";
import { Button, DownloadLink } from "@/components/controls/Button";
import { Notice } from "@/components/feedback/States";
import { saveFile } from "@/lib/browser/save-file";

import styles from "./Downloads.module.css";

const clips = (): readonly (readonly [kind: ClipKind, name: string, hint: string])[] => [
  ["mp4", "MP4", t`every frame, 60 a second`],
  ["gif", "GIF", t`20 pictures a second`],
  ["webp", "WebP", t`20 pictures a second, smaller`],
];

/** Downloads a recording as a clip or as data. */
export function Downloads({ recording }: { recording: Recording }) {
  const [making, setMaking] = useState<ClipKind | null>(null);
  const [error, setError] = useState<unknown>(null);

  async function download(kind: ClipKind) {
    setMaking(kind);
    setError(null);
    try {
      const clip = await fetchClip(recording, kind);
      saveFile(clip, clip.name);
    } catch (problem) {
      setError(problem);
    } finally {
      setMaking(null);
    }
  }

  return (
    <>
      <div className={styles.buttons}>
        {clips().map(([kind, name, hint]) => (
          <Button
            key={kind}
            icon="download"
            title={hint}
            disabled={making !== null}
            onClick={() => void download(kind)}
          >
            {making === kind ? t`Making the ${name}…` : name}
          </Button>
        ))}
        <DownloadLink href={recordingExportUrl(recording.id)}>
          <Trans>Data (JSON)</Trans>
        </DownloadLink>
      </div>
      <p className={styles.hint} role="status">
        {making !== null && t`The game is replayed and encoded; this takes some seconds.`}
      </p>
      {error !== null && (
        <Notice tone="bad" live>
          <p>{messageOf(error)}</p>
        </Notice>
      )}
    </>
  );
}

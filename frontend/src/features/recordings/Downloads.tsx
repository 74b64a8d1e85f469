import styles from "./RecordingPage.module.css";

import { recordingExportUrl } from "@/api/recordings";
import type { Recording } from "@/api/types";
import buttonStyles from "@/components/Button.module.css";
import { Icon } from "@/components/Icon";

/** What a recording can be taken away as. */
export function Downloads({ recording }: { recording: Recording }) {
  return (
    <div className={styles.buttons}>
      <a className={buttonStyles.button} href={recordingExportUrl(recording.id)} download>
        <Icon name="download" />
        Data (JSON)
      </a>
    </div>
  );
}

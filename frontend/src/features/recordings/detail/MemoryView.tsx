import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useState, useSyncExternalStore } from "react";

import { memoryQuery } from "@/api/recordings";
import type { RecordingCourse } from "@/api/types";
import { Failed, Loading } from "@/components/feedback/States";
import { classes } from "@/lib/classes";
import type { Playback } from "@/lib/game/playback";

import { hex, memoryAt } from "./memory";
import styles from "./MemoryView.module.css";

const BYTES_PER_LINE = 16;

/** The console's memory at the current frame, collapsed by default. */
export function MemoryView({ playback, course }: { playback: Playback; course: RecordingCourse }) {
  const [open, setOpen] = useState(false);
  return (
    <details
      className={styles.memory}
      open={open}
      onToggle={(event) => setOpen(event.currentTarget.open)}
    >
      <summary>
        <Trans>Console memory</Trans>
      </summary>
      {open && <Memory playback={playback} course={course} />}
    </details>
  );
}

function Memory({ playback, course }: { playback: Playback; course: RecordingCourse }) {
  const { frame } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  const { data, error, refetch } = useQuery(memoryQuery(course.memory_url));
  if (error && !data) {
    return <Failed what={t`The memory`} error={error} onRetry={() => void refetch()} />;
  }
  if (!data) return <Loading what={t`the memory`} rows={1} height="12rem" />;
  const bytes = memoryAt(data, frame);
  const names = new Map(course.memory_names.map(({ address, name }) => [address, name]));
  const lines = Array.from({ length: bytes.length / BYTES_PER_LINE }, (_, line) =>
    bytes.slice(line * BYTES_PER_LINE, (line + 1) * BYTES_PER_LINE),
  );
  return (
    <>
      <p className={styles.hint}>
        <Trans>
          {bytes.length} bytes at frame {frame}, in hexadecimal. Those that changed in this frame
          are underlined. Reward, imitator and clone see screens alone.
        </Trans>
      </p>
      <div className={styles.scroll}>
        <table className={styles.bytes} aria-label={t`Memory at frame ${frame}`}>
          <tbody>
            {lines.map((line, index) => (
              <tr key={index}>
                <th scope="row">{index * BYTES_PER_LINE}</th>
                {line.map(({ address, value, changed }) => (
                  <td
                    key={address}
                    className={classes(
                      changed && styles.changed,
                      names.has(address) && styles.named,
                    )}
                    title={`${address}: ${names.get(address) ?? t`unnamed`}, ${value}`}
                  >
                    {hex(value)}
                  </td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
        <table className={styles.names} aria-label={t`Known addresses`}>
          <tbody>
            {course.memory_names.map(({ address, name }) => (
              <tr key={address}>
                <td>{address}</td>
                <th scope="row">{name}</th>
                <td>{bytes[address]?.value}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </>
  );
}

import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useState, useSyncExternalStore } from "react";

import { connection } from "@/api/connection";
import { isAlive, systemQuery } from "@/api/system";
import { activeRunsQuery } from "@/api/runs";
import type { Run, System } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { useOnlyPlays } from "@/components/people/use-only-plays";
import { classes } from "@/lib/classes";
import { bytes, percentDone } from "@/lib/format";

import styles from "./StatusMenu.module.css";

/** Whether the worker is running, or not known to be, with a dialog about processes and disk usage. */
export function StatusMenu() {
  const enabled = useOnlyPlays() === false;
  const { data: system } = useQuery({ ...systemQuery, enabled });
  const { data: active = [] } = useQuery({ ...activeRunsQuery, enabled });
  const training = active.filter((run) => run.status === "running" || run.status === "cancelling");
  const { reachable, live } = useSyncExternalStore(connection.subscribe, connection.snapshot);
  const [open, setOpen] = useState(false);
  const worker = isAlive(system, "worker");
  if (!system || worker === null) return null;
  const isCurrent = reachable && live;
  const status = isCurrent ? workerStatus(system, worker, training) : t`No connection`;
  return (
    <>
      <Button
        kind="quiet"
        className={classes(styles.process, !(worker && isCurrent) && styles.off)}
        aria-label={t`${status}. Processes and disk`}
        title={t`Processes and disk`}
        onClick={() => setOpen(true)}
      >
        <span>{status}</span>
      </Button>
      {open && (
        <Dialog title={t`Processes and disk`} onClose={() => setOpen(false)} width="30rem">
          <div className={styles.form}>
            <Processes system={system} />
            <Disk system={system} />
          </div>
        </Dialog>
      )}
    </>
  );
}

/** What people read of the workers; a busy one lives, but its machine leaves it no time. */
function workerStatus(system: System, alive: boolean, training: readonly Run[]): string {
  if (!alive) return t`Worker not running`;
  const [first] = training;
  if (first && training.length === 1) return t`Training, ${percentDone(first.progress)}`;
  if (first) return t`Training ${training.length} runs`;
  const isReady = system.processes.some(
    (process) => process.kind === "worker" && process.alive && !process.busy,
  );
  return isReady ? t`Worker ready` : t`Worker busy`;
}

const kindNames = () =>
  ({ server: t`Server`, worker: t`Worker`, inference: t`Inference` }) as const;

function Processes({ system }: { system: System }) {
  return (
    <section>
      <h3>
        <Trans>Processes of Tril {system.version}</Trans>
      </h3>
      <table className={styles.facts}>
        <tbody>
          {system.processes.map((process) => (
            <tr key={process.name}>
              <th scope="row">
                {kindNames()[process.kind]}
                <small className={styles.device}>{deviceOf(process)}</small>
              </th>
              <td>{stateOf(process)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </section>
  );
}

function stateOf({ alive, busy }: System["processes"][number]): string {
  if (busy) return t`busy`;
  return alive ? t`running` : t`not responding`;
}

/** Where a worker learns: its machine, and its GPU or how many cores it has. */
function deviceOf({ host, gpu, cores }: System["processes"][number]): string {
  const device =
    gpu ?? (cores === null ? null : plural(cores, { one: "# core", other: "# cores" }));
  return [host, device].filter((part) => part !== null).join(", ");
}

function Disk({ system }: { system: System }) {
  const { storage, data_bytes: total, disk_free_bytes: free } = system;
  return (
    <section>
      <h3>
        <Trans>Disk</Trans>
      </h3>
      <table className={styles.facts}>
        <tbody>
          <tr>
            <th scope="row">
              <Trans>Recordings, rankings and curves</Trans>
            </th>
            <td>{bytes(storage.databases_bytes)}</td>
          </tr>
          <tr>
            <th scope="row">
              <Trans>Files of runs</Trans>
            </th>
            <td>{bytes(storage.artifacts_bytes)}</td>
          </tr>
          <tr>
            <th scope="row">
              <Trans>Cache of frames and clips</Trans>
            </th>
            <td>
              <Trans>
                {bytes(storage.cache_bytes)}, at most {bytes(storage.cache_limit_bytes)}
              </Trans>
            </td>
          </tr>
          <tr>
            <th scope="row">
              <Trans>Everything else</Trans>
            </th>
            <td>{bytes(storage.other_bytes)}</td>
          </tr>
        </tbody>
        <tfoot>
          <tr>
            <th scope="row">
              <Trans>Total</Trans>
            </th>
            <td>{bytes(total)}</td>
          </tr>
          <tr>
            <th scope="row">
              <Trans>Free on the disk</Trans>
            </th>
            <td>{bytes(free)}</td>
          </tr>
        </tfoot>
      </table>
      <p className={styles.hint}>
        <Trans>
          <code>tril backup</code> copies recordings, rankings and runs while Tril keeps running.
        </Trans>
      </p>
    </section>
  );
}

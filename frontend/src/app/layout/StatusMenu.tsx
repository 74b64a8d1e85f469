import { useQuery } from "@tanstack/react-query";
import { useState } from "react";

import { isAlive, systemQuery } from "@/api/system";
import type { System } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { classes } from "@/lib/classes";
import { bytes } from "@/lib/format";

import styles from "./StatusMenu.module.css";

/** Whether the worker is running, with a dialog about processes and disk usage. */
export function StatusMenu() {
  const { data: system } = useQuery(systemQuery);
  const [open, setOpen] = useState(false);
  const worker = isAlive(system, "worker");
  if (!system || worker === null) return null;
  const status = worker ? "Worker ready" : "Worker not running";
  return (
    <>
      <Button
        kind="quiet"
        className={classes(styles.process, !worker && styles.off)}
        aria-label={`${status}. Processes and disk`}
        title="Processes and disk"
        onClick={() => setOpen(true)}
      >
        <span>{status}</span>
      </Button>
      {open && (
        <Dialog title="Processes and disk" onClose={() => setOpen(false)} width="30rem">
          <div className={styles.form}>
            <Processes system={system} />
            <Disk system={system} />
          </div>
        </Dialog>
      )}
    </>
  );
}

const KIND_NAMES = { server: "Server", worker: "Worker", inference: "Inference" } as const;

function Processes({ system }: { system: System }) {
  return (
    <section>
      <h3>Processes of Tril {system.version}</h3>
      <table className={styles.facts}>
        <tbody>
          {system.processes.map(({ name, kind, alive }) => (
            <tr key={name}>
              <th scope="row">{KIND_NAMES[kind]}</th>
              <td>{alive ? "running" : "not responding"}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </section>
  );
}

function Disk({ system }: { system: System }) {
  const { storage, data_bytes: total, disk_free_bytes: free } = system;
  return (
    <section>
      <h3>Disk</h3>
      <table className={styles.facts}>
        <tbody>
          <tr>
            <th scope="row">Recordings, rankings and curves</th>
            <td>{bytes(storage.databases_bytes)}</td>
          </tr>
          <tr>
            <th scope="row">Files of runs</th>
            <td>{bytes(storage.artifacts_bytes)}</td>
          </tr>
          <tr>
            <th scope="row">Cache of frames and clips</th>
            <td>
              {bytes(storage.cache_bytes)}, at most {bytes(storage.cache_limit_bytes)}
            </td>
          </tr>
          <tr>
            <th scope="row">Everything else</th>
            <td>{bytes(storage.other_bytes)}</td>
          </tr>
        </tbody>
        <tfoot>
          <tr>
            <th scope="row">Total</th>
            <td>{bytes(total)}</td>
          </tr>
          <tr>
            <th scope="row">Free on the disk</th>
            <td>{bytes(free)}</td>
          </tr>
        </tfoot>
      </table>
      <p className={styles.hint}>
        <code>tril backup</code> copies recordings, rankings and runs while Tril keeps running.
      </p>
    </section>
  );
}

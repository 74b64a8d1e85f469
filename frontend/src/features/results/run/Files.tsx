import type { Artifact } from "@/api/types";
import tables from "@/features/results/tables.module.css";
import { bytes } from "@/lib/format";

import styles from "./Files.module.css";

const KINDS: Readonly<Record<string, string>> = {
  reward_model: "Reward model",
  imitator: "Imitator",
  clone: "Clone",
  attention_map: "Attention map",
  attention_red_blue: "Attention map, red-blue",
  attention_frame: "Screen of an attention map",
  figure: "Figure",
  summary: "Summary",
};

/** The artifacts of a run, for download. */
export function Files({ artifacts }: { artifacts: readonly Artifact[] }) {
  return (
    <div className={styles.scroll}>
      <table className={tables.table} aria-label="Files">
        <thead>
          <tr>
            <th scope="col">File</th>
            <th scope="col">What it is</th>
            <th scope="col" className={tables.right}>
              Size
            </th>
          </tr>
        </thead>
        <tbody>
          {artifacts.map((file) => (
            <tr key={file.id}>
              <td>
                <a href={file.url} download={file.name}>
                  {file.name}
                </a>
              </td>
              <td>
                {KINDS[file.kind] ?? file.kind.replaceAll("_", " ")}
                {file.name.endsWith(".zip") && ", for stable-baselines3"}
                {file.kind.startsWith("attention") && `, ${formatOf(file.name)}`}
              </td>
              <td className={tables.right}>{bytes(file.size_bytes)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** Names a file's format by its ending: "PNG". */
function formatOf(name: string): string {
  return name.slice(name.lastIndexOf(".") + 1).toUpperCase();
}

import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Artifact } from "@/api/types";
import tables from "@/features/results/tables.module.css";
import { bytes } from "@/lib/format";

import styles from "./Files.module.css";

const kinds = (): Readonly<Record<string, string>> => ({
  reward_model: t`Reward model`,
  imitator: t`Imitator`,
  clone: t`Clone`,
  attention_map: t`Attention map`,
  reward_percentiles: t`States by percentile of the reward`,
  attention_red_blue: t`Attention map, red-blue`,
  attention_frame: t`Screen of an attention map`,
  figure: t`Figure`,
  summary: t`Summary`,
});

/** The artifacts of a run, for download. */
export function Files({ artifacts }: { artifacts: readonly Artifact[] }) {
  return (
    <div className={styles.scroll}>
      <table className={tables.table} aria-label={t`Files`}>
        <thead>
          <tr>
            <th scope="col">
              <Trans>File</Trans>
            </th>
            <th scope="col">
              <Trans>What it is</Trans>
            </th>
            <th scope="col" className={tables.right}>
              <Trans>Size</Trans>
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
                {kinds()[file.kind] ?? file.kind.replaceAll("_", " ")}
                {file.name.endsWith(".zip") && `, ${t`for stable-baselines3`}`}
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

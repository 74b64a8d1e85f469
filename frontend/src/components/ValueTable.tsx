import { Fragment } from "react";

import type { ValueRow } from "@/lib/recipe-values";

import styles from "./ValueTable.module.css";

/** Names and values, by section. */
export function ValueTable({ rows, label }: { rows: readonly ValueRow[]; label: string }) {
  return (
    <table className={styles.table} aria-label={label}>
      <tbody>
        {rows.map((row, index) => (
          <Fragment key={`${row.section}-${row.name}`}>
            {row.section !== "" && row.section !== rows[index - 1]?.section && (
              <tr className={styles.section}>
                <th scope="colgroup" colSpan={2}>
                  {row.section}
                </th>
              </tr>
            )}
            <tr>
              <th scope="row">{row.name}</th>
              <td>{row.value}</td>
            </tr>
          </Fragment>
        ))}
      </tbody>
    </table>
  );
}

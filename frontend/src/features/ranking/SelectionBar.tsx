import { useState } from "react";

import { Button } from "@/components/controls/Button";
import { gapPlace, tierPlace, TRAY } from "@/features/ranking/board/places";
import { tierOf, type Tiers } from "@/features/ranking/order/order";
import { count } from "@/lib/format";

import styles from "./SelectionBar.module.css";

interface SelectionBarProps {
  tiers: Tiers;
  selected: readonly number[];
  /** Puts all selected recordings into one place. */
  onPut: (place: string) => void;
  onSelectNone: () => void;
}

/** Moves all selected recordings at once; in sight wherever the page is scrolled to. */
export function SelectionBar({ tiers, selected, onPut, onSelectNone }: SelectionBarProps) {
  const [wanted, setWanted] = useState<number | null>(null);
  if (selected.length === 0) return null;
  const worst = tiers.length - 1;
  const tier = Math.min(wanted ?? worst, worst);
  return (
    <div role="group" aria-label="Selected recordings" className={styles.bar}>
      <span className={styles.count}>{count(selected.length, "recording")} selected</span>
      <Button kind="quiet" className={styles.none} onClick={onSelectNone}>
        Select none
      </Button>
      <Button kind="primary" icon="down" onClick={() => onPut(gapPlace(tiers.length))}>
        Put below the worst
      </Button>
      {tiers.length > 0 && (
        <span className={styles.tier}>
          <select
            aria-label="Tier to put them into"
            className={styles.choice}
            value={tier}
            onChange={(event) => setWanted(Number(event.currentTarget.value))}
          >
            {tiers.map((_, index) => (
              <option key={index} value={index}>
                Tier {index + 1}
                {index === 0 ? ", best" : index === worst ? ", worst" : ""}
              </option>
            ))}
          </select>
          <Button onClick={() => onPut(tierPlace(tier))}>Put into tier {tier + 1}</Button>
        </span>
      )}
      {selected.some((id) => tierOf(tiers, id) >= 0) && (
        <Button icon="tray" onClick={() => onPut(TRAY)}>
          Take off the board
        </Button>
      )}
    </div>
  );
}

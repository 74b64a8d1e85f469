import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useState } from "react";

import { Button } from "@/components/controls/Button";
import { gapPlace, tierPlace, TRAY } from "@/features/ranking/board/places";
import { tierOf, type Tiers } from "@/features/ranking/order/order";

import styles from "./SelectionBar.module.css";

interface SelectionBarProps {
  tiers: Tiers;
  selected: readonly number[];
  /** Puts all selected recordings into one place. */
  onPut: (place: string) => void;
  /** Places the unranked ones by comparing; null if there are none, or nothing to compare with. */
  onCompare: (() => void) | null;
  onSelectNone: () => void;
}

/** Moves all selected recordings at once; in sight wherever the page is scrolled to. */
export function SelectionBar({
  tiers,
  selected,
  onPut,
  onCompare,
  onSelectNone,
}: SelectionBarProps) {
  /** A recording of the chosen tier, whose number may change. */
  const [wanted, setWanted] = useState<number | null>(null);
  if (selected.length === 0) return null;
  const worst = tiers.length - 1;
  const found = wanted === null ? -1 : tierOf(tiers, wanted);
  const tier = found < 0 ? worst : found;
  return (
    <div
      ref={keepMessagesAbove}
      role="group"
      aria-label={t`Selected recordings`}
      className={styles.bar}
    >
      <span className={styles.count}>
        <Plural value={selected.length} one="# recording selected" other="# recordings selected" />
      </span>
      <Button kind="quiet" className={styles.none} onClick={onSelectNone}>
        <Trans>Select none</Trans>
      </Button>
      <Button icon="down" onClick={() => onPut(gapPlace())}>
        <Trans>Put below the worst</Trans>
      </Button>
      {tiers.length > 0 && (
        <span className={styles.tier}>
          <select
            aria-label={t`Tier to put them into`}
            className={styles.choice}
            value={tier}
            onChange={(event) => setWanted(tiers[Number(event.currentTarget.value)]?.[0] ?? null)}
          >
            {tiers.map((_, index) => (
              <option key={index} value={index}>
                {tierName(index + 1, worst + 1)}
              </option>
            ))}
          </select>
          <Button onClick={() => onPut(tierPlace(tiers[tier] ?? []))}>
            <Trans>Put into tier {tier + 1}</Trans>
          </Button>
        </span>
      )}
      {onCompare && (
        <Button icon="compare" onClick={onCompare}>
          <Trans>Place by comparing</Trans>
        </Button>
      )}
      {selected.some((id) => tierOf(tiers, id) >= 0) && (
        <Button icon="tray" onClick={() => onPut(TRAY)}>
          <Trans>Take off the board</Trans>
        </Button>
      )}
    </div>
  );
}

/** Tells the page how much of its bottom a bar takes, so that messages stand above it. */
function keepMessagesAbove(bar: HTMLElement | null): (() => void) | undefined {
  if (!bar) return undefined;
  const { style } = document.documentElement;
  const observer = new ResizeObserver(() =>
    style.setProperty("--bottom-bar", `${bar.offsetHeight}px`),
  );
  observer.observe(bar);
  return () => {
    observer.disconnect();
    style.removeProperty("--bottom-bar");
  };
}

function tierName(tier: number, worst: number): string {
  if (tier === 1) return t`Tier ${tier}, best`;
  return tier === worst ? t`Tier ${tier}, worst` : t`Tier ${tier}`;
}

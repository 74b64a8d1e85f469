import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { GameOpinion } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { classes } from "@/lib/classes";
import { listed } from "@/lib/format";
import { useRecordingName } from "@/features/ranking/recording-names";

import styles from "./Opinion.module.css";

interface OpinionProps {
  opinion: GameOpinion;
  /** The game's tier, counted from 1; null if it is unranked. */
  tier: number | null;
  /** Whether the game is to stay where it is, whatever the others suggest. */
  kept: boolean;
  /** Whether tiers have the numbers that the opinion names. */
  current: boolean;
  onMove: (tier: number) => void;
  onKeep: () => void;
}

/** Where the other games suggest that a game belongs, how surely, and whether that contradicts. */
export function Opinion({ opinion, tier, kept, current, onMove, onKeep }: OpinionProps) {
  const { place, best_place: best, worst_place: worst, contradicted_by: against } = opinion;
  const nameOf = useRecordingName();
  const name = nameOf(opinion.recording_id);
  const others = against.map((id) => nameOf(id));
  const scale = (
    <span className={styles.scale} aria-hidden="true">
      <i
        className={styles.band}
        style={{ insetInlineStart: along(best), inlineSize: along(worst - best) }}
      />
      <i className={styles.tick} style={{ insetInlineStart: along(place) }} />
    </span>
  );
  if (tier === null || against.length === 0 || kept) {
    return (
      <div className={styles.opinion}>
        <p className={styles.place}>
          {scale}
          {placeText(tier, opinion)}
        </p>
      </div>
    );
  }
  return (
    <div className={styles.opinion}>
      {/* The line takes no more room than without a contradiction: it comes while cards are dragged. */}
      <details className={styles.contradiction} aria-label={t`Contradiction at ${name}`}>
        <summary className={styles.place}>
          <Icon name="alert" />
          {placeText(tier, opinion)}
        </summary>
        <div className={styles.reason}>
          {scale}
          <p>
            {opinion.tier < tier ? (
              <Trans>
                By what it hits, it belongs higher: about tier {opinion.tier}. It is no worse than{" "}
                {listed(others)}.
              </Trans>
            ) : (
              <Trans>
                By what it hits, it belongs lower: about tier {opinion.tier}. It is no better than{" "}
                {listed(others)}.
              </Trans>
            )}
          </p>
          <div className={styles.choice}>
            <Button
              aria-label={t`Move to tier ${opinion.tier}: ${name}`}
              // Not `disabled`, which would lose the focus.
              aria-disabled={!current}
              onClick={({ currentTarget }) => {
                if (!current) return;
                focusHandle(currentTarget);
                onMove(opinion.tier);
              }}
            >
              <Trans>Move to tier {opinion.tier}</Trans>
            </Button>
            <Button
              kind="quiet"
              aria-label={t`Keep it here: ${name}`}
              onClick={({ currentTarget }) => {
                focusHandle(currentTarget);
                onKeep();
              }}
            >
              <Trans>Keep it here</Trans>
            </Button>
          </div>
        </div>
      </details>
    </div>
  );
}

/** Keeps the room of an opinion that is being worked out, so that the cards below stay in place. */
export function AwaitedOpinion({ tier }: { tier: number | null }) {
  return (
    <div className={classes(styles.opinion, styles.awaited)} aria-hidden="true">
      <p className={styles.place}>
        <span className={styles.scale} />
        {placeText(tier, { tier: 1, best_tier: 1, worst_tier: 2 })}
      </p>
    </div>
  );
}

/** Focuses the handle of a button's card: the button goes with the contradiction. */
function focusHandle(button: HTMLElement): void {
  button.closest("article")?.querySelector("button")?.focus();
}

/** A share of the scale, in CSS. */
function along(share: number): string {
  return `${100 * share}%`;
}

type Placed = Pick<GameOpinion, "tier" | "best_tier" | "worst_tier">;

/** Says where a game in a tier, or in none, belongs. */
function placeText(tier: number | null, placed: Placed): string {
  return tier === null
    ? t`Probably ${describeTiers(placed)}`
    : t`The others suggest ${describeTiers(placed)}`;
}

/** Describes a tier and the tiers that are possible. */
function describeTiers({ tier, best_tier: best, worst_tier: worst }: Placed): string {
  return best === worst ? t`tier ${tier}` : t`tier ${tier} (${best} to ${worst})`;
}

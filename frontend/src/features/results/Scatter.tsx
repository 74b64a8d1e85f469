import type { CSSProperties } from "react";

import styles from "./Check.module.css";

import type { RankingCheck } from "@/api/types";
import { measured } from "@/lib/format";
import { recordingName } from "@/lib/recordings";
import { playedBy, thingColour } from "@/lib/things";

const WIDTH = 420;
const HEIGHT = 260;
const LEFT = 48;
const BOTTOM = 34;
const TOP = 8;

/** Predicted returns against tiers: falling from left to right where the model agrees. */
export function Scatter({ returns }: { returns: RankingCheck["returns"] }) {
  const tiers = Math.max(...returns.map(({ tier }) => tier), 2);
  const values = returns.map((one) => one.predicted_return);
  const low = Math.min(...values);
  const high = Math.max(...values);
  const x = (tier: number) => LEFT + ((tier - 0.5) / tiers) * (WIDTH - LEFT);
  const y = (value: number) =>
    TOP + (1 - (value - low) / (high - low || 1)) * (HEIGHT - TOP - BOTTOM);
  const marks = low === high ? [low] : [low, (low + high) / 2, high];
  return (
    <figure className={styles.scatter}>
      <figcaption>Predicted return by tier, 1 is the best</figcaption>
      <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label="Predicted return by tier">
        {marks.map((value) => (
          <g key={value}>
            <line className={styles.grid} x1={LEFT} x2={WIDTH} y1={y(value)} y2={y(value)} />
            <text x={LEFT - 8} y={y(value) + 4} textAnchor="end">
              {measured(value)}
            </text>
          </g>
        ))}
        {Array.from({ length: tiers }, (_, index) => (
          <text key={index} x={x(index + 1)} y={HEIGHT - 14} textAnchor="middle">
            {index + 1}
          </text>
        ))}
        {returns.map(({ tier, recording, predicted_return: value }) => (
          <circle
            key={recording.id}
            className={styles.dot}
            style={{ "--thing": thingColour(playedBy(recording.source)) } as CSSProperties}
            cx={x(tier)}
            cy={y(value)}
            r={4.5}
          >
            <title>{`${recordingName(recording)}, tier ${tier}: ${measured(value)}`}</title>
          </circle>
        ))}
      </svg>
    </figure>
  );
}

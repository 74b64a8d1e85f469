import { t } from "@lingui/core/macro";

import { Chart } from "./Chart";
import type { CurveGroup } from "./curve-groups";
import styles from "./Curves.module.css";
import { useZoom } from "./zoom";
import { ZoomBar } from "./ZoomBar";

export const chartHint = () =>
  t`Drag over a chart to zoom, double-click to show everything. With the keyboard: arrows read values, + and − zoom, 0 shows everything.`;

/** The charts of a stage, which share zoom and cursor. */
export function CurveGroupView({
  group,
  syncKey,
  isNamed = false,
  level: Heading = "h3",
}: {
  group: CurveGroup;
  syncKey: string;
  /** Whether a single line has its name at its end, too. */
  isNamed?: boolean;
  level?: "h2" | "h3";
}) {
  const zoom = useZoom(group.charts);
  return (
    <section className={styles.group} aria-label={group.name}>
      <div className={styles.head}>
        <Heading className={styles.name}>{group.name}</Heading>
        <ZoomBar zoom={zoom} of={group.name} />
      </div>
      <div className={styles.charts}>
        {group.charts.map((chart) => (
          <Chart
            key={chart.title}
            title={chart.title}
            curves={chart.curves}
            format={chart.format}
            range={chart.range}
            xLabels={group.xLabels}
            isNamed={isNamed}
            zoom={zoom}
            syncKey={syncKey}
          />
        ))}
      </div>
    </section>
  );
}

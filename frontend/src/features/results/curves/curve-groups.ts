/** The training curves shown, by stage. */

import { t } from "@lingui/core/macro";

import { fixed, measured, percent, stepLabels, whole } from "@/lib/format";

import type { Curve } from "./chart-data";
import type { XLabels } from "./chart-options";
import type { Series } from "./series";

export interface CurveChart {
  readonly title: string;
  readonly curves: readonly Curve[];
  readonly format: (value: number) => string;
  readonly range?: readonly [number, number];
}

export interface CurveGroup {
  readonly stage: string;
  readonly name: string;
  readonly xLabels: XLabels;
  readonly charts: readonly CurveChart[];
}

interface CurvePlan {
  readonly key: string;
  readonly name: string;
  readonly dashed?: boolean;
}

interface ChartPlan {
  readonly title: string;
  readonly curves: readonly CurvePlan[];
  readonly format: (value: number) => string;
  readonly range?: readonly [number, number];
}

interface GroupPlan {
  readonly stage: string;
  readonly name: string;
  readonly colour: string;
  readonly xLabels: XLabels;
  readonly charts: readonly ChartPlan[];
}

const SHARE = [0, 1] as const;
const percentage = (value: number) => percent(value);
const oneDigit = (value: number) => fixed(value, 1);

/** All charts of a run. */
export const plan = (): readonly GroupPlan[] => [
  {
    stage: "imitator",
    name: t`Imitator: training games, by steps`,
    colour: "var(--imitator)",
    xLabels: stepLabels,
    charts: [
      {
        title: t`Predicted return`,
        curves: [{ key: "predicted_return", name: t`predicted return` }],
        format: measured,
      },
      {
        title: t`Hits per game`,
        curves: [
          { key: "hits", name: t`targets` },
          { key: "strays", name: t`strays`, dashed: true },
        ],
        format: oneDigit,
      },
      {
        title: t`Game length, steps`,
        curves: [{ key: "episode_steps", name: t`steps` }],
        format: (value) => whole(Math.round(value)),
      },
      {
        title: t`Death rate`,
        curves: [{ key: "death_rate", name: t`share` }],
        format: percentage,
        range: SHARE,
      },
      {
        title: t`Agreement with the expert (DAgger)`,
        curves: [
          { key: "agreement", name: t`most probable action` },
          { key: "expert_share", name: t`steps by the expert`, dashed: true },
        ],
        format: percentage,
        range: SHARE,
      },
      {
        title: t`Discriminator accuracy (GAIL)`,
        curves: [{ key: "discriminator_accuracy", name: t`share` }],
        format: percentage,
        range: SHARE,
      },
      {
        title: t`Indecision (entropy)`,
        curves: [{ key: "entropy", name: t`entropy` }],
        format: measured,
      },
      {
        title: t`Speed, steps/s`,
        curves: [{ key: "steps_per_s", name: t`steps/s` }],
        format: (value) => whole(Math.round(value)),
      },
      {
        title: t`Critic’s error on the return (value loss)`,
        curves: [{ key: "value_loss", name: t`loss` }],
        format: measured,
      },
      {
        title: t`Change of its play per update (KL divergence)`,
        curves: [{ key: "kl", name: t`KL` }],
        format: measured,
      },
    ],
  },
  {
    stage: "reward",
    name: t`Reward model, by updates`,
    colour: "var(--ink-2)",
    xLabels: stepLabels,
    charts: [
      { title: t`Loss`, curves: [{ key: "loss", name: t`loss` }], format: measured },
      {
        title: t`Pair accuracy`,
        curves: [
          { key: "accuracy", name: t`training` },
          { key: "held_out_accuracy", name: t`held-out`, dashed: true },
        ],
        format: percentage,
        range: SHARE,
      },
    ],
  },
  {
    stage: "clone",
    name: t`Clone, by passes over the perfect recordings (epochs)`,
    colour: "var(--clone)",
    xLabels: stepLabels,
    charts: [
      { title: t`Loss`, curves: [{ key: "loss", name: t`loss` }], format: measured },
      {
        title: t`Action accuracy`,
        curves: [
          { key: "accuracy", name: t`training` },
          { key: "held_out_accuracy", name: t`validation`, dashed: true },
        ],
        format: percentage,
        range: SHARE,
      },
    ],
  },
];

/** Returns the groups and charts that have points. */
export function curveGroups(series: Series): readonly CurveGroup[] {
  return plan()
    .map(({ stage, name, colour, xLabels, charts }) => ({
      stage,
      name,
      xLabels,
      charts: charts.map((chart) => chartOf(chart, series[stage] ?? {}, colour)).filter(hasPoints),
    }))
    .filter((group) => group.charts.length > 0);
}

function chartOf(
  plan: ChartPlan,
  stage: Readonly<Record<string, Curve["points"]>>,
  colour: string,
): CurveChart {
  const curves = plan.curves
    .filter(({ key }) => (stage[key]?.length ?? 0) > 0)
    .map(({ key, name, dashed = false }) => ({ name, dashed, colour, points: stage[key] ?? [] }));
  return { ...plan, curves };
}

function hasPoints(chart: CurveChart): boolean {
  return chart.curves.length > 0;
}

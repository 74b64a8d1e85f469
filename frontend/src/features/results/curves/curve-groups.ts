/** The training curves shown, by stage. */
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
export const PLAN: readonly GroupPlan[] = [
  {
    stage: "imitator",
    name: "Imitator: training games, by steps",
    colour: "var(--imitator)",
    xLabels: stepLabels,
    charts: [
      {
        title: "Predicted return",
        curves: [{ key: "predicted_return", name: "predicted return" }],
        format: measured,
      },
      {
        title: "Aliens hit per game",
        curves: [
          { key: "hits", name: "targets" },
          { key: "strays", name: "strays", dashed: true },
        ],
        format: oneDigit,
      },
      {
        title: "Game length, steps",
        curves: [{ key: "episode_steps", name: "steps" }],
        format: (value) => whole(Math.round(value)),
      },
      {
        title: "Death rate",
        curves: [{ key: "death_rate", name: "share" }],
        format: percentage,
        range: SHARE,
      },
      {
        title: "Agreement with the expert (DAgger)",
        curves: [
          { key: "agreement", name: "most probable action" },
          { key: "expert_share", name: "steps by the expert", dashed: true },
        ],
        format: percentage,
        range: SHARE,
      },
      {
        title: "Discriminator accuracy (GAIL)",
        curves: [{ key: "discriminator_accuracy", name: "share" }],
        format: percentage,
        range: SHARE,
      },
      { title: "Entropy", curves: [{ key: "entropy", name: "entropy" }], format: measured },
      {
        title: "Speed, steps/s",
        curves: [{ key: "steps_per_s", name: "steps/s" }],
        format: (value) => whole(Math.round(value)),
      },
      { title: "Value loss", curves: [{ key: "value_loss", name: "loss" }], format: measured },
      { title: "KL divergence", curves: [{ key: "kl", name: "KL" }], format: measured },
    ],
  },
  {
    stage: "reward",
    name: "Reward model, by updates",
    colour: "var(--ink-2)",
    xLabels: stepLabels,
    charts: [
      { title: "Loss", curves: [{ key: "loss", name: "loss" }], format: measured },
      {
        title: "Pair accuracy",
        curves: [
          { key: "accuracy", name: "fragments" },
          { key: "held_out_accuracy", name: "held-out", dashed: true },
        ],
        format: percentage,
        range: SHARE,
      },
    ],
  },
  {
    stage: "clone",
    name: "Clone, by epochs over the perfect recordings",
    colour: "var(--clone)",
    xLabels: stepLabels,
    charts: [
      { title: "Loss", curves: [{ key: "loss", name: "loss" }], format: measured },
      {
        title: "Action accuracy",
        curves: [
          { key: "accuracy", name: "training" },
          { key: "held_out_accuracy", name: "validation", dashed: true },
        ],
        format: percentage,
        range: SHARE,
      },
    ],
  },
];

/** Returns the groups and charts that have points. */
export function curveGroups(series: Series): readonly CurveGroup[] {
  return PLAN.map(({ stage, name, colour, xLabels, charts }) => ({
    stage,
    name,
    xLabels,
    charts: charts.map((chart) => chartOf(chart, series[stage] ?? {}, colour)).filter(hasPoints),
  })).filter((group) => group.charts.length > 0);
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

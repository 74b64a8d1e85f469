/** Which curves a run's page shows, in groups. */
import { fixed, measured, percent, stepLabels, whole } from "@/lib/format";

import type { Curve, XLabels } from "./Chart";
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

const PLAN: readonly GroupPlan[] = [
  {
    stage: "imitator",
    name: "Imitator, on its training games, by steps played",
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
        title: "Games ended by a bomb",
        curves: [{ key: "death_rate", name: "share" }],
        format: percentage,
        range: SHARE,
      },
      {
        title: "Actions as the expert's (DAgger)",
        curves: [
          { key: "agreement", name: "likeliest action" },
          { key: "expert_share", name: "expert's own steps", dashed: true },
        ],
        format: percentage,
        range: SHARE,
      },
      {
        title: "States put right by the discriminator (GAIL)",
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
        title: "Pairs put right",
        curves: [
          { key: "accuracy", name: "snippets" },
          { key: "held_out_accuracy", name: "left out", dashed: true },
        ],
        format: percentage,
        range: SHARE,
      },
    ],
  },
  {
    stage: "clone",
    name: "Clone, by passes over the perfect recordings",
    colour: "var(--clone)",
    xLabels: stepLabels,
    charts: [
      { title: "Loss", curves: [{ key: "loss", name: "loss" }], format: measured },
      {
        title: "Actions copied",
        curves: [
          { key: "accuracy", name: "learned from" },
          { key: "held_out_accuracy", name: "held out", dashed: true },
        ],
        format: percentage,
        range: SHARE,
      },
    ],
  },
];

/** The groups and charts for which there are points. */
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

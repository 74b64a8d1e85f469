/** The values of the training form and their validation. */

import { t } from "@lingui/core/macro";

import type { Behaviour, Recipe, RunNew } from "@/api/types";
import { decimalSign, thousandsSign, whole } from "@/lib/format";
import { proposedSteps } from "@/lib/runs";

/** As text, so that incomplete numbers stay as typed. */
export interface FormValues {
  readonly recipe: string;
  readonly steps: string;
  readonly learningRate: string;
  readonly trainingSeed: string;
  readonly goOnAnyway: boolean;
  /** Whether only a worker with a GPU may take the run. */
  readonly onGpu: boolean;
}

export interface FormErrors {
  readonly steps?: string;
  readonly learningRate?: string;
  readonly trainingSeed?: string;
}

const MOST_STEPS = 100_000_000;
const MOST_SEED = 2 ** 31 - 1;

/** Returns the values that a recipe proposes for a behaviour. */
export function defaultsOf(recipe: Recipe, behaviour: Pick<Behaviour, "ordered">): FormValues {
  return {
    recipe: recipe.name,
    steps: whole(proposedSteps(recipe, behaviour)),
    learningRate: String(recipe.learning_rate).replace(".", decimalSign()),
    trainingSeed: "0",
    goOnAnyway: false,
    onGpu: false,
  };
}

/** Reads from an address what it fills in: the settings of a run that is made again. */
export function editsFrom(search: URLSearchParams): Partial<FormValues> {
  const steps = search.get("steps");
  const rate = search.get("rate");
  const seed = search.get("seed");
  return {
    ...(steps === null ? {} : { steps: isNaN(readWhole(steps)) ? steps : whole(readWhole(steps)) }),
    ...(rate === null ? {} : { learningRate: rate }),
    ...(seed === null ? {} : { trainingSeed: seed }),
    ...(search.has("anyway") ? { goOnAnyway: true } : {}),
    ...(search.has("gpu") ? { onGpu: true } : {}),
  };
}

/**
 * Parses a whole number with or without the language's separators: "300,000", "300 000", in German
 * "300.000"; NaN if invalid.
 */
export function readWhole(text: string): number {
  const digits = text.replace(/[\s_']/g, "").replaceAll(thousandsSign(), "");
  return /^\d+$/.test(digits) ? Number(digits) : NaN;
}

/** Parses a learning rate with a point or the language's decimal sign; NaN or 0 if invalid. */
function readRate(text: string): number {
  return Number(text.replace(decimalSign(), "."));
}

/** Returns the fields that are invalid, with a message. */
export function errorsIn(values: FormValues): FormErrors {
  const steps = readWhole(values.steps);
  const rate = readRate(values.learningRate);
  const seed = readWhole(values.trainingSeed);
  return {
    ...(steps >= 1 && steps <= MOST_STEPS
      ? {}
      : { steps: t`Enter a whole number of steps from 1 to 100,000,000.` }),
    ...(values.learningRate.trim() && rate > 0 && rate <= 1
      ? {}
      : { learningRate: t`Enter a number above 0 and at most 1, such as 0.0003.` }),
    ...(seed >= 0 && seed <= MOST_SEED
      ? {}
      : { trainingSeed: t`Enter a whole number from 0 to 2,147,483,647.` }),
  };
}

/** Returns the request of a run that continues another or none; null while a field is invalid. */
export function runOf(
  values: FormValues,
  behaviourId: number,
  example: boolean,
  parentId: string | null,
  cancelParent: boolean,
): RunNew | null {
  if (Object.keys(errorsIn(values)).length > 0) return null;
  return {
    behaviour_id: behaviourId,
    recipe: values.recipe,
    steps: readWhole(values.steps),
    learning_rate: readRate(values.learningRate),
    training_seed: readWhole(values.trainingSeed),
    go_on_anyway: values.goOnAnyway,
    device: values.onGpu ? "gpu" : "any",
    example,
    parent_run_id: parentId,
    cancel_parent: cancelParent,
  };
}

/** Objects as the API returns them, with overrides. */
import type {
  Behaviour,
  EvaluationGame,
  Ranking,
  Recipe,
  Recording,
  Run,
  RunResults,
  System,
  UnderstoodStatement,
} from "@/api/types";

export function behaviour(change: Partial<Behaviour> = {}): Behaviour {
  return {
    id: 1,
    slug: "column-1",
    name: "Column 1",
    description: "Shoot the leftmost column.",
    game: "space_invaders",
    settings: { options: {} },
    measures: [],
    target: [
      [0, 0],
      [1, 0],
    ],
    ordered: false,
    built_in: true,
    n_recordings: 0,
    n_ranked: 0,
    n_perfect: 0,
    n_runs: 0,
    has_example: false,
    ...change,
  };
}

export function recording(change: Partial<Recording> = {}): Recording {
  const id = change.id ?? 1;
  return {
    id,
    number: id,
    behaviour_id: 1,
    behaviour_name: "Column 1",
    borrowed: false,
    run_id: null,
    source: "person",
    player: "Ada",
    state: "kept",
    verification: "verified",
    verification_note: "",
    game: "space_invaders",
    start: { idle_frames: 40, mode: 0, difficulty: 0 },
    evaluation_start: null,
    n_frames: 1200,
    n_steps: 300,
    end: "steps",
    hits: [{ row: 0, column: 0, frame: 120, on_target: true }],
    hits_per_column: [1, 0, 0, 0, 0, 0],
    targets: 1,
    strays: 0,
    order_errors: null,
    counters: { shots: 4 },
    score: 60,
    measured: [],
    latency: null,
    slowest_percent: null,
    single_steps: null,
    parent: null,
    begun_by: null,
    perfect: false,
    notes: "",
    ranked: false,
    strip_url: `/api/recordings/${id}/strip.webp?v=1`,
    frames_url: `/api/recordings/${id}/frames?v=1`,
    created_at: "2026-01-01T12:00:00Z",
    deleted: false,
    ...change,
  };
}

export function ranking(change: Partial<Ranking> = {}): Ranking {
  return {
    behaviour_id: 1,
    revision: 1,
    tiers: [],
    n_pairs: 0,
    can_undo: false,
    can_redo: false,
    ...change,
  };
}

export const STAGES: Run["stages"] = [
  { name: "trajectories", label: "Replay", summary: "Recordings are replayed." },
  { name: "reward", label: "Reward model", summary: "A network learns the order." },
  { name: "check", label: "Check", summary: "Does it agree with the ranking?" },
  { name: "clone", label: "Clone", summary: "A baseline copies perfect games." },
  { name: "imitator", label: "Imitator", summary: "An agent plays for the reward." },
  { name: "evaluation", label: "Evaluation", summary: "Both play." },
  { name: "attention", label: "Attention", summary: "Where does the reward look?" },
];

export function recipe(change: Partial<Recipe> = {}): Recipe {
  return {
    name: "fast",
    summary: "Minutes on a laptop.",
    default_steps: 300_000,
    ordered_steps: 1_800_000,
    warm_up_steps: 12_000,
    learning_rate: 0.0003,
    values: { name: "fast", reward: { updates: 200 }, policy: { n_envs: 24 } },
    steps_per_s: 500,
    steps_per_s_measured: false,
    overhead_s: 120,
    stages: STAGES,
    ...change,
  };
}

export function run(change: Partial<Run> = {}): Run {
  return {
    id: "3f2a9c00-0000-4000-8000-000000000000",
    name: "",
    notes: "",
    behaviour_id: 1,
    behaviour_name: "Column 1",
    parent_run_id: null,
    example: false,
    imported: false,
    recipe: "fast",
    recipe_values: {},
    steps: 20_000,
    training_seed: 0,
    learning_rate: 0.0003,
    go_on_anyway: false,
    device: "any",
    ranking_revision: 3,
    n_ranked: 12,
    n_perfect: 3,
    status: "running",
    queue_position: null,
    stages: STAGES,
    stage: "imitator",
    stage_progress: 0.5,
    progress: 0.6,
    remaining_s: 90,
    message: "",
    worker_alive: true,
    versions: { tril: "0.1.0" },
    headline: null,
    created_at: "2026-01-01T12:00:00Z",
    started_at: "2026-01-01T12:00:01Z",
    finished_at: null,
    ...change,
  };
}

/** The figures of a run for the lists. */
export function headline(
  change: Partial<NonNullable<Run["headline"]>> = {},
): NonNullable<Run["headline"]> {
  return {
    tau: 1,
    pair_accuracy: 1,
    held_out_accuracy: null,
    imitator: null,
    clone: null,
    understood: null,
    elsewhere: null,
    ...change,
  };
}

export function game(change: Partial<EvaluationGame> = {}): EvaluationGame {
  return {
    policy: "imitator",
    action_selection: "greedy",
    start_number: 0,
    held_out: true,
    predicted_return: 1,
    recording: recording({ source: "policy" }),
    ...change,
  };
}

export function results(one: Run, change: Partial<RunResults> = {}): RunResults {
  return {
    run: one,
    verdict: null,
    check: null,
    comparison: [],
    further_comparison: [],
    games: [],
    proposed: [],
    shown_game: null,
    training_games: null,
    summaries: [],
    measures: [],
    blind: null,
    best_demonstration: null,
    alarm: null,
    judged: [],
    attention: [],
    percentiles: [],
    artifacts: [],
    ...change,
  };
}

export function system(workerAlive: boolean): System {
  return {
    version: "0.1.0",
    processes: [
      {
        name: "w1",
        kind: "worker",
        alive: workerAlive,
        busy: false,
        details: {},
        host: "lab-3",
        cores: 8,
        gpu: null,
      },
    ],
    disk_free_bytes: 1e9,
    data_bytes: 1e6,
    storage: {
      databases_bytes: 2e5,
      artifacts_bytes: 5e5,
      cache_bytes: 3e5,
      cache_limit_bytes: 5e8,
      other_bytes: 0,
    },
    has_example: false,
  };
}

/** A statement that nothing is shown of. */
export function statement(
  sentence: string,
  probability: number,
  change: Partial<UnderstoodStatement> = {},
): UnderstoodStatement {
  return {
    sentence,
    probability,
    subjects: [],
    kinds: [],
    detail: "",
    shown: null,
    contrast: null,
    pictures: [],
    ...change,
  };
}

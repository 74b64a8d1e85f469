"""What goes over HTTP. The frontend's types are generated from these."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StrictBool

Row = Annotated[int, Field(strict=True, ge=0, le=5)]
Column = Annotated[int, Field(strict=True, ge=0, le=5)]
Cell = tuple[Row, Column]
"""(row from the bottom, column from the left), from 0."""

Id = Annotated[int, Field(strict=True, ge=1, le=2**31 - 1)]
Tiers = Annotated[
    list[Annotated[list[Id], Field(min_length=1, max_length=500)]], Field(max_length=500)
]


class Schema(BaseModel):
    """Base: unknown fields are refused, rows can be read by attribute."""

    model_config = ConfigDict(extra="forbid", from_attributes=True)


class Health(Schema):
    """The server answers."""

    status: Literal["ok"]


class Player(Schema):
    """Who plays."""

    id: int
    name: str
    role: Literal["owner", "researcher", "participant"]


class PlayerUpdate(Schema):
    """A player's new name."""

    name: str = Field(min_length=1, max_length=80)


class ProcessStatus(Schema):
    """``alive`` is false when nothing was heard for 15 s."""

    name: str
    kind: Literal["server", "worker", "inference"]
    alive: bool
    details: dict[str, Any]


class System(Schema):
    """Whether Tril is well."""

    version: str
    processes: list[ProcessStatus]
    disk_free_bytes: int
    data_bytes: int


class Behaviour(Schema):
    """What is being taught. ``target`` is None where hits do not describe it."""

    id: int
    slug: str
    name: str
    description: str
    target: list[Cell] | None
    ordered: bool
    ready_made: bool
    n_recordings: int
    n_ranked: int
    n_perfect: int
    n_runs: int
    has_example: bool


class BehaviourNew(Schema):
    """A behaviour of one's own."""

    name: str = Field(min_length=1, max_length=120)
    description: str = Field(default="", max_length=2000)
    target: list[Cell] | None = Field(default=None, max_length=36)
    ordered: StrictBool = False


class BehaviourUpdate(Schema):
    """Fields left out stay. A target can't change once runs exist (409)."""

    name: str | None = Field(default=None, min_length=1, max_length=120)
    description: str | None = Field(default=None, max_length=2000)
    target: list[Cell] | None = Field(default=None, max_length=36)
    ordered: StrictBool | None = None


class Hit(Schema):
    """An alien that was shot, after how many frames."""

    row: Row
    column: Column
    frame: int
    on_target: bool | None


class Recording(Schema):
    """``targets``, ``strays``, ``order_errors`` are None for behaviours without a target.

    ``frames_url`` and ``thumbnail_url`` carry a version so that they may be cached for ever.
    """

    id: int
    behaviour_id: int
    run_id: str | None
    source: Literal["person", "scripted", "policy"]
    player: str | None
    state: Literal["playing", "unfinished", "finished", "kept"]
    verification: Literal["pending", "verified", "failed"]
    verification_note: str
    idle_frames: int
    evaluation_start: int | None
    n_frames: int
    n_steps: int
    end: str | None
    hits: list[Hit]
    hits_per_column: list[int]
    targets: int | None
    strays: int | None
    order_errors: int | None
    shots: int
    perfect: bool
    notes: str
    ranked: bool
    thumbnail_url: str
    frames_url: str
    created_at: datetime
    deleted: bool


class RecordingUpdate(Schema):
    """Fields left out stay."""

    perfect: StrictBool | None = None
    notes: str | None = Field(default=None, max_length=4000)


class Refusal(Schema):
    """``line`` counts from 1 in the uploaded file."""

    line: int
    reason: str


class ImportResult(Schema):
    """What became of an uploaded file; ``imported`` are the new recordings."""

    imported: list[int]
    notices: list[Refusal]
    refusals: list[Refusal]


class Ranking(Schema):
    """``tiers`` best first; ``unranked`` the kept, verified recordings in no tier, newest first."""

    behaviour_id: int
    revision: int
    tiers: list[list[int]]
    unranked: list[int]
    n_pairs: int
    can_undo: bool
    can_redo: bool


class RankingUpdate(Schema):
    """``base_revision`` is the revision that was changed; an old one gives 409 RankingConflict."""

    base_revision: int = Field(strict=True, ge=0, le=2**31 - 1)
    tiers: Tiers


class RankingStep(Schema):
    """Undo or redo from this revision."""

    base_revision: int = Field(strict=True, ge=0, le=2**31 - 1)


class RankingConflict(Schema):
    """Somebody saved first: ``current`` is what stands, ``yours`` what was sent."""

    detail: str
    current: Ranking
    yours: list[list[int]]


class RankingRevision(Schema):
    """What was done to a ranking."""

    revision: int
    tiers: list[list[int]]
    change: Literal["edit", "undo", "redo", "import", "deletion", "example"]
    player: str | None
    created_at: datetime


class GameNew(Schema):
    """``idle_frames`` None draws a start for play."""

    behaviour_id: Id
    idle_frames: int | None = Field(default=None, strict=True, ge=0, le=127)


class Game(Schema):
    """``stream_path`` is the WebSocket's path (docs/protocol.md)."""

    id: str
    recording_id: int
    behaviour_id: int
    frame: int
    max_frames: int
    stream_path: str


class Recipe(Schema):
    """A way of learning; ``values`` is all of it.

    ``steps_per_s`` and ``overhead_s`` are what this machine did or is expected to do.
    """

    name: str
    summary: str
    default_steps: int
    learning_rate: float
    values: dict[str, Any]
    steps_per_s: float
    steps_per_s_measured: bool
    overhead_s: float


class RunNew(Schema):
    """``example`` makes and ranks the scripted demonstrations first where they are missing."""

    behaviour_id: Id
    recipe: str = "fast"
    steps: int = Field(default=300_000, strict=True, ge=1, le=100_000_000)
    learning_rate: float | None = Field(default=None, strict=True, gt=0, le=1)
    training_seed: int = Field(default=0, strict=True, ge=0, le=2**31 - 1)
    go_on_anyway: StrictBool = False
    example: StrictBool = False


RunStatus = Literal["queued", "running", "cancelling", "cancelled", "stopped", "failed", "done"]


class Run(Schema):
    """One training. ``progress`` is over the whole run, 0..1; ``stages`` all stages in order."""

    id: str
    behaviour_id: int
    behaviour_name: str
    example: bool
    recipe: str
    recipe_values: dict[str, Any]
    steps: int
    training_seed: int
    learning_rate: float
    go_on_anyway: bool
    ranking_revision: int | None
    n_ranked: int | None
    n_perfect: int | None
    status: RunStatus
    stages: list[str]
    stage: str
    stage_progress: float
    progress: float
    remaining_s: float | None
    message: str
    worker_alive: bool
    versions: dict[str, str]
    headline: Headline | None
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None


class Headline(Schema):
    """Greedy games from held-out evaluation starts: means with 95% bootstrap intervals."""

    imitator: PolicySummary | None
    clone: PolicySummary | None
    tau: float | None
    pair_accuracy: float | None
    held_out_accuracy: float | None


class Interval(Schema):
    """A mean over n games with its 95% interval."""

    mean: float
    low: float
    high: float
    n: int


class PolicySummary(Schema):
    """None where the behaviour has no target."""

    targets: Interval | None
    strays: Interval | None
    order_errors: Interval | None
    steps: Interval
    hit_share: Interval
    predicted_return: Interval | None


class Metrics(Schema):
    """Points after ``after``; each series is [[step, value], ...]. Pass ``last`` as next after."""

    last: int
    series: dict[str, dict[str, list[tuple[int, float]]]]


class ConfusedTiers(Schema):
    """Tiers counted from 1, best first, whose demonstrations the reward model mixes up.

    ``held_out`` says that they were mixed up when one of the demonstrations was left out of the
    learning; ``better`` and ``worse`` are the recordings of the two tiers.
    """

    better_tier: int
    worse_tier: int
    held_out: bool
    better: list[int]
    worse: list[int]


class RankedReturn(Schema):
    """A demonstration's predicted return (sum of R over its observations) by its tier, from 1."""

    tier: int
    recording: Recording
    predicted_return: float


class RankingCheck(Schema):
    """How well the reward model agrees with the ranking; ``advice`` is empty if it passed."""

    tau: float
    pair_accuracy: float
    held_out_accuracy: float | None
    passed: bool
    advice: str
    confused: list[ConfusedTiers]
    returns: list[RankedReturn]


class AttentionMap(Schema):
    """Attention of the reward model at one state; pictures are PNG artifacts."""

    state: Literal["minimum", "90th percentile", "95th percentile", "maximum"]
    reward: float
    recording_id: int
    step: int
    frame_url: str
    map_url: str
    red_blue_url: str


class EvaluationGame(Schema):
    """One game that a trained policy played."""

    policy: Literal["imitator", "clone"]
    choice: Literal["greedy", "sampled"]
    start_number: int
    held_out: bool
    predicted_return: float | None
    recording: Recording


class ComparisonRow(Schema):
    """One start of the thesis' table: who hit what, and who won."""

    start_number: int
    held_out: bool
    imitator: EvaluationGame | None
    clone: EvaluationGame | None
    winner: Literal["imitator", "clone", "tie"] | None


class PolicyChoiceSummary(Schema):
    """Means over a policy's games from held-out starts."""

    policy: Literal["imitator", "clone"]
    choice: Literal["greedy", "sampled"]
    summary: PolicySummary


class RunResults(Schema):
    """Everything the results page shows; parts that are not there yet are None or empty."""

    run: Run
    check: RankingCheck | None
    comparison: list[ComparisonRow]
    games: list[EvaluationGame]
    summaries: list[PolicyChoiceSummary]
    best_demonstration: Recording | None
    attention: list[AttentionMap]
    artifacts: list[Artifact]


class Artifact(Schema):
    """A file of a training."""

    id: int
    kind: str
    name: str
    media_type: str
    size_bytes: int
    url: str


class RewardTrace(Schema):
    """R (raw output) of every observation of a recording, by step, from the start's."""

    run_id: str
    recording_id: int
    rewards: list[float]


Run.model_rebuild()
Headline.model_rebuild()
RunResults.model_rebuild()

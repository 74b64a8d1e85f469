"""Trainings and their results."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Literal
from uuid import UUID

from pydantic import Field, StrictBool

from server.api.schemas.base import Id, Schema
from server.api.schemas.measures import MeasureRow
from server.api.schemas.rankings import UnderstoodStatement
from server.api.schemas.recordings import Recording
from tril.analysis.blind import BlindResult
from tril.analysis.extrapolation import JudgedGame, Measure, PlayerKind
from tril.analysis.outcome import AttentionDetails, CheckVerdict, Headline, RewardState
from tril.analysis.summary import Policy, PolicySummary, Winner
from tril.analysis.verdict import NextStep, Tone
from tril.stages import Stage
from tril.store.models import RunDevice, RunStatus
from tril.store.training.evaluations import ActionSelection
from tril.store.training.runs import MAX_NAME_LENGTH, MAX_NOTES_LENGTH
from tril.text import Line, Lines


class RunStage(Schema):
    """A stage of a run, with its label and summary on the page."""

    name: Stage
    label: str
    summary: str


class Recipe(Schema):
    """A learning recipe; ``values`` are its hyperparameters, ``stages`` the stages of its runs.

    ``ordered_steps`` are proposed where targets have an order, else ``default_steps``.
    ``steps_per_s`` and ``overhead_s`` are measured on this machine or expected of it. A training of
    ``warm_up_steps`` or fewer learns nothing.
    """

    name: str
    summary: str
    default_steps: int
    ordered_steps: int
    warm_up_steps: int
    learning_rate: float
    values: dict[str, Any]
    stages: list[RunStage]
    steps_per_s: float
    steps_per_s_measured: bool
    overhead_s: float


class RunNew(Schema):
    """A training to start. ``example`` first makes and ranks missing scripted demonstrations.

    ``steps`` defaults to what the recipe proposes for the behaviour. With ``parent_run_id``, PPO
    begins with the imitator of that training in place of the clone; with ``cancel_parent``, that
    training is cancelled if it is not over.
    """

    behaviour_id: Id
    recipe: Line = "fast"
    steps: int | None = Field(default=None, strict=True, ge=1, le=100_000_000)
    learning_rate: float | None = Field(default=None, strict=True, gt=0, le=1)
    training_seed: int = Field(default=0, strict=True, ge=0, le=2**31 - 1)
    go_on_anyway: StrictBool = False
    example: StrictBool = False
    device: RunDevice = RunDevice.ANY
    parent_run_id: UUID | None = None
    cancel_parent: StrictBool = False


class RunUpdate(Schema):
    """Omitted fields stay; an empty text removes what was there."""

    name: Line | None = Field(default=None, max_length=MAX_NAME_LENGTH)
    notes: Lines | None = Field(default=None, max_length=MAX_NOTES_LENGTH)


class Run(Schema):
    """A training. ``progress`` is that of the whole run, 0..1; ``stages`` are in order.

    ``imported``: it was trained elsewhere, such as the example that ships with Tril.
    ``name`` and ``notes`` are empty unless a person has written them. ``queue_position`` is 1 for
    the run that is trained next, None for one that doesn't wait.
    """

    id: str
    name: str
    notes: str
    behaviour_id: int
    behaviour_name: str
    parent_run_id: str | None
    example: bool
    imported: bool
    recipe: str
    recipe_values: dict[str, Any]
    steps: int
    training_seed: int
    learning_rate: float
    go_on_anyway: bool
    device: RunDevice
    ranking_revision: int | None
    n_ranked: int | None
    n_perfect: int | None
    status: RunStatus
    queue_position: int | None
    stages: list[RunStage]
    stage: Stage | Literal[""]
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


class Metrics(Schema):
    """Curves, each [[step, value], ...]. Pass ``last`` as ``after`` to get newer points."""

    last: int
    series: dict[str, dict[str, list[tuple[int, float]]]]


class ConfusedTiers(Schema):
    """Two tiers, counted from 1, best first, whose demonstrations the reward model confuses.

    ``held_out``: it confuses them when one of the demonstrations is held out of learning.
    ``better`` and ``worse`` are the recordings of the two tiers. ``n_right`` of ``n_compared``
    comparisons were right; None in runs of earlier versions.
    """

    better_tier: int
    worse_tier: int
    held_out: bool
    better: list[int]
    worse: list[int]
    n_right: int | None
    n_compared: int | None


class RankedReturn(Schema):
    """What the reward model says of a demonstration, by its tier, from 1.

    ``predicted_return`` is the sum of R over its observations, ``final_level`` the mean level of
    the last 25, which the ranking is checked by; None in runs of versions up to 0.2.0.
    """

    tier: int
    recording: Recording
    predicted_return: float
    final_level: float | None


class RankingCheck(CheckVerdict):
    """How well the reward model agrees with the ranking, with the recordings concerned."""

    statements: list[UnderstoodStatement]
    confused: list[ConfusedTiers]
    returns: list[RankedReturn]


class AttentionMap(AttentionDetails):
    """Attention of the reward model at one state; pictures are PNG artifacts."""

    frame_url: str
    map_url: str
    red_blue_url: str


class EvaluationGame(Schema):
    """An evaluation game of a trained policy.

    ``action_selection``: "greedy" takes the most probable action, "sampled" draws from the policy,
    "sticky" is greedy with the last action repeated with probability 0.25 at every frame.
    """

    policy: Policy
    action_selection: ActionSelection
    start_number: int
    held_out: bool
    predicted_return: float | None
    recording: Recording


class ComparisonRow(Schema):
    """A row of the thesis' table: both policies' greedy games from a start, and the winner."""

    start_number: int
    held_out: bool
    imitator: EvaluationGame | None
    clone: EvaluationGame | None
    winner: Winner | None


class PolicyGamesSummary(Schema):
    """Means over a policy's games from held-out starts."""

    policy: Policy
    action_selection: ActionSelection
    summary: PolicySummary


class JudgedGames(Schema):
    """The games of a player: demonstrations, or games that the reward model has not seen.

    ``measure`` tells what of R each game's ``predicted`` is, the same for all games of a training;
    "predicted_return" in trainings of earlier versions. ``tau`` is Kendall's tau between true
    quantity and ``predicted``; None if all true quantities are equal.
    """

    player: PlayerKind
    demonstrated: bool
    measure: Measure
    games: list[JudgedGame]
    tau: float | None


class RewardAlarm(Schema):
    """The predicted return of training games rose, but the games did not improve.

    ``message`` says what this means and what to do.
    """

    from_step: int
    to_step: int
    message: str


class Verdict(Schema):
    """What came of a training, in words, and where to take the next step, if it is on a page.

    ``details`` are the figures behind the sentence; empty if there are none.
    """

    tone: Tone
    sentence: str
    details: str
    advice: str
    next_step: NextStep | None


class TrainingGames(Schema):
    """Greedy games from training starts that an imitator played after so many training steps."""

    steps: int
    games: list[Recording]


class RunResults(Schema):
    """All results of a training; parts that are missing yet are None or empty.

    ``verdict`` is None until the training is over.

    ``comparison`` has the starts of the headline figures, ``further_comparison`` the others.
    ``percentiles`` are the states of the ranked recordings at the percentiles 0, 1, ..., 100 of R;
    empty for runs of earlier versions. ``proposed`` are the recordings of the imitator's games that
    are proposed for the ranking. ``shown_game`` is the recording of the imitator's game that is
    shown beside the best demonstration. ``training_games`` are those of its newest snapshot.
    ``blind`` is the result of each person's latest blind comparison.
    """

    run: Run
    verdict: Verdict | None
    check: RankingCheck | None
    comparison: list[ComparisonRow]
    further_comparison: list[ComparisonRow]
    games: list[EvaluationGame]
    proposed: list[int]
    shown_game: int | None
    training_games: TrainingGames | None
    summaries: list[PolicyGamesSummary]
    measures: list[MeasureRow]
    blind: BlindResult | None
    best_demonstration: Recording | None
    alarm: RewardAlarm | None
    judged: list[JudgedGames]
    attention: list[AttentionMap]
    percentiles: list[RewardState]
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
    """R (raw output) of every observation of a recording, by step, beginning with the start.

    ``levels`` are R scaled: 0 is ``zero_level_reward``, how demonstrations begin, and 1 is
    ``unit_level_reward``, how the best ones end. The deviations are the standard deviations of
    both, null if the reward model does not know them.
    """

    run_id: str
    recording_id: int
    rewards: list[float]
    levels: list[float]
    zero_level_reward: float
    unit_level_reward: float
    reward_deviations: list[float] | None
    level_deviations: list[float] | None


RunResults.model_rebuild()

"""What a run learns from and what came out of its stages, as its row stores them.

Members that earlier versions of Tril did not store have defaults.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import StrEnum
from typing import Self

from pydantic import BaseModel, ConfigDict

from tril.analysis.summary import Interval, PolicySummary


class Stored(BaseModel):
    """Base of what is stored as JSON; members of other versions are ignored."""

    model_config = ConfigDict(frozen=True, json_schema_serialization_defaults_required=True)


class StatementAnswer(Stored):
    """What a person said of a statement that Tril made about a ranking.

    Attributes:
        subjects: Subjects of the statement, in order, see tril.vocabulary.answers.
        sentence: Sentence shown to the person.
        meant: Whether it is what they mean; else it is not.
    """

    subjects: list[str]
    sentence: str
    meant: bool


class RunSnapshot(Stored):
    """The ranking and the perfect demonstrations that a run learns from, frozen.

    Attributes:
        ranking_revision: The behaviour's ranking; None where the tiers are an example's own.
        tiers: Ids of the ranked recordings, best tier first.
        perfect: Ids of the recordings that the clone learns from.
        none_marked: Whether none is marked as perfect, so that these are the best ranked ones.
        answers: Answers about statements on the ranking, the latest last.
    """

    ranking_revision: int | None = None
    tiers: list[list[int]]
    perfect: list[int]
    none_marked: bool = False
    answers: list[StatementAnswer] = []

    @property
    def ranked(self) -> list[int]:
        """The ranked recordings, best first."""
        return [number for tier in self.tiers for number in tier]

    @property
    def recordings(self) -> list[int]:
        """All recordings that the run learns from; a perfect one that is ranked stands twice."""
        return [*self.ranked, *self.perfect]


class CheckFigures(Stored):
    """How well the reward model agrees with the ranking.

    Attributes:
        tau: Kendall's tau-b between the tiers and the final levels, -1 to 1; in runs of versions
            up to 0.2.0 between the tiers and the predicted returns.
        pair_accuracy: Share of newly drawn fragment pairs ordered as ranked.
        held_out_accuracy: Share of preference pairs ordered as ranked by models trained without
            at least one of the two demonstrations; None where that was not measured.
    """

    tau: float
    pair_accuracy: float
    held_out_accuracy: float | None

    @property
    def figures(self) -> dict[str, float | None]:
        """These three by name."""
        return self.model_dump(include=set(CheckFigures.model_fields))


class WantedAliens(Stored):
    """Which aliens of the 6x6 grid a reward model infers to be wanted.

    The lists have 36 members, row by row from the lowest, each row from the left.

    Attributes:
        labels: 1 for a wanted alien, -1 for one to be left alone, and in between where that is
            not sure.
        in_order: How surely an alien counts only once all on its left in its row are gone, 0 to 1.
    """

    labels: list[float]
    in_order: list[float]

    @classmethod
    def of(cls, labels: Iterable[float], in_order: Iterable[float]) -> Self:
        """Return them rounded to three digits."""
        rounded = [[round(value, 3) for value in values] for values in (labels, in_order)]
        return cls(labels=rounded[0], in_order=rounded[1])


class ShownMoment(Stored):
    """A few seconds of a recording.

    Attributes:
        recording_id: The recording.
        first_frame: The frame that it begins with.
        n_frames: Its length.
    """

    recording_id: int
    first_frame: int
    n_frames: int


class ToldStatement(Stored):
    """What an order is about, in words.

    Attributes:
        sentence: E.g. "what you steer further to the left".
        probability: Probability of the statement, 0 to 1.
        subjects: What it is about, in order, see tril.vocabulary.answers; empty in runs that
            earlier versions made.
        shown: A moment of a better game in which it holds most; None where nothing differs.
        contrast: A moment of a worse game in which it holds least.
        kinds: Kinds of things that it is about, by their indices in the game's vocabulary as it was
            then; empty in runs of earlier versions.
        detail: Bytes of memory that it was read from, for experts; empty if from none.
    """

    sentence: str
    probability: float
    subjects: list[str] = []
    shown: ShownMoment | None = None
    contrast: ShownMoment | None = None
    kinds: list[int] = []
    detail: str = ""


class CheckVerdict(CheckFigures):
    """Whether the reward model has understood the ranking.

    Attributes:
        advice: Advice for the person; empty if the check passed.
        warning: Names tiers that can't be told apart although it passed, if any.
        wanted: Which aliens it infers to be wanted; None of rewards that are learned otherwise.
        statements: What the order is about in words, the most probable first; empty of rewards
            that are learned otherwise.
        answers: What people had said of such statements, by which these were inferred.
    """

    passed: bool
    advice: str
    warning: str = ""
    wanted: WantedAliens | None = None
    statements: Sequence[ToldStatement] = ()
    answers: list[StatementAnswer] = []


class ConfusedTiers(Stored):
    """Two tiers, counted from 1 for the best, with demonstrations that the model mixes up.

    Attributes:
        held_out: Whether the order was wrong when one of the two demonstrations was held out;
            otherwise the final levels of the final model contradict it.
        n_right: Comparisons of their demonstrations in order; None in runs of earlier versions.
        n_compared: All comparisons of their demonstrations; None in runs of earlier versions.
    """

    better: int
    worse: int
    held_out: bool
    n_right: int | None = None
    n_compared: int | None = None


class CheckOutcome(CheckVerdict):
    """What the stage "check" found.

    Attributes:
        confused: Worst first.
        predicted_returns: Sum of R over the states after each step, by recording id.
        final_levels: Mean level of the last 25 states, by recording id; empty in runs of versions
            up to 0.2.0.
    """

    confused: list[ConfusedTiers]
    predicted_returns: dict[int, float]
    final_levels: dict[int, float] = {}


class ImitatorOutcome(Stored):
    """How the imitator was trained.

    Attributes:
        best_steps: Training steps of the snapshot that was kept.
        precision: Floating-point type that it learned in; None in runs of earlier versions.
        device: Type of the device that it learned on; None in runs of earlier versions.
    """

    best_steps: int | None = None
    precision: str | None = None
    device: str | None = None


class ExampleOutcome(Stored):
    """The order that an example's demonstrations should have and the one that they are given.

    Attributes:
        kind: Name of their kind, see tril.demonstrators.KINDS.
        mistakes: Pairs [better, worse] that are ranked the other way round.
        tau: Kendall's tau-b between the two orders.
    """

    kind: str
    true_tiers: list[list[int]]
    given_tiers: list[list[int]]
    mistakes: list[list[int]]
    tau: float


class UnderstoodShares(Stored):
    """How much games show of what Tril understood of a ranking, by the facts of their replays.

    1 is a whole game in which every step is as good as the best demonstrations' steps are on
    average while they last. A game that ends early earns nothing for the rest of its time.

    Attributes:
        imitator: The imitator's games, those of the headline; None if it has played none.
        clone: The clone's.
        best: The perfect demonstrations, or the best ranked ones that stand in for them.
        read: The imitator's games by the network that it has learned from, which reads these facts
            off the screen, compared with its reading of the best ones. None if the imitator has
            played none, or these read as nothing. Runs of earlier versions have no figure of it,
            and those above are by the network.
    """

    imitator: Interval | None
    clone: Interval | None
    best: Interval
    read: Interval | None = None


class ElsewhereShares(Stored):
    """Share of the time for which games have things elsewhere than the best demonstrations.

    While both last, second by second, see tril.vocabulary.whereabouts; of each game the mean over
    the best ones. Openings of evaluation games are left out.

    Attributes:
        imitator: Up to eight of the imitator's games, those of the headline; None if it has played
            none.
        clone: As many of the clone's.
        best: Best demonstrations compared with each other; None if there is only one.
    """

    imitator: Interval | None
    clone: Interval | None
    best: Interval | None


class Headline(CheckFigures):
    """A run's figures for the lists: greedy games from held-out evaluation starts.

    ``understood`` and ``elsewhere`` are None for rewards that are not statements, and in runs of
    earlier versions; ``understood`` also where the best demonstrations are worth no more than a
    game that is over, ``elsewhere`` where nothing on the screen has a place.
    """

    imitator: PolicySummary | None
    clone: PolicySummary | None
    understood: UnderstoodShares | None = None
    elsewhere: ElsewhereShares | None = None


class RunOutcome(Stored):
    """What came out of a run's stages so far; None where a stage has nothing to say yet."""

    example: ExampleOutcome | None = None
    check: CheckOutcome | None = None
    imitator: ImitatorOutcome | None = None
    headline: Headline | None = None

    def updated_with(self, outcome: RunOutcome) -> RunOutcome:
        """Return this outcome with the fields that another stage has set."""
        return self.model_copy(
            update={name: getattr(outcome, name) for name in outcome.model_fields_set}
        )


class AttentionState(StrEnum):
    """A state of the demonstrations that an attention map is drawn of (thesis, section 6.1)."""

    MINIMUM = "minimum"
    PERCENTILE_90 = "90th percentile"
    PERCENTILE_95 = "95th percentile"
    MAXIMUM = "maximum"

    @property
    def quantile(self) -> float:
        """The place, 0 to 1, of its reward among those of all states."""
        places = dict(zip(AttentionState, (0.0, 0.9, 0.95, 1.0), strict=True))
        return places[self]


class RewardState(Stored):
    """A state of a demonstration.

    Attributes:
        reward: R of the state.
        recording_id: The demonstration that it is from.
        step: The step after which it stands.
    """

    reward: float
    recording_id: int
    step: int


class RewardPercentiles(Stored):
    """The states of the demonstrations at percentiles of R, as their artifact stores them.

    Attributes:
        states: At the percentiles 0, 1, ..., 100.
    """

    states: list[RewardState]


class MeasuredOrder(Stored):
    """What happens to R while pixels are hidden or shown in an order.

    In levels: 1 is the change from how demonstrations begin to how the best ones end. See
    trainer.explain.faithfulness.

    Attributes:
        deletion: Mean change while pixels are hidden; large if the important ones come first.
        insertion: Mean change that is left while they are put into an empty screen; small then.
        hidden_fifth: Change when the first fifth is hidden.
    """

    deletion: float
    insertion: float
    hidden_fifth: float


class Faithfulness(Stored):
    """How faithful an attention map is: its order of pixels, and the mean of random ones."""

    map: MeasuredOrder
    random: MeasuredOrder


class AttentionDetails(RewardState):
    """What the pictures of an attention map show, as their artifacts store it.

    ``faithfulness`` is None where it was not measured, as in runs of earlier versions.
    """

    state: AttentionState
    faithfulness: Faithfulness | None = None

"""The few figures that a share page has, those of the page of a run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from trainer.sharing.words import measure_title, measure_value
from tril.analysis.blind import BlindResult
from tril.analysis.outcome import ElsewhereShares, UnderstoodShares
from tril.analysis.summary import Interval, PolicySummary
from tril.games.base import Game
from tril.games.behaviours import Behaviour
from tril.games.measuring import mean_of, measured_before
from tril.store.models import EvaluationRow, RecordingRow, RunRow, Source
from tril.store.training import evaluations

MOST = 5


@dataclass(frozen=True)
class OtherPlayer:
    """The value of a figure for another player.

    Attributes:
        actor: The player, a key of ``reporting.figures.COLOURS``.
        text: The value.
        interval: Its interval, where it is known.
    """

    actor: str
    text: str
    interval: Interval | None = None


@dataclass(frozen=True)
class Figure:
    """A figure of a run's imitator.

    Attributes:
        name: Name of the figure.
        value: Value for the imitator.
        others: Values for other players.
        interval: The imitator's interval; None without a picture.
        low: Lower bound of the picture's axis.
        high: Upper bound of the picture's axis.
    """

    name: str
    value: str
    others: tuple[OtherPlayer, ...] = ()
    interval: Interval | None = None
    low: float = 0.0
    high: float = 1.0

    def intervals(self) -> list[tuple[str, Interval]]:
        """Return the intervals of the picture with whose they are."""
        pairs = [
            ("imitator", self.interval),
            *((other.actor, other.interval) for other in self.others),
        ]
        return [(actor, interval) for actor, interval in pairs if interval is not None]

    def at(self, value: float) -> float:
        """Return the place of a value on the axis, in percent."""
        share = (value - self.low) / ((self.high - self.low) or 1.0)
        return round(min(max(100 * share, 0.0), 100.0), 2)


def figures_of(
    run: RunRow,
    behaviour: Behaviour,
    game: Game,
    games: Sequence[EvaluationRow],
    demonstrations: Sequence[RecordingRow],
    blind: BlindResult | None,
) -> list[Figure]:
    """Return at most five figures of a run, what the behaviour asks for first.

    A blind comparison comes first where nothing measures the behaviour, else second.

    Args:
        run: The run.
        behaviour: Its behaviour.
        game: The game as the behaviour sets it.
        games: The run's evaluation games, loaded with their recordings.
        demonstrations: Its ranked games.
        blind: Result of its blind comparisons, if there are any.
    """
    n_targets = None if behaviour.target is None else len(behaviour.target)
    summary = list(_summary(evaluations.summaries(games, n_targets), behaviour, game))
    measures = list(_measures(behaviour, game, games, demonstrations))
    figures = [*summary, *measures]
    if behaviour.target is None:
        shares = run.outcome.headline
        figures = [
            *measures,
            *_shares_of_games(
                "Worth by what Tril understood (100%: a full game)",
                shares.understood if shares else None,
            ),
            *summary,
            *_shares_of_games(
                "Time spent elsewhere than the best games, while they last",
                shares.elsewhere if shares else None,
            ),
        ]
    if blind is not None:
        figures.insert(1 if behaviour.target or measures else 0, _blind(blind))
    if (check := run.outcome.check) is not None:
        figures.append(Figure("Agreement of R with the ranking, 1 at most", f"{check.tau:.2f}"))
    return figures[:MOST]


def _blind(blind: BlindResult) -> Figure:
    others = tuple(
        OtherPlayer(score.opponent, f"{score.n - score.wins:g} of {score.n}")
        for score in blind.against
    )
    share = blind.share
    name = "Closer to what was meant (blind comparison)"
    return Figure(name, f"{share.mean:.0%}", others, share)


def _shares_of_games(
    name: str, shares: UnderstoodShares | ElsewhereShares | None
) -> Iterator[Figure]:
    if shares is None or shares.imitator is None:
        return
    known = [
        (actor, share)
        for actor, share in (("clone", shares.clone), ("person", shares.best))
        if share is not None
    ]
    # Of the person, measures are of all ranked games.
    others = tuple(
        OtherPlayer(actor, _share(share) + " in the best games" * (actor == "person"), share)
        for actor, share in known
    )
    high = max(1.0, shares.imitator.high, *(share.high for _, share in known))
    yield Figure(name, _share(shares.imitator), others, shares.imitator, 0.0, high)


def _share(share: Interval) -> str:
    # Negative where a game is worth less than one that is over.
    return f"{max(share.mean, 0.0):.0%}"


def _summary(
    summaries: Mapping[tuple[str, str], PolicySummary], behaviour: Behaviour, game: Game
) -> Iterator[Figure]:
    imitator, clone = (summaries.get((policy, "greedy")) for policy in evaluations.POLICIES)
    if imitator is None:
        return
    for name, key, write, high in _plans(behaviour, game):
        interval: Interval | None = getattr(imitator, key)
        if interval is None:
            continue
        other: Interval | None = None if clone is None else getattr(clone, key)
        others = () if other is None else (OtherPlayer("clone", write(other.mean), other),)
        ends = [bounds.high for bounds in (interval, other) if bounds is not None]
        yield Figure(name, write(interval.mean), others, interval, 0.0, high or max(ends))


def _plans(
    behaviour: Behaviour, game: Game
) -> Iterator[tuple[str, str, Callable[[float], str], float | None]]:
    """Yield name, attribute, form and upper bound of the means over evaluation games."""
    if behaviour.target is not None:
        n_targets = len(behaviour.target)
        yield f"Targets hit, of {n_targets}", "targets", "{:.1f}".format, n_targets
        yield "Strays", "strays", "{:.1f}".format, None
        if behaviour.ordered:
            yield "Hits out of order", "order_errors", "{:.1f}".format, None
        yield "Perfect games", "perfect", "{:.0%}".format, 1.0
    most = game.clock.max_steps
    yield f"Game length, of {most} steps", "steps", "{:.1f}".format, most
    yield "Death rate", "death_rate", "{:.0%}".format, 1.0


def _measures(
    behaviour: Behaviour,
    game: Game,
    games: Sequence[EvaluationRow],
    demonstrations: Sequence[RecordingRow],
) -> Iterator[Figure]:
    played = {
        policy: [row.recording for row in evaluations.headline_games(games, policy)]
        for policy in evaluations.POLICIES
    }
    players = {str(policy): rows for policy, rows in played.items()}
    players["person"] = [row for row in demonstrations if row.source == Source.PERSON]
    for place, measure in enumerate(behaviour.measures):
        means = {
            player: mean_of([measured_before(behaviour.measures, r.measured)[place] for r in rows])
            for player, rows in players.items()
        }
        texts = {
            player: measure_value(mean.mean, measure)
            for player, mean in means.items()
            if mean is not None
        }
        if (value := texts.pop("imitator", None)) is not None:
            others = tuple(
                OtherPlayer(player, text + " in all ranked games" * (player == "person"))
                for player, text in texts.items()
            )
            yield Figure(measure_title(measure, game), value, others)

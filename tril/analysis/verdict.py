"""What came of a run, in plain words, and what to do next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from tril.analysis.outcome import Headline, UnderstoodShares
from tril.analysis.summary import Interval, PolicySummary

Ended = Literal["done", "stopped", "failed", "cancelled"]
Tone = Literal["good", "fair", "bad", "none"]
NextStep = Literal["rank", "teach", "train", "games"]
"""Where the next step is taken: the rank page, the run's games to rank, the form of a new run, or
the run's games to watch."""

GOOD_SHARE = 0.9
"""Share of the best demonstrations' figure, targets or worth, from which on the imitator counts as
good. It is worth more only where the best games have less than this share of the imitator's."""
MOST_MET = 0.5
"""Share of the games that meet a measure from which on the imitator counts as meeting it."""
SURE = 1 / 3
"""Probability of the likeliest statement below which a run counts as a guess. It is low, since the
next statements often say nearly the same."""
MISREAD = 0.15
"""Share of a whole game by which the reward network may overrate games (T-REX, section 6)."""
MOST_LOST = 0.5
"""Death rate above which most games are lost."""
FEW_LOST = 0.25
FEW_MISTAKES = 0.25
"""Strays and order errors per game, together, up to which an imitator still counts as good."""
_WHOLE = 0.99
"""Share of a whole game from which on games count as whole."""
_ALARMED = (
    "Its reward rose while its games did not get better. Rank some of its games where they belong,"
    " and train again."
)
_SHOWN_MISTAKES = 0.05
"""Mean per game from which on they are named: less would be shown as 0.0."""


@dataclass(frozen=True)
class RunFigures:
    """The figures of a run that is over.

    Attributes:
        ended: End of the run.
        began: Whether a worker ever took it up.
        steps: Steps of the imitator's training.
        default_steps: Steps that the recipe proposes for the behaviour.
        warm_up_steps: Steps in which the imitator does not learn yet.
        n_targets: Target cells of the behaviour; None without any.
        best_targets: Targets that the best demonstration hits; None if that is not known.
        headline: The greedy games from held-out starts; None before they were played.
        is_alarmed: Whether the reward may be hacked.
        sureness: Probability of the likeliest statement about the order; None if there is none, or
            if a person has said what is meant.
        measures_met: Of each measure of the behaviour that sets bounds, the share of the imitator's
            games, those of the headline, that meet it.
    """

    ended: Ended
    began: bool
    steps: int
    default_steps: int
    warm_up_steps: int
    n_targets: int | None
    best_targets: int | None
    headline: Headline | None
    is_alarmed: bool
    sureness: float | None = None
    measures_met: tuple[float, ...] = ()


@dataclass(frozen=True)
class Verdict:
    """What came of a run.

    Attributes:
        tone: Success of the run; "none" where it can't be told.
        sentence: Result, in one short sentence.
        details: Figures and comparisons behind it; empty if there are none.
        advice: Next step for the person.
        next_step: Where.
    """

    tone: Tone
    sentence: str
    details: str
    advice: str
    next_step: NextStep | None


def verdict(run: RunFigures) -> Verdict:
    """Return the result of a run and the next step."""
    imitator = None if run.headline is None else run.headline.imitator
    clone = None if run.headline is None else run.headline.clone
    if imitator is None:
        return _without_games(run)
    if is_too_short(run.steps, run.warm_up_steps):
        return _too_short(run, imitator)
    if run.n_targets is None or imitator.targets is None:
        assert run.headline is not None
        understood = run.headline.understood
        if understood is None or understood.imitator is None:
            return _without_targets(imitator, clone)
        return _by_statement(run, imitator, understood.imitator, understood)
    details = " ".join(
        sentence
        for sentence in (
            f"The {_interval(imitator.targets)}.",
            _beside_clone(imitator.targets, clone),
            _mistakes(imitator),
            _lost(imitator.death_rate),
        )
        if sentence
    )
    return _advised(run, imitator, imitator.targets, clone, details)


def _too_short(run: RunFigures, imitator: PolicySummary) -> Verdict:
    hits = (
        ""
        if run.n_targets is None or imitator.targets is None
        else f" It hits {_mean(imitator.targets.mean)} of {run.n_targets} targets; the"
        f" {_interval(imitator.targets)}."
    )
    return Verdict(
        "bad",
        "The run was too short to learn anything.",
        f"In its {run.steps:,} steps only the critic learned, which takes the first"
        f" {run.warm_up_steps:,}, so the imitator still plays as it began.{hits}",
        f"Train for longer, such as {run.default_steps:,} steps.",
        "train",
    )


def is_too_short(steps: int, warm_up_steps: int) -> bool:
    """Whether a run of so many steps ends before the imitator begins to learn."""
    return 0 < steps <= warm_up_steps


def _advised(
    run: RunFigures,
    imitator: PolicySummary,
    targets: Interval,
    clone: PolicySummary | None,
    details: str,
) -> Verdict:
    sentence = _hits(run, targets)
    best = run.best_targets or run.n_targets or 0
    lost = imitator.death_rate.mean
    is_no_better = (
        clone is not None
        and clone.targets is not None
        and targets.mean <= clone.targets.mean
        and lost >= clone.death_rate.mean
    )
    if run.is_alarmed:
        return Verdict("bad", sentence, details, _ALARMED, "teach")
    strays, order_errors = _mean_of(imitator.strays), _mean_of(imitator.order_errors)
    makes_mistakes = strays + order_errors > FEW_MISTAKES
    if targets.mean >= GOOD_SHARE * best and lost <= FEW_LOST and not makes_mistakes:
        is_better = run.best_targets is not None and targets.low > run.best_targets
        compared = "better than" if is_better else "about as well as"
        advice = f"It plays {compared} the best demonstration. Watch some of its games."
        return Verdict("good", sentence, details, advice, "games")
    tone: Tone = "bad" if is_no_better or lost > MOST_LOST else "fair"
    if lost > MOST_LOST:
        advice = (
            "Rank some of the games that it loses low among the others, and train further from it."
        )
        return Verdict(tone, sentence, details, advice, "teach")
    if run.steps < run.default_steps:
        advice = f"Train for longer: the recipe proposes {run.default_steps:,} steps."
        return Verdict(tone, sentence, details, advice, "train")
    if is_no_better:
        advice = (
            "The reward taught it nothing that the clone can't do. Check the order, or rank some of"
            " its own games among the others, and train again."
        )
        return Verdict(tone, sentence, details, advice, "rank")
    if makes_mistakes:
        error = "other aliens" if strays >= order_errors else "targets out of order"
        advice = (
            f"Teach it more: rank games in which it hits {error} low among the others, and train"
            " further."
        )
        return Verdict(tone, sentence, details, advice, "teach")
    advice = "Teach it more: rank some of its own games among the others, and train further."
    return Verdict(tone, sentence, details, advice, "teach")


def _without_games(run: RunFigures) -> Verdict:
    match run.ended:
        case "stopped":
            return Verdict(
                "bad",
                "The check stopped this run before its imitator was trained.",
                "The reward model has not understood the ranking.",
                "Add games that show more clearly what is better, or correct the order, and train"
                " again.",
                "rank",
            )
        case "failed":
            return Verdict(
                "bad",
                "This run failed before its imitator had played.",
                "",
                "Resume it: it goes on from its last checkpoint. If it fails again, the message"
                " says why.",
                None,
            )
        case "cancelled" if not run.began:
            return Verdict(
                "none",
                "This run was cancelled while it waited, before it began.",
                "",
                "Resume it to start it.",
                None,
            )
        case "cancelled":
            return Verdict(
                "none",
                "This run was cancelled before its imitator had played.",
                "",
                "Resume it: it goes on from its last checkpoint.",
                None,
            )
        case "done":
            return Verdict(
                "none",
                "Nothing tells how well the imitator plays.",
                "No game of this run began from a start that its training had not seen.",
                "Watch its games.",
                "games",
            )


def _by_statement(
    run: RunFigures, imitator: PolicySummary, share: Interval, understood: UnderstoodShares
) -> Verdict:
    """Return the verdict by what Tril understood, on a behaviour without targets."""
    best, clone = understood.best, understood.clone
    # Games that are lost earn nothing afterwards, so that losses count on both sides.
    is_as_good = share.mean >= GOOD_SHARE * best.mean > 0
    compared = (
        "more than"
        if share.low > best.high > 0 and share.mean * GOOD_SHARE > best.mean
        else "about as much as"
        if is_as_good
        else "less than"
    )
    sentence = (
        f"By what Tril understood, the imitator's games are worth {compared} the best ones that it"
        f" learned from: {_percent(share.mean)} against {_percent(best.mean)}."
    )
    n_met = sum(met >= MOST_MET for met in run.measures_met)
    misread = _misread(share, understood.read)
    details = " ".join(
        part
        for part in (
            misread,
            "100% would be a game of full length, played throughout as well as the best ones are on"
            " average.",
            # Their worth is the share that they last, as the unit is their own mean.
            f"Those end after {_percent(best.mean)} of it." if best.mean < _WHOLE else "",
            clone
            and _told_apart(
                f"The games of the clone, which only copies, are worth {_percent(clone.mean)}",
                share,
                clone,
            ),
            _measures(n_met, run.measures_met),
            _lost(imitator.death_rate),
        )
        if part
    )
    if run.is_alarmed:
        return Verdict("bad", sentence, details, _ALARMED, "teach")
    if run.sureness is not None and run.sureness < SURE:
        return Verdict(
            "fair",
            sentence,
            "Tril was not sure what you meant: its likeliest guess had a probability of"
            f" {_percent(run.sureness)}. {details}",
            "Say on the rank page what you mean, or rank a few more games, and train again.",
            "rank",
        )
    is_worse = clone is not None and share.high < clone.low
    if is_as_good and not is_worse and n_met < len(run.measures_met):
        advice = (
            "It does not meet all of your measures yet. Rank games that differ in the ones it"
            " misses, and train again."
        )
        return Verdict("fair", sentence, details, advice, "rank")
    if is_as_good and not is_worse and misread:
        advice = (
            "Rank some of its games among the others, so that the reward learns to read what they"
            " show, and train further."
        )
        return Verdict("fair", sentence, details, advice, "teach")
    if is_as_good and not is_worse:
        advice = "Is it what you meant? Watch some of its games, or compare them blind."
        return Verdict("good", sentence, details, advice, "games")
    is_no_better = clone is not None and share.mean <= clone.mean
    tone: Tone = "bad" if is_no_better else "fair"
    if run.steps < run.default_steps:
        advice = f"Train for longer: the recipe proposes {run.default_steps:,} steps."
        return Verdict(tone, sentence, details, advice, "train")
    advice = "Teach it more: rank some of its own games among the others, and train further."
    return Verdict(tone, sentence, details, advice, "teach")


def _misread(share: Interval, read: Interval | None) -> str:
    """Return that the reward overrates games, since what is learned is what its network reads."""
    if read is None or read.n < 2 or read.low <= share.high:
        return ""
    if read.mean - max(share.mean, 0) <= MISREAD:
        return ""
    return (
        "Its reward overrates these games: read off the screen, they are worth"
        f" {_percent(read.mean)}."
    )


def _measures(n_met: int, met: tuple[float, ...]) -> str:
    if not met:
        return ""
    if len(met) == 1:
        return f"It meets your measure in {_percent(met[0])} of its games."
    return f"It meets {n_met or 'none'} of your {len(met)} measures in at least half of its games."


def _without_targets(imitator: PolicySummary, clone: PolicySummary | None) -> Verdict:
    against = "" if clone is None else f", the clone {_percent(clone.death_rate.mean)}"
    n = imitator.death_rate.n
    return Verdict(
        "none",
        f"The imitator loses {_percent(imitator.death_rate.mean)} of its {_games(n)}{against}.",
        "This behaviour names no targets, so how well it plays isn't counted.",
        "Compare its games with others blind, and rank those that show something new.",
        "teach",
    )


def _hits(run: RunFigures, targets: Interval) -> str:
    best = "" if run.best_targets is None else f", the best demonstration {run.best_targets}"
    return f"The imitator hits {_mean(targets.mean)} of {run.n_targets} targets{best}."


def _interval(targets: Interval) -> str:
    return f"95% interval is {targets.low:.1f} to {targets.high:.1f}, over {_games(targets.n)}"


def _beside_clone(targets: Interval, clone: PolicySummary | None) -> str:
    if clone is None or clone.targets is None:
        return ""
    return _told_apart(f"The clone hits {_mean(clone.targets.mean)}", targets, clone.targets)


def _told_apart(clone_reaches: str, imitator: Interval, clone: Interval) -> str:
    if imitator.low > clone.high:
        return f"{clone_reaches}: the imitator is clearly better."
    if imitator.high < clone.low:
        return f"{clone_reaches}: the imitator is clearly worse."
    return f"{clone_reaches}: the games do not tell them apart."


def _lost(death_rate: Interval) -> str:
    if death_rate.mean == 0:
        return "The imitator loses no game."
    often = "most" if death_rate.mean > MOST_LOST else "some"
    return f"The imitator loses {often} of its games ({_percent(death_rate.mean)})."


def _mistakes(imitator: PolicySummary) -> str:
    strays, order_errors = _mean_of(imitator.strays), _mean_of(imitator.order_errors)
    mistakes = []
    if strays >= _SHOWN_MISTAKES:
        mistakes.append(f"other aliens ({_mean(strays)} a game)")
    if order_errors >= _SHOWN_MISTAKES:
        mistakes.append(f"targets out of order ({_mean(order_errors)} a game)")
    return f"The imitator also hits {' and '.join(mistakes)}." if mistakes else ""


def _mean_of(figure: Interval | None) -> float:
    return 0.0 if figure is None else figure.mean


def _mean(value: float) -> str:
    return f"{value:.0f}" if value == round(value) else f"{value:.1f}"


def _percent(share: float) -> str:
    # Negative where a game is worth less than one that is over.
    return f"{max(share, 0.0):.0%}"


def _games(n: int) -> str:
    return f"{n} game" + ("s" if n != 1 else "")

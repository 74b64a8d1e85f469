"""What a person is told about the check of their ranking."""

from __future__ import annotations

from collections.abc import Sequence

from trainer.reward.check import PASSING_ACCURACY, PASSING_TAU, RankingCheck
from tril.vocabulary.understanding import N_SHUFFLES

MAX_NAMED = 6
"""Pairs of tiers that are named; the page lists all."""

_ALIENS_ALONE = (
    " This recipe considers only which aliens are hit. If you ranked by something else, such as"
    " where the cannon stands or how often it shoots, train with the recipe any."
)


def advice(check: RankingCheck, *, aliens_alone: bool = False) -> str:
    """Return what the model did not learn of the ranking and what to do; empty if it passed.

    Args:
        check: Check of the ranking.
        aliens_alone: Whether the model can only learn which aliens are wanted.
    """
    if check.passed:
        return ""
    pairs = list(dict.fromkeys((pair.better, pair.worse) for pair in check.confused))
    if check.n_as_good is not None:
        contradicting = (
            f" Look first at tiers {_named(pairs[:1])}, which contradict the rest most."
            if pairs
            else ""
        )
        return (
            "Nothing that Tril can tell of these games explains their order better than chance."
            f"{contradicting} Rank more games that differ clearly in what you mean, or mend the"
            " order. You can also go on anyway."
        )
    measured = []
    if check.tau < PASSING_TAU:
        measured.append(
            f"it hardly orders the demonstrations as they are ranked (Kendall's tau"
            f" {check.tau:.2f}, at least {PASSING_TAU} is needed)"
        )
    accuracy = check.held_out_accuracy
    if accuracy is not None and accuracy < PASSING_ACCURACY:
        measured.append(
            f"it orders demonstrations that it did not learn from hardly better than chance"
            f" ({accuracy:.0%} of the pairs, at least {PASSING_ACCURACY:.0%} are needed)"
        )
    confused = f" It confuses tiers {_named(pairs)}." if pairs else ""
    return (
        f"The reward model has not understood the ranking: {', and '.join(measured)}.{confused} It "
        "needs other demonstrations or another order."
        + (_ALIENS_ALONE if aliens_alone else "")
        + " You can also go on anyway."
    )


def warning(check: RankingCheck) -> str:
    """Return the doubts about a passed check; empty if the model is confident.

    Single tiers that are not told apart say nothing of the imitator: the page lists them.
    """
    if check.passed and check.n_as_good:
        return (
            f"{check.n_as_good} of {N_SHUFFLES} shuffled orders of these games are explained as"
            " well as yours, so that the statements may be chance. A few more games that differ in"
            " what you mean make them surer."
        )
    if not check.passed or check.is_confident:
        return ""
    accuracy = check.held_out_accuracy
    held_out = "" if accuracy is None else f", {accuracy:.0%} of held-out pairs in order"
    pairs = check.not_told_apart
    return (
        "The reward model follows the ranking, but not everywhere (Kendall\u2019s tau"
        f" {check.tau:.2f}{held_out})."
        + (f" It can\u2019t tell these tiers apart: {_named(pairs)}." if pairs else "")
        + " Games that show more clearly what is better help."
    )


def _named(pairs: Sequence[tuple[int, int]]) -> str:
    named = ", ".join(f"{better} and {worse}" for better, worse in pairs[:MAX_NAMED])
    n_unnamed = len(pairs) - MAX_NAMED
    return named + (
        f" and {n_unnamed} more pair{'s' if n_unnamed > 1 else ''}" if n_unnamed > 0 else ""
    )

"""What a person is told about the check of their ranking."""

from __future__ import annotations

from collections.abc import Sequence

from trainer.reward.check import PASSING_HELD_OUT_ACCURACY, PASSING_TAU, RankingCheck

MAX_NAMED = 6
"""Pairs of tiers that are named; the page lists all."""


def advice(check: RankingCheck) -> str:
    """Return what the model did not learn of the ranking and what to do; empty if it passed."""
    if check.passed:
        return ""
    measured = [f"Kendall's tau is {check.tau:.2f} (at least {PASSING_TAU} is needed)"]
    if check.held_out_accuracy is not None:
        measured.append(
            f"{check.held_out_accuracy:.0%} of the pairs with held-out demonstrations are in order"
            f" (at least {PASSING_HELD_OUT_ACCURACY:.0%} is needed)"
        )
    pairs = list(dict.fromkeys((pair.better, pair.worse) for pair in check.confused))
    confused = f" It confuses tiers {_named(pairs)}." if pairs else ""
    return (
        f"The reward model has not understood the ranking: {'; '.join(measured)}.{confused} It "
        "needs other demonstrations or another order. You can also go on anyway."
    )


def warning(check: RankingCheck) -> str:
    """Return which tiers can't be told apart although the check passed; empty if there are none."""
    pairs = check.not_told_apart
    if not check.passed or not pairs:
        return ""
    return (
        "The ranking as a whole was understood, but the reward model can\u2019t tell these tiers "
        f"apart: {_named(pairs)}. The recordings do not show what makes one better than the other, "
        "or too few of them do. If the difference matters, add recordings that show it; if it "
        "doesn\u2019t, put them into one tier; or check that they are in the right order."
    )


def _named(pairs: Sequence[tuple[int, int]]) -> str:
    named = ", ".join(f"{better} and {worse}" for better, worse in pairs[:MAX_NAMED])
    more = len(pairs) - MAX_NAMED
    return named + (f" and {more} more pair{'s' if more > 1 else ''}" if more > 0 else "")

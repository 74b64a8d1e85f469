"""What the check of a ranking says to a person."""

from __future__ import annotations

from trainer.reward.check import PASSING_HELD_OUT_ACCURACY, PASSING_TAU, RankingCheck

MOST_NAMED = 6
"""Pairs of tiers that are named; the page lists all."""


def advice(check: RankingCheck) -> str:
    """Say what of the ranking was not understood, and what to do; empty where it passed."""
    if check.passed:
        return ""
    measured = [f"Kendall's tau is {check.tau:.2f} (at least {PASSING_TAU} is needed)"]
    if check.held_out_accuracy is not None:
        measured.append(
            f"{check.held_out_accuracy:.0%} of the pairs with demonstrations left out are in "
            f"order (at least {PASSING_HELD_OUT_ACCURACY:.0%} is needed)"
        )
    pairs = list(dict.fromkeys((pair.better, pair.worse) for pair in check.confused))
    confused = f" It confuses tiers {_named(pairs)}." if pairs else ""
    return (
        f"The reward model has not understood the ranking: {'; '.join(measured)}.{confused} It "
        "needs other demonstrations or another order. You can also go on anyway."
    )


def warning(check: RankingCheck) -> str:
    """Name the tiers that can't be told apart where the check passed all the same, else nothing."""
    pairs = check.not_told_apart
    if not check.passed or not pairs:
        return ""
    return (
        "The ranking as a whole was understood, but the reward model can\u2019t tell these tiers "
        f"apart: {_named(pairs)}. What makes the one better than the other is not to be seen in "
        "the recordings, or in too few of them. If the difference matters, add recordings that "
        "show it; if it doesn\u2019t, put them into one tier; or look whether they are in the "
        "right order."
    )


def _named(pairs: list[tuple[int, int]]) -> str:
    named = ", ".join(f"{better} and {worse}" for better, worse in pairs[:MOST_NAMED])
    more = len(pairs) - MOST_NAMED
    return named + (f" and {more} more pair{'s' if more > 1 else ''}" if more > 0 else "")

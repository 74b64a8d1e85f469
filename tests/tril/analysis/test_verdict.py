"""The verdict on runs, over made-up outcomes."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tril.analysis.outcome import Headline, UnderstoodShares
from tril.analysis.summary import GameFigures, Interval, PolicySummary, summarise
from tril.analysis.verdict import Ended, RunFigures, verdict


def games(
    targets: list[int] | None,
    lost: float = 0.0,
    n: int = 20,
    strays: int = 0,
    order_errors: int = 0,
) -> PolicySummary:
    """Summarise games that hit these targets in turn, of which a share is lost."""
    return summarise(
        [
            GameFigures(
                targets=None if targets is None else targets[i % len(targets)],
                strays=None if targets is None else strays,
                order_errors=order_errors,
                steps=300,
                died=i < lost * n,
                predicted_return=float(i),
                n_targets=6,
            )
            for i in range(n)
        ]
    )


def headline(imitator: PolicySummary | None, clone: PolicySummary | None) -> Headline:
    return Headline(
        tau=1.0, pair_accuracy=1.0, held_out_accuracy=None, imitator=imitator, clone=clone
    )


DONE = RunFigures(
    ended="done",
    began=True,
    steps=300_000,
    default_steps=300_000,
    warm_up_steps=12_000,
    n_targets=6,
    best_targets=6,
    headline=headline(games([6, 6, 6, 5]), games([1, 2])),
    is_alarmed=False,
)


def test_a_run_that_went_well_is_praised_with_its_figures() -> None:
    said = verdict(DONE)
    assert (said.tone, said.next_step) == ("good", "games")
    assert said.sentence == "The imitator hits 5.8 of 6 targets, the best demonstration 6."
    assert said.details == (
        "The 95% interval is 5.5 to 5.9, over 20 games."
        " The clone hits 1.5: the imitator is clearly better. The imitator loses no game."
    )
    assert said.advice.startswith("It plays about as well as the best demonstration.")


def test_one_that_is_surely_better_than_what_was_shown_is_said_to_be() -> None:
    said = verdict(replace(DONE, best_targets=5))
    assert (said.tone, said.next_step) == ("good", "games")
    assert said.advice.startswith("It plays better than the best demonstration.")


def test_one_that_is_no_better_than_the_clone_needs_another_ranking() -> None:
    same = games([3, 4], lost=0.3)
    said = verdict(replace(DONE, headline=headline(same, same)))
    assert (said.tone, said.next_step) == ("bad", "rank")
    assert "The clone hits 3.5: the games do not tell them apart." in said.details
    assert "Check the order" in said.advice


def test_one_that_did_not_train_for_long_is_to_train_for_longer() -> None:
    same = games([3, 4], lost=0.3)
    said = verdict(replace(DONE, steps=50_000, headline=headline(same, same)))
    assert said.next_step == "train"
    assert "300,000 steps" in said.advice


def test_one_that_loses_most_games_is_to_see_them_ranked() -> None:
    lost = headline(games([5, 6], lost=0.6), games([1, 2]))
    said = verdict(replace(DONE, headline=lost))
    assert (said.tone, said.next_step) == ("bad", "teach")
    assert said.details.endswith("The imitator loses most of its games (60%).")
    assert "games that it loses" in said.advice


@pytest.mark.parametrize(
    ("mistakes", "what"),
    [
        ({"strays": 1}, "other aliens (1 a game)"),
        ({"order_errors": 2}, "targets out of order (2 a game)"),
        (
            {"strays": 1, "order_errors": 2},
            "other aliens (1 a game) and targets out of order (2 a game)",
        ),
    ],
)
def test_one_that_also_hits_what_it_should_not_is_not_praised(
    mistakes: dict[str, int], what: str
) -> None:
    said = verdict(replace(DONE, headline=headline(games([6], **mistakes), games([1]))))
    assert (said.tone, said.next_step) == ("fair", "teach")
    assert f"The imitator also hits {what}." in said.details
    assert said.advice.startswith("Teach it more: rank games in which it hits")


def test_one_in_between_is_to_be_taught_more() -> None:
    said = verdict(replace(DONE, headline=headline(games([4]), games([2]))))
    assert (said.tone, said.next_step) == ("fair", "teach")
    assert "hits 4 of 6 targets" in said.sentence


def test_one_that_hacks_its_reward_is_not_praised() -> None:
    said = verdict(replace(DONE, is_alarmed=True))
    assert (said.tone, said.next_step) == ("bad", "teach")


@pytest.mark.parametrize(("steps", "is_short"), [(1_000, True), (12_000, True), (12_001, False)])
def test_one_within_the_critics_warm_up_is_too_short(steps: int, is_short: bool) -> None:
    said = verdict(replace(DONE, steps=steps, headline=headline(games([2]), games([2]))))
    assert ("too short to learn anything" in said.sentence) == is_short
    assert said.next_step == "train"


@pytest.mark.parametrize(
    ("ended", "tone", "next_step", "words"),
    [
        ("stopped", "bad", "rank", "The check stopped this run"),
        ("failed", "bad", None, "failed before its imitator had played"),
        ("cancelled", "none", None, "cancelled before its imitator had played"),
        ("done", "none", "games", "Nothing tells how well"),
    ],
)
def test_one_without_games_says_how_it_ended(
    ended: Ended, tone: str, next_step: str | None, words: str
) -> None:
    said = verdict(replace(DONE, ended=ended, headline=None))
    assert (said.tone, said.next_step) == (tone, next_step)
    assert words in said.sentence


def test_one_that_was_cancelled_while_it_waited_has_no_checkpoint() -> None:
    said = verdict(replace(DONE, ended="cancelled", began=False, headline=None))
    assert (said.tone, said.next_step) == ("none", None)
    assert "before it began" in said.sentence
    assert "checkpoint" not in said.advice


def test_one_that_was_cancelled_after_its_games_is_judged_by_them() -> None:
    assert verdict(replace(DONE, ended="cancelled")) == verdict(DONE)


def test_without_target_cells_nothing_is_counted() -> None:
    shown = headline(games(None, lost=0.25), games(None, lost=0.5))
    said = verdict(replace(DONE, n_targets=None, best_targets=None, headline=shown))
    assert (said.tone, said.next_step) == ("none", "teach")
    assert said.sentence.startswith("The imitator loses 25% of its 20 games, the clone 50%")


def test_one_game_is_counted_in_the_singular() -> None:
    said = verdict(replace(DONE, headline=headline(games([3], n=1), None)))
    assert "3.0 to 3.0, over 1 game. The imitator" in said.details


def shares(imitator: float, clone: float, best: float) -> UnderstoodShares:
    """Return shares whose intervals reach 0.05 to both sides."""
    of = {
        name: Interval(mean, mean - 0.05, mean + 0.05, 20)
        for name, mean in (("imitator", imitator), ("clone", clone), ("best", best))
    }
    return UnderstoodShares(**of)


def by_statement(understood: UnderstoodShares, lost: float = 0.0) -> RunFigures:
    """Return a run of a behaviour without targets whose reward is a statement."""
    shown = headline(games(None, lost), games(None, 1.0))
    shown = shown.model_copy(update={"understood": understood})
    return replace(DONE, n_targets=None, best_targets=None, headline=shown, sureness=0.9)


def test_without_targets_what_was_understood_is_compared() -> None:
    said = verdict(by_statement(shares(0.88, 0.27, 0.31), lost=0.1))
    assert (said.tone, said.next_step) == ("good", "games")
    assert said.sentence == (
        "By what Tril understood, the imitator's games are worth more than the best ones that it"
        " learned from: 88% against 31%."
    )
    assert "which only copies, are worth 27%: the imitator is clearly better." in said.details
    assert "The imitator loses some of its games (10%)." in said.details


@pytest.mark.parametrize(
    ("understood", "compared", "tone"),
    [
        (shares(0.70, 0.40, 0.72), "about as much as the best ones", "good"),
        (shares(1.105, 0.40, 1.00), "about as much as the best ones", "good"),
        (shares(0.50, 0.40, 0.72), "less than the best ones", "fair"),
        (shares(0.38, 0.40, 0.72), "less than the best ones", "bad"),
        # Where the best games show nothing, nobody is as good as they.
        (shares(0.00, -0.10, 0.00), "less than", "fair"),
        (shares(0.72, 0.95, 0.72), "about as much as", "bad"),
        (shares(-0.10, 0.00, 0.72), "the best ones that it learned from: 0% against 72%", "bad"),
    ],
)
def test_the_clone_and_the_best_games_set_the_tone(
    understood: UnderstoodShares, compared: str, tone: str
) -> None:
    said = verdict(by_statement(understood))
    assert compared in said.sentence
    assert said.tone == tone


def test_a_run_in_which_only_the_critic_learned_is_too_short_in_any_behaviour() -> None:
    said = verdict(replace(by_statement(shares(0.9, 0.2, 0.5)), steps=1))
    assert (said.tone, said.next_step) == ("bad", "train")
    assert said.details.endswith("so the imitator still plays as it began.")


def test_a_guess_is_praised_no_further_than_it_is_sure() -> None:
    said = verdict(replace(by_statement(shares(0.88, 0.27, 0.31)), sureness=0.25))
    assert (said.tone, said.next_step) == ("fair", "rank")
    assert "its likeliest guess had a probability of 25%" in said.details
    meant = verdict(replace(by_statement(shares(0.88, 0.27, 0.31)), sureness=None))
    assert meant.tone == "good"


@pytest.mark.parametrize(("read", "tone"), [(0.95, "fair"), (0.80, "good"), (0.40, "good")])
def test_a_reward_that_misreads_the_imitators_games_is_told(read: float, tone: str) -> None:
    understood = shares(0.70, 0.40, 0.72).model_copy(
        update={"read": Interval(read, read - 0.02, read + 0.02, 20)}
    )
    said = verdict(by_statement(understood))
    assert said.tone == tone
    assert ("they are worth 95%" in said.details) == (tone == "fair")


def test_a_misread_game_is_no_better_for_it() -> None:
    for imitator, clone, tone in ((-0.40, 0.40, "bad"), (0.20, 0.40, "bad"), (0.45, 0.40, "fair")):
        understood = shares(imitator, clone, 0.72).model_copy(
            update={"read": Interval(0.95, 0.93, 0.97, 20)}
        )
        said = verdict(by_statement(understood))
        assert said.tone == tone
        assert "read off the screen, they are worth 95%" in said.details
    nothing = shares(-0.40, 0.40, 0.72).model_copy(
        update={"read": Interval(-0.02, -0.03, -0.01, 20)}
    )
    assert "overrates" not in verdict(by_statement(nothing)).details


@pytest.mark.parametrize(
    ("met", "said_of_it", "tone"),
    [
        ((0.9,), "It meets your measure in 90% of its games.", "good"),
        ((0.1,), "It meets your measure in 10% of its games.", "fair"),
        ((0.9, 0.0), "It meets 1 of your 2 measures in at least half of its games.", "fair"),
        ((0.1, 0.0), "It meets none of your 2 measures in at least half of its games.", "fair"),
        ((0.9, 0.6), "It meets 2 of your 2 measures in at least half of its games.", "good"),
    ],
)
def test_what_a_person_measures_has_to_be_met(
    met: tuple[float, ...], said_of_it: str, tone: str
) -> None:
    said = verdict(replace(by_statement(shares(0.88, 0.27, 0.31)), measures_met=met))
    assert said_of_it in said.details
    assert said.tone == tone

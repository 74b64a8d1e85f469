"""The kinds of example and the human-like player."""

from __future__ import annotations

import errno
import os
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from scripts.demonstrations import demonstration_object
from tril.demonstrators import (
    HUMAN,
    KINDS,
    PERFECT,
    SCRIPTED,
    Demonstration,
    DemonstrationFailed,
    ErrorModel,
    PlannedGame,
    demonstrate,
    example_plans,
    example_tasks,
    execute,
    kind_named,
    rank_example,
)
from tril.demonstrators.judging import swap_neighbours
from tril.demonstrators.space_invaders.human_like import HumanLikePlayer
from tril.demonstrators.space_invaders.plans import draw_hits, tolerance_violation
from tril.demonstrators.space_invaders.player import PlayStyle
from tril.errors import Invalid
from tril.games.atari.starts import AtariStart
from tril.games.behaviours import score
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.memory import MAX_FRAMES, Action
from tril.play.episode import Episode
from tril.ranking import Ranking, contradictions, normalise
from tril.recording import Recorder, verify

BY_SLUG = {behaviour.slug: behaviour for behaviour in BUILT_IN}
HUMAN_KIND = kind_named("human")


# Kinds


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("scripted", list(range(1, 13))),
        ("human", list(range(1, 13))),
        ("person-350", list(range(1, 13))),
        ("six", [1, 3, 5, 8, 10, 12]),
        ("twenty-four", [number for number in range(1, 13) for _ in range(2)]),
        ("no-wrong", [1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 7]),
        ("no-gradual", [1, 1, 7, 7, 8, 8, 9, 9, 10, 10, 11, 12]),
    ],
)
@pytest.mark.parametrize("slug", ["column-3", "row-1"])
def test_each_kind_has_the_demonstrations_that_it_promises(
    name: str, numbers: list[int], slug: str
) -> None:
    kind = kind_named(name)
    tasks = example_tasks(BY_SLUG[slug], np.random.default_rng(0), 12, kind)
    ranked = [task for task in tasks if not task.perfect]
    assert [task.plan.number for task in ranked] == numbers
    assert len(numbers) == kind.n_ranked
    assert [task.plan.number for task in tasks if task.perfect] == [1] * 12
    assert {task.error_model for task in tasks} == {kind.error_model}
    # Two demonstrations of one plan are different games.
    assert len({task.seed for task in tasks}) == len(tasks)
    assert len({task.idle_frames[0] for task in tasks}) == len(tasks)


def test_only_people_do_not_play_flawlessly() -> None:
    names = [kind.name for kind in KINDS if kind.error_model != PERFECT]
    assert names == ["human", "person-150", "person-250", "person-350"]
    assert replace(kind_named("person-250").error_model, name="human") == HUMAN
    assert kind_named("scripted") is SCRIPTED
    with pytest.raises(Invalid, match="'seven'; choose one of scripted, human, person-150,"):
        kind_named("seven")


def test_flawless_demonstrations_have_no_conditions_and_their_plans_tier() -> None:
    (made,) = execute([example_tasks(BY_SLUG["column-4"], np.random.default_rng(7))[6]])
    assert made.conditions == {}
    assert made.notes == made.plan.description
    assert demonstration_object(made)["tier"] == 7


# The human-like player


class Shoved(Recorder):
    """A game whose cannon is pushed to the right for a while, whatever keys are held."""

    def __init__(self, episode: Episode, pushed: range) -> None:
        super().__init__(episode)
        self.keys: list[int] = []
        self._pushed = pushed

    def advance(self, action: int) -> None:
        self.keys.append(action)
        super().advance(Action.RIGHT if self.episode.frame in self._pushed else action)


@pytest.mark.parametrize("reaction_frames", [0, 6, 15, 24])
def test_actions_depend_on_the_screen_of_a_reaction_time_ago(reaction_frames: int) -> None:
    console = SPACE_INVADERS.make_console()
    error_model = replace(HUMAN, reaction_frames=reaction_frames)
    plan = example_plans(BY_SLUG["column-3"])[0]
    lags = []
    for seed in range(8):
        keys = []
        for pushed in (range(0), range(60, 90)):
            rng = np.random.default_rng(seed)
            recorder = Shoved(Episode(console, AtariStart(4), max_frames=200), pushed)
            wanted = draw_hits(plan, rng)
            HumanLikePlayer(recorder, wanted, PlayStyle(), error_model, rng).play()
            keys.append(recorder.keys)
        left_alone, was_pushed = keys
        both = zip(left_alone, was_pushed, strict=False)
        lags += [frame - 60 for frame, (a, b) in enumerate(both) if a != b][:1]
    assert min(lags) > reaction_frames
    # And it does react: soon after the reaction time in one of the games at least.
    assert min(lags) < reaction_frames + 60


@pytest.fixture(scope="module")
def human() -> list[Demonstration]:
    """The ranked demonstrations of the human kind, then two perfect ones."""
    tasks = example_tasks(BY_SLUG["column-2"], np.random.default_rng(0), 2, HUMAN_KIND)
    return list(execute(tasks))


def test_human_games_stay_near_their_plans_and_replay(
    human: list[Demonstration],
) -> None:
    console = SPACE_INVADERS.make_console()
    assert len(human) == 14
    for made in human[:12]:
        assert tolerance_violation(made.plan, made.shown.hits) is None
        assert verify(made.recording, console=console).recording == made.recording
        assert made.conditions["manner"]["reaction_frames"] == 15
        exchanged = demonstration_object(made, 3)
        assert (exchanged["source"], exchanged["tier"]) == ("scripted", 3)
        assert exchanged["conditions"]["manner"]["name"] == "human"
        assert exchanged["notes"].startswith("Meant as: ")


def test_human_games_have_uneven_lengths_some_cut_short_some_ended_by_a_hit(
    human: list[Demonstration],
) -> None:
    ends = Counter(made.replay.end for made in human[:12])
    assert set(ends) == {None, EndReason.HIT, EndReason.STEPS}
    lengths = {made.recording.n_frames for made in human[:12]}
    assert len(lengths) > 6
    assert min(lengths) < MAX_FRAMES / 2
    assert max(lengths) == MAX_FRAMES


def test_a_person_changes_keys_between_an_agents_steps(human: list[Demonstration]) -> None:
    actions = np.frombuffer(human[0].recording.actions, np.uint8)
    changes = np.flatnonzero(np.diff(actions)) + 1
    assert len(set((changes % 4).tolist())) == 4


def test_perfect_human_games_are_perfect_but_of_uneven_lengths(
    human: list[Demonstration],
) -> None:
    for made in human[12:]:
        found = score(BY_SLUG["column-2"], made.shown.hits)
        assert found is not None
        assert (found.targets, found.strays) == (6, 0)
        assert made.replay.end in (None, EndReason.STEPS)
        assert made.notes == made.plan.description


def test_a_game_that_ends_by_a_hit_is_no_perfect_demonstration() -> None:
    careless = replace(HUMAN, missed_bomb_share=1.0, cut_short_share=0.0)
    no_alien = example_plans(BY_SLUG["column-1"])[6]

    def play(perfect: bool) -> Demonstration:
        rng = np.random.default_rng(0)
        return demonstrate(no_alien, AtariStart(4), rng, error_model=careless, perfect=perfect)

    assert play(perfect=False).replay.end == EndReason.HIT
    with pytest.raises(DemonstrationFailed, match=r"ended at frame \d+: hit"):
        play(perfect=True)


def test_the_same_seed_gives_the_same_human_games(human: list[Demonstration]) -> None:
    def again(seed: int, *numbers: int) -> list[Demonstration]:
        tasks = example_tasks(BY_SLUG["column-2"], np.random.default_rng(seed), 2, HUMAN_KIND)
        return list(execute([tasks[number] for number in numbers], n_processes=len(numbers)))

    assert again(0, 3, 11) == [human[3], human[11]]
    assert again(1, 3)[0].recording != human[3].recording


def test_where_processes_can_share_no_lock_this_one_plays(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def refuse(*_arguments: object, **_options: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    # As without /dev/shm, or with one that can't be written.
    monkeypatch.setattr("multiprocessing.synchronize.SemLock.__init__", refuse)
    monkeypatch.setattr("tril.demonstrators.example._execute", lambda task: (os.getpid(), task))
    tasks = example_tasks(BY_SLUG["column-2"], np.random.default_rng(0), 2, HUMAN_KIND)
    played: list[object] = list(execute(tasks, n_processes=2))
    assert played == [(os.getpid(), task) for task in tasks]
    assert "without /dev/shm: [Errno 30] Read-only file system" in caplog.text


def test_every_behaviour_has_human_games_for_the_best_and_the_worst_plan() -> None:
    for behaviour in BUILT_IN:
        tasks = example_tasks(behaviour, np.random.default_rng(2), 0, HUMAN_KIND)
        best, worst = (made.shown.hits for made in execute([tasks[0], tasks[11]]))
        found = score(behaviour, best)
        assert found is not None
        assert found.targets - found.strays >= 4
        assert len(worst) >= 8


def test_human_games_may_deviate_from_their_plan_within_limits() -> None:
    six, five = example_plans(BY_SLUG["column-1"])[:2]
    column = [(row, 0) for row in range(6)]
    assert tolerance_violation(six, column) is None
    assert tolerance_violation(six, column[:5]) is None
    assert tolerance_violation(six, [*column[:5], (0, 1)]) is None
    assert tolerance_violation(five, column) is None
    assert tolerance_violation(six, column[:4]) == "It hits 4 aliens; the plan has 6."
    assert tolerance_violation(six, [*column[:4], (0, 1), (1, 1)]) == (
        "It hits row 1 of column 2, row 2 of column 2, which the plan leaves alone."
    )


# The ranking


def _game(
    n_targets: int, n_strays: int = 0, end: EndReason | None = EndReason.STEPS
) -> PlannedGame:
    hits = [(row, 1) for row in range(n_targets)] + [(row, 3) for row in range(n_strays)]
    return PlannedGame(1, tuple(hits), end)


def test_human_games_are_ranked_by_what_they_hit_and_whether_they_were_survived() -> None:
    games = {
        10: _game(0, 5),
        11: _game(6),
        12: _game(0),
        13: _game(5),
        14: _game(6, 1, end=None),
        15: _game(4, end=EndReason.HIT),
        16: _game(4),
        17: _game(0, 2),
    }
    judgement = rank_example(BY_SLUG["column-2"], HUMAN_KIND, games, 0)
    assert judgement.true == Ranking(((11,), (13, 14), (16,), (15,), (12,), (17,), (10,)))
    assert judgement.given != judgement.true
    assert len(judgement.mistakes) == HUMAN_KIND.n_mistakes == 3


def test_a_sweep_out_of_order_is_worth_less_than_none() -> None:
    in_order = PlannedGame(1, ((0, 0), (0, 1)), EndReason.STEPS)
    out_of_order = PlannedGame(1, ((0, 3), (0, 2)), EndReason.STEPS)
    none = PlannedGame(1, (), EndReason.STEPS)
    kind = replace(HUMAN_KIND, n_mistakes=0)
    judgement = rank_example(BY_SLUG["row-1"], kind, {0: out_of_order, 1: none, 2: in_order}, 0)
    assert judgement.given == judgement.true == Ranking(((2,), (1,), (0,)))


def test_flawless_games_are_ranked_by_their_plans_without_mistakes() -> None:
    games = {number: replace(_game(0), plan_number=number % 12 + 1) for number in range(24)}
    judgement = rank_example(BY_SLUG["column-2"], kind_named("twenty-four"), games, 0)
    assert judgement.given == judgement.true
    assert judgement.true.tiers[0] == (0, 12)
    assert len(judgement.true.tiers) == 12
    assert judgement.to_dict()["tau"] == 1


@pytest.mark.parametrize("n_pairs", range(5))
def test_as_many_pairs_are_swapped_as_asked_for(n_pairs: int) -> None:
    true = normalise([[0], [1, 2], [3], [4, 5, 6], [7], [8], [9], [10, 11]])
    seen = set()
    for seed in range(20):
        given = swap_neighbours(true, n_pairs, np.random.default_rng(seed))
        assert sorted(given.items) == sorted(true.items)
        assert [len(tier) for tier in given.tiers] == [len(tier) for tier in true.tiers]
        wrong = contradictions(true, given)
        assert len(wrong) == n_pairs
        place = true.tier_numbers()
        assert all(place[worse] - place[better] == 1 for better, worse in wrong)
        assert given == swap_neighbours(true, n_pairs, np.random.default_rng(seed))
        seen.add(given)
    assert len(seen) > 1 or n_pairs == 0


def test_swaps_need_two_tiers_each() -> None:
    with pytest.raises(Invalid, match="Expected 4 tiers for 2 swaps, got 3"):
        swap_neighbours(normalise([[0], [1], [2]]), 2, np.random.default_rng(0))


def test_an_error_model_survives_being_stored() -> None:
    assert ErrorModel(**HUMAN.to_dict()) == HUMAN

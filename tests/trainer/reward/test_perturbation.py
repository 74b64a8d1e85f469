from dataclasses import replace

import numpy as np
import pytest

from trainer.progress import RunCancelled
from trainer.reward import perturbation
from trainer.reward.perturbation import MAX_STEPS, MIN_STEPS, perturb_demonstrations
from tril.game.agent import AgentGame
from tril.game.console import Console
from tril.game.controls import Keys, action_for, keys_for
from tril.game.space_invaders import FRAMES_PER_STEP, Action
from tril.game.starts import Start
from tril.recording import Recording, trajectory

STEPS = 120


@pytest.fixture(scope="module")
def recording() -> Recording:
    """A game whose action changes in the middle of a step, as a person's does."""
    rng = np.random.default_rng(3)
    actions = bytes(np.repeat(rng.integers(0, 6, STEPS // 2 + 1), 8)[2 : 2 + 4 * STEPS].tolist())
    game = AgentGame(Console())
    game.reset(Start(50))
    for action in actions:
        if game.end is None:
            game.advance(action)
    return Recording(Start(50), game.episode.actions)


def test_copies_begin_in_the_game_and_leave_it(recording: Recording) -> None:
    original = trajectory(recording).observations
    copies = perturb_demonstrations([recording] * 2, 5, np.random.default_rng(0), lambda: None)
    assert {copy.original for copy in copies} == {0, 1}
    differ = []
    for copy in copies:
        own, first = copy.observations, copy.first_step
        assert MIN_STEPS < len(own) <= MAX_STEPS + 1
        assert np.array_equal(own[0], original[first])
        same = min(len(own), len(original) - first)
        differ.append(not np.array_equal(own[:same], original[first : first + same]))
    # Not all: to the left of the left wall there is nowhere to go.
    assert np.mean(differ) >= 0.7


def test_some_copies_go_on_without_a_key(
    recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(perturbation, "_MISSING_SHARE", 1.0)
    monkeypatch.setattr(perturbation, "_MISSING_KEYS", {Keys.FIRE: 1})
    (copy,) = perturb_demonstrations([recording], 1, np.random.default_rng(0), lambda: None)
    game = AgentGame(Console())
    game.reset(recording.start)
    expected = [game.observation]
    for frame, action in enumerate(recording.actions):
        if game.end is not None:
            break
        is_perturbed = frame >= copy.first_step * FRAMES_PER_STEP
        game.advance(action_for(keys_for(action) & ~Keys.FIRE) if is_perturbed else action)
        if (frame + 1) % FRAMES_PER_STEP == 0 or game.end is not None:
            expected.append(game.observation)
    mine = np.stack(expected)[copy.first_step : copy.first_step + len(copy.observations)]
    assert np.array_equal(copy.observations, mine)


def test_a_key_that_is_not_pressed_again_is_not_the_missing_one(
    recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(perturbation, "_MISSING_SHARE", 1.0)
    original = trajectory(one_shot := fired_at(recording, 90)).observations
    copies = perturb_demonstrations([one_shot], 5, np.random.default_rng(0), lambda: None)
    assert copies
    for copy in copies:
        first, n = copy.first_step, len(copy.observations)
        assert not np.array_equal(copy.observations, original[first : first + n])


def fired_at(recording: Recording, step: int) -> Recording:
    """Return a game of one shot, in which nothing else is done."""
    steps = [Action.FIRE if number == step else Action.NOOP for number in range(STEPS)]
    return replace(recording, actions=bytes(np.repeat(steps, 4).tolist()), ram_hashes=())


def test_copies_begin_before_the_last_shot(recording: Recording) -> None:
    games = [fired_at(recording, 30), fired_at(recording, 0)]
    copies = perturb_demonstrations(games, 20, np.random.default_rng(0), lambda: None)
    assert {copy.original for copy in copies} == {0}
    assert max(copy.first_step for copy in copies) < 30


def test_the_same_seed_gives_the_same_copies(recording: Recording) -> None:
    one, other = (
        perturb_demonstrations([recording], 3, np.random.default_rng(1), lambda: None)
        for _ in range(2)
    )
    assert [copy.first_step for copy in one] == [copy.first_step for copy in other]
    for a, b in zip(one, other, strict=True):
        assert np.array_equal(a.observations, b.observations)


def test_a_game_too_short_to_be_perturbed_has_no_copies(recording: Recording) -> None:
    short = Recording(recording.start, recording.actions[: 4 * MIN_STEPS])
    assert perturb_demonstrations([short], 3, np.random.default_rng(1), lambda: None) == []


def test_cancelling_stops_at_once(recording: Recording) -> None:
    def stop() -> None:
        raise RunCancelled

    with pytest.raises(RunCancelled):
        perturb_demonstrations([recording], 3, np.random.default_rng(1), stop)

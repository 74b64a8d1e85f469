"""Rewards that are statements: inferred from an order of replayed games, read off their screens."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from trainer.progress import NullProgress
from trainer.reward.check import check_ranking
from trainer.reward.model import RewardModel, RewardNetwork
from trainer.reward.preference_dataset import (
    GameFacts,
    ObservedTrajectory,
    PerfectDemonstrations,
    PreferenceDataset,
)
from trainer.reward.reward_trainer import train_reward_model
from trainer.reward.statements import facts_read, levels_of_facts, understanding_of
from tril.games import game_named
from tril.recipes import RewardRecipe
from tril.recording import Recording, Trajectory, trajectory
from tril.vocabulary import making
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.making import varied_games, vocabulary_of
from tril.vocabulary.trace import trace

GAME = game_named("space_invaders")
CANNON_X = 28
RECIPE = RewardRecipe(method="statement", updates=60, folds=3, aligned=True)
N_GAMES = 14


@pytest.fixture(scope="module")
def words(tmp_path_factory: pytest.TempPathFactory) -> Vocabulary:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(making, "N_GAMES", 8)
        return vocabulary_of(tmp_path_factory.mktemp("data"), GAME)


@pytest.fixture(scope="module")
def games(words: Vocabulary) -> list[tuple[Trajectory, np.ndarray, float]]:
    """Games with their facts and the mean place of the cannon, from left to right."""
    console = GAME.make_console()
    found = []
    for recording in varied_games(GAME, N_GAMES):
        played = trace(recording, console, words.scene)
        place = float(played.memory[:, CANNON_X].mean())
        found.append((trajectory(recording, console), words.facts(played), place))
    return sorted(found, key=lambda one: one[2])


def dataset_of(
    words: Vocabulary, games: list[tuple[Trajectory, np.ndarray, float]], order: list[int]
) -> PreferenceDataset:
    ranked = [games[index] for index in order]
    facts = GameFacts(
        words,
        [one[1] for one in ranked],
        [ranked[0][1]],
        [ObservedTrajectory(one[0].observations, facts=one[1]) for one in games[10:]],
    )
    return PreferenceDataset.from_demonstrations(
        [one[0] for one in ranked],
        [[index] for index in range(len(order))],
        RECIPE,
        PerfectDemonstrations([ranked[0][0]], [0]),
        facts,
    )


def test_what_orders_the_games_is_understood(
    words: Vocabulary, games: list[tuple[Trajectory, np.ndarray, float]]
) -> None:
    understood = understanding_of(dataset_of(words, games, list(range(10))))
    summaries = np.stack([words.summary(facts) for _, facts, _ in games])
    values = understood.value(summaries)
    assert np.corrcoef(values, [place for _, _, place in games])[0, 1] < -0.5
    read = facts_read(understood)
    assert 0 < len(read) <= 96
    assert (np.diff(read) > 0).all()


def test_the_reward_is_a_network_that_is_saved_and_says_how_sure_it_is(
    words: Vocabulary, games: list[tuple[Trajectory, np.ndarray, float]], tmp_path: Path
) -> None:
    dataset = dataset_of(words, games, list(range(10)))
    model = train_reward_model(dataset, 0, NullProgress())
    assert model.spread is not None
    path = tmp_path / "model.safetensors"
    model.save(path)
    again = RewardModel.load(path)
    observations = games[0][0].observations
    judged, expected = again.judge(observations), model.judge(observations)
    assert np.array_equal(judged.rewards, expected.rewards)
    assert judged.deviations is not None
    assert (judged.deviations >= 0).all()
    # Two thirds of the states of the best games are above the worst states of all games.
    assert (model.level(model.score(games[0][0].observations)) > 0).mean() > 0.66
    check, _ = check_ranking(model, dataset, 0, NullProgress())
    assert check.n_as_good is not None
    assert check.held_out_accuracy is not None
    assert set(check.final_levels) == set(range(10))


def test_levels_of_facts_are_on_the_scale_of_the_network(
    words: Vocabulary, games: list[tuple[Trajectory, np.ndarray, float]]
) -> None:
    understanding = understanding_of(dataset_of(words, games, list(range(10))))
    network = RewardNetwork(len(facts_read(understanding)))
    model = RewardModel(network, offset=2.0, scale=4.0, zero=-1.0, one=3.0)
    column = facts_read(understanding)[0]
    facts = np.zeros((3, words.n_facts), np.float32)
    facts[1, column] = 1
    # Counts may exceed 1, which the network does not read.
    facts[2, column] = 7
    levels = levels_of_facts(model, understanding, facts)
    weight = understanding.mean_coefficients()[column]
    assert levels.tolist() == pytest.approx([((w - 2) / 4 + 1) / 4 for w in (0, weight, weight)])


def test_the_same_seed_gives_the_same_network(
    words: Vocabulary, games: list[tuple[Trajectory, np.ndarray, float]]
) -> None:
    dataset = dataset_of(words, games, [0, 3, 6, 9])
    dataset = replace(dataset, recipe=replace(RECIPE, updates=5))
    first, again, other = (
        train_reward_model(dataset, seed, NullProgress()).score(games[2][0].observations)
        for seed in (0, 0, 1)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_a_recording_without_steps_has_no_facts(words: Vocabulary) -> None:
    recording = Recording(GAME, GAME.starts.training[0], bytes(3))
    played = trace(recording, GAME.make_console(), words.scene)
    assert played.n_steps == 0
    assert not words.summary(words.facts(played)).any()

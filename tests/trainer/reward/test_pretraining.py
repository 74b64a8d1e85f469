"""Reading off the screen which aliens are left, and rewards that are linear in it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch.nn import functional as F

from tests.trainer.samples import TIERS, planted_trajectories
from trainer.nn.checkpoints import load_tensors, save_tensors
from trainer.nn.seeding import torch_seeded
from trainer.progress import NullProgress
from trainer.reward.check import check_ranking, jackknife
from trainer.reward.model import Order, RewardModel, RewardNetwork, gaps_between, swept_to
from trainer.reward.preference_dataset import PreferenceDataset
from trainer.reward.pretraining import (
    WEIGHTS,
    pretrained_network,
    read_features,
)
from trainer.reward.reward_trainer import train_reward_model
from tril.demonstrators import play_varied
from tril.demonstrators.space_invaders.player import ScriptedPlayer, draw_style
from tril.errors import Invalid
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import ROW_1
from tril.games.space_invaders.memory import COLUMNS, FRAMES_PER_STEP
from tril.play.episode import Episode
from tril.play.observation import AgentView, Observations
from tril.recipes import RewardRecipe
from tril.recording import Recorder, trajectory

SETTLED_STEPS = 5
"""After a hit, until the alien's explosion is gone."""

PRETRAINED = RewardRecipe(method="posterior", updates=3, fragment_min_steps=4)


@pytest.fixture(scope="module")
def observations() -> Observations:
    rng, console = np.random.default_rng(5), SPACE_INVADERS.make_console()
    return trajectory(play_varied(rng, console).recording, console).observations[::4]


def test_r_from_what_was_read_is_r_from_the_screens(observations: Observations) -> None:
    network = pretrained_network(np.random.default_rng(3))
    model = RewardModel(network, 0.5, 2.0)
    left = read_features(observations)
    assert left.shape == (len(observations), network.output.in_features)
    assert ((left >= 0) & (left <= 1)).all()
    wanted = model.score(observations)
    assert model.score_features(left) == pytest.approx(wanted, abs=1e-5)


def test_the_weights_that_ship_read_the_aliens_off_the_screen() -> None:
    _, metadata = load_tensors(WEIGHTS)
    assert "figures" in metadata
    network = pretrained_network(np.random.default_rng(0))
    console, view = SPACE_INVADERS.make_console(), AgentView(SPACE_INVADERS)
    episode = Episode(console, AtariStart(4))
    view.reset(console)
    observation = np.empty((4, 84, 84), np.uint8)
    view.observe(observation)
    del episode
    screen = torch.from_numpy(observation[None]).float()
    with torch.no_grad():
        second = network.layers[1](F.leaky_relu(network.first(screen)))
        read = network.features(second)
    assert read.shape == (1, network.output.in_features)
    # All aliens are left, so that nothing has been swept.
    assert (read[:, :36] > 0.9).all()
    assert (read[:, 36:] < 0.1).all()


def test_the_weights_that_ship_see_that_a_row_stays_swept() -> None:
    # Networks pretrained on varied play alone read the row's first alien as left again.
    console = SPACE_INVADERS.make_console()
    recorder = Recorder(Episode(console, AtariStart(4)))
    assert ROW_1.target is not None
    rng = np.random.default_rng(2)
    ScriptedPlayer(recorder, ROW_1.target, draw_style(rng), rng).play()
    played = trajectory(recorder.recording(), console)
    assert [hit.cell for hit in played.taken] == list(ROW_1.target)
    swept = -(-played.taken[-1].frame // FRAMES_PER_STEP) + SETTLED_STEPS
    left = read_features(played.observations[swept:])[:, :COLUMNS]
    assert len(left) > 50
    assert (left > 0.5).float().mean() < 0.01


def test_a_row_is_swept_as_far_as_all_aliens_from_its_left_end_are_gone() -> None:
    left = torch.ones(1, 36)
    left[0, [0, 1, 2, 8, 30, 31, 33]] = 0.0
    # Row by row, five values a row: two and three of row 1, two of row 6.
    assert swept_to(left)[0].nonzero().flatten().tolist() == [0, 1, 5 * 5]


@pytest.mark.parametrize("order", [Order.GAPS, Order.SWEEPS])
def test_a_model_is_read_as_it_was_saved(
    tmp_path: Path, observations: Observations, order: Order
) -> None:
    with torch_seeded(np.random.default_rng(1)):
        model = RewardModel(RewardNetwork(36, order))
    path = tmp_path / "model.safetensors"
    model.save(path)
    wanted = model.score(observations[:9])
    assert np.array_equal(RewardModel.load(path).score(observations[:9]), wanted)
    tensors, metadata = load_tensors(path)
    header = json.loads(metadata["model"])
    assert header.pop("order") == order
    # Files from before sweeps have gaps and do not say so.
    save_tensors(path, tensors, metadata | {"model": json.dumps(header)})
    older = RewardModel.load(path).score(observations[:9])
    assert np.array_equal(older, wanted) == (order is Order.GAPS)
    save_tensors(path, tensors, metadata | {"model": json.dumps(header | {"order": "luck"})})
    with pytest.raises(Invalid, match="'luck' is not a valid Order"):
        RewardModel.load(path)


def test_a_gap_is_an_alien_left_whose_right_neighbour_is_gone() -> None:
    left = torch.ones(1, 36)
    left[0, [0, 8, 35]] = 0.0
    # Row by row, five pairs a row: (row 1, column 2) is left of (1, 3), and (5, 5) of (5, 6).
    assert gaps_between(left)[0].nonzero().flatten().tolist() == [1 * 5 + 1, 5 * 5 + 4]


def test_only_the_output_is_learned_and_the_model_is_saved_whole(tmp_path: Path) -> None:
    dataset = PreferenceDataset.from_demonstrations(planted_trajectories(), TIERS, PRETRAINED)
    model = train_reward_model(dataset, 7, NullProgress())
    shipped = pretrained_network(np.random.default_rng(0)).state_dict()
    for name, weight in model.network.state_dict().items():
        assert torch.equal(weight, shipped[name]) != name.startswith("output"), name
    model.save(tmp_path / "model.safetensors")
    loaded = RewardModel.load(tmp_path / "model.safetensors")
    observations = dataset.trajectories[0].observations
    assert np.array_equal(loaded.score(observations), model.score(observations))


def test_the_check_says_how_sure_a_pretrained_reward_is() -> None:
    recipe = replace(PRETRAINED, folds=3, fold_updates=20)
    dataset = PreferenceDataset.from_demonstrations(planted_trajectories(), TIERS, recipe)
    model = train_reward_model(dataset, 3, NullProgress())
    _, checked = check_ranking(model, dataset, 3, NullProgress())
    assert model.spread is None
    assert checked.spread is not None
    assert checked.spread.weight.shape == (3, model.network.output.in_features)
    states = dataset.trajectories[0].observations
    judged = checked.judge(states)
    np.testing.assert_array_equal(judged.rewards, model.score(states))
    assert judged.deviations is not None
    assert (judged.deviations > 0).all()


def test_the_jackknife_is_that_of_its_definition() -> None:
    recipe = replace(PRETRAINED, updates=1)
    dataset = PreferenceDataset.from_demonstrations(planted_trajectories(), TIERS, recipe)
    networks = [pretrained_network(np.random.default_rng(seed)) for seed in range(4)]
    spread = jackknife(networks, dataset)
    assert spread is not None
    states = dataset.trajectories[1].observations
    values = []
    for network in networks:
        alone = RewardModel(network)
        every = [alone.score(dataset.trajectories[i].observations) for i in dataset.ranked]
        values.append(alone.score(states) / np.concatenate(every).std())
    # What all states have in common depends on the offsets.
    apart = np.asarray(values) - np.mean(values, 0)
    shifts = (spread.weight @ read_features(states).T + spread.bias[:, None]).numpy()
    expected = np.sqrt(3 / 4) * (apart - apart[:, :1])
    np.testing.assert_allclose(shifts - shifts[:, :1], expected, atol=1e-3)
    assert jackknife(networks[:1], dataset) is None

import tempfile
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.callbacks import ConvertCallback

from tests.trainer.samples import ELSEWHERE, TINY, observations, random_model
from trainer.nn.devices import CPU, device_of
from trainer.nn.precision import Precision
from trainer.policy.networks import OBSERVATION_SPACE, action_space
from trainer.policy.ppo import ImitationPPO, TrainingGenerators
from trainer.policy.reward_shaping import RewardShaping
from trainer.policy.rollout_buffer import ScreenRolloutBuffer
from trainer.policy.vec_env import TrilVecEnv
from trainer.progress import RunCancelled
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import DEATHS
from tril.play.vector.vector_game import TrainingStarts, VectorGame
from tril.recipes import PolicyRecipe

PLAIN = replace(
    TINY,
    critic_warm_up_steps=0,
    kl_coef=0.0,
    ent_coef=0.01,
    anneal_lr=False,
    n_envs=2,
    network="nature",
)


@pytest.fixture
def env() -> Iterator[TrilVecEnv]:
    games = VectorGame(
        SPACE_INVADERS, 2, TrainingStarts(SPACE_INVADERS), n_processes=1, training_seed=5
    )
    made = TrilVecEnv(games, RewardShaping(random_model(), "level", 5.0))
    yield made
    made.close()


def make_ppo(
    env: TrilVecEnv,
    recipe: PolicyRecipe = PLAIN,
    precision: Precision = Precision.FLOAT32,
    device: torch.device = CPU,
) -> ImitationPPO:
    generators = TrainingGenerators.from_seed(3)
    return ImitationPPO(
        env, recipe, 1000, generators, lambda: None, lambda _: None, precision, device
    )


def fill(buffer: RolloutBuffer) -> None:
    rng = np.random.default_rng(2)
    n_steps = buffer.buffer_size
    screens = observations((n_steps + 1) * 2, seed=8).reshape(-1, 2, 4, 84, 84)
    actions = rng.integers(0, 6, (n_steps, 2))
    rewards = rng.normal(size=(n_steps, 2)).astype(np.float32)
    starts = rng.random((n_steps, 2)) < 0.2
    values = torch.from_numpy(rng.normal(size=(n_steps, 2)).astype(np.float32))
    log_probs = torch.full((2,), -np.log(6.0))
    if isinstance(buffer, ScreenRolloutBuffer):
        buffer.begin(screens[0])
        buffer.episode_starts[:] = starts
        for step in range(n_steps):
            for part in (range(1), range(1, 2)):
                own = slice(part.start, part.stop)
                buffer.put_actions(
                    step, part, actions[step, own], values[step, own], log_probs[own]
                )
                buffer.put_screens(step + 1, part, screens[step + 1, own])
        buffer.put_rewards(rewards)
        np.testing.assert_array_equal(buffer.last_screens, screens[-1])
    else:
        for step in range(n_steps):
            buffer.add(
                screens[step], actions[step], rewards[step], starts[step], values[step], log_probs
            )
    buffer.compute_returns_and_advantage(torch.zeros(2), np.zeros(2, np.bool_))


def fill_rollout(ppo: ImitationPPO) -> None:
    """Fill the buffer, as if the policy had acted on its screens."""
    fill(ppo.rollout_buffer)
    if ppo.recipe.freeze_convolutions:
        with torch.inference_mode():
            ppo._convolved = [ppo._convolve(ppo.rollout_buffer.screens)]


def test_the_buffer_holds_what_stable_baselines3s_holds() -> None:
    ours = ScreenRolloutBuffer(8, OBSERVATION_SPACE, action_space(6), gae_lambda=0.9, n_envs=2)
    theirs = RolloutBuffer(8, OBSERVATION_SPACE, action_space(6), "cpu", gae_lambda=0.9, n_envs=2)
    fill(ours)
    fill(theirs)
    np.testing.assert_array_equal(ours.advantages, theirs.advantages)
    np.testing.assert_array_equal(ours.returns, theirs.returns)
    screens = ours.screens.numpy().reshape(8, 2, 4, 84, 84)
    np.testing.assert_array_equal(screens, theirs.observations)
    seen = []
    for minibatch in ours.minibatches(ours.screens, 6, np.random.default_rng(0)):
        places = minibatch.indices.numpy()
        flat = theirs.observations.reshape(-1, 4, 84, 84)
        np.testing.assert_array_equal(minibatch.inputs.numpy(), flat[places])
        np.testing.assert_array_equal(minibatch.actions, theirs.actions.reshape(-1)[places])
        np.testing.assert_array_equal(minibatch.advantages, theirs.advantages.reshape(-1)[places])
        seen += places.tolist()
    assert sorted(seen) == list(range(16))


def test_the_buffer_keeps_its_memory() -> None:
    buffer = ScreenRolloutBuffer(8, OBSERVATION_SPACE, action_space(6), n_envs=2)
    fill(buffer)
    before = buffer.screens.data_ptr(), buffer.rewards.ctypes.data
    buffer.reset()
    assert not buffer.full
    with pytest.raises(RuntimeError, match="not complete"):
        next(buffer.minibatches(buffer.screens, 4, np.random.default_rng(0)))
    fill(buffer)
    assert (buffer.screens.data_ptr(), buffer.rewards.ctypes.data) == before


def test_an_update_is_that_of_stable_baselines3(env: TrilVecEnv) -> None:
    # One minibatch of the whole rollout, so that its order doesn't matter.
    recipe = replace(PLAIN, n_minibatches=1, n_epochs=3)
    ours = make_ppo(env, recipe)
    theirs = PPO(
        "CnnPolicy",
        env,
        learning_rate=recipe.learning_rate,
        n_steps=recipe.n_steps,
        batch_size=2 * recipe.n_steps,
        n_epochs=3,
        gamma=recipe.gamma,
        gae_lambda=recipe.gae_lambda,
        clip_range=recipe.clip_range,
        ent_coef=recipe.ent_coef,
        vf_coef=recipe.vf_coef,
        max_grad_norm=recipe.max_grad_norm,
        device="cpu",
    )
    theirs.policy.load_state_dict(ours.policy.state_dict())
    theirs._setup_learn(100)
    for model in (ours, theirs):
        fill(model.rollout_buffer)
        model._current_progress_remaining = 1.0
    before = {name: p.detach().clone() for name, p in ours.policy.named_parameters()}
    ours._setup_learn(100, reset_num_timesteps=False)
    ours.train()
    theirs.train()
    expected = dict(theirs.policy.named_parameters())
    for name, parameter in ours.policy.named_parameters():
        assert not torch.equal(parameter, before[name])
        torch.testing.assert_close(parameter, expected[name], rtol=1e-3, atol=3e-5)


def weights_of(ppo: ImitationPPO) -> torch.Tensor:
    return torch.cat([p.detach().flatten() for p in ppo.policy.parameters()])


def test_half_precision_moves_the_policy_the_same_way(env: TrilVecEnv) -> None:
    recipe = replace(PLAIN, n_minibatches=1, n_epochs=1)
    moved = {}
    for precision in Precision:
        ppo = make_ppo(env, recipe, precision)
        fill(ppo.rollout_buffer)
        before = weights_of(ppo)
        ppo._current_progress_remaining = 1.0
        ppo._setup_learn(100, reset_num_timesteps=False)
        # The loss's gradient: Adam's first step keeps little of it but the signs.
        ppo.policy.optimizer = torch.optim.SGD(ppo.policy.parameters(), lr=recipe.learning_rate)
        ppo.train()
        after = weights_of(ppo)
        assert after.dtype == torch.float32
        moved[precision] = after - before
    exact, half = moved[Precision.FLOAT32], moved[Precision.BFLOAT16]
    assert not torch.equal(exact, half)
    assert torch.cosine_similarity(exact, half, dim=0) > 0.99
    assert float(half.norm()) == pytest.approx(float(exact.norm()), rel=0.03)


@pytest.mark.parametrize("freeze_convolutions", [False, True])
def test_a_rollout_is_what_its_actions_lead_to(freeze_convolutions: bool) -> None:
    recipe = replace(PLAIN, n_envs=3, freeze_convolutions=freeze_convolutions)
    shaping = RewardShaping(random_model(), "difference", 5.0)
    games = VectorGame(
        SPACE_INVADERS, 3, TrainingStarts(SPACE_INVADERS), n_processes=1, n_parts=2, training_seed=5
    )
    ppo = make_ppo(TrilVecEnv(games, shaping), recipe)
    n_rollouts = 20
    with games:
        ppo._setup_learn(1000)
        callback = ConvertCallback(lambda *_: True)
        callback.init_callback(ppo)
        buffers = []
        for _ in range(n_rollouts):
            assert ppo.env is not None
            ppo.collect_rollouts(ppo.env, callback, ppo.rollout_buffer, recipe.n_steps)
            buffers.append(deepcopy(ppo.rollout_buffer))
            inputs = ppo._inputs()
            if freeze_convolutions:
                expected = ppo._convolve(buffers[-1].screens)
                torch.testing.assert_close(inputs, expected, rtol=1e-4, atol=1e-4)
    assert ppo.num_timesteps == n_rollouts * 3 * recipe.n_steps
    with VectorGame(
        SPACE_INVADERS, 3, TrainingStarts(SPACE_INVADERS), n_processes=1, training_seed=5
    ) as whole:
        states = whole.reset().copy()
        starts = np.ones(3, np.bool_)
        n_ended = 0
        for buffer in buffers:
            screens = buffer.screens.numpy().reshape(recipe.n_steps, 3, 4, 84, 84)
            for step, row in enumerate(buffer.actions[:, :, 0]):
                np.testing.assert_array_equal(screens[step], states)
                np.testing.assert_array_equal(buffer.episode_starts[step], starts)
                logits, values = ppo.policy.logits_and_values(torch.from_numpy(states))
                log_probs = logits.log_softmax(1)[torch.arange(3), torch.from_numpy(row)]
                np.testing.assert_allclose(buffer.values[step], values.detach(), atol=1e-4)
                np.testing.assert_allclose(buffer.log_probs[step], log_probs.detach(), atol=1e-4)
                played = whole.step(row)
                ended = played.ended[:, None, None, None]
                reached = np.where(ended, played.terminal_observations, played.observations)
                died = np.array([reason in DEATHS for reason in played.ends])
                model = shaping.model
                rewards = shaping.shape(model.score(states), model.score(reached), died)
                np.testing.assert_allclose(buffer.rewards[step], rewards, rtol=1e-3, atol=1e-3)
                states, starts = played.observations.copy(), played.ended
                n_ended += len(played.finished)
            np.testing.assert_array_equal(buffer.last_screens.numpy(), states)
    assert n_ended


def test_actions_are_as_likely_in_the_update_as_in_the_rollout(env: TrilVecEnv) -> None:
    ppo = make_ppo(env, replace(PLAIN, n_minibatches=1, n_epochs=1), Precision.BFLOAT16)
    ppo.learn(16, log_interval=None)  # type: ignore[arg-type]
    assert ppo.update_metrics["kl"] == pytest.approx(0.0, abs=1e-5)
    assert ppo.update_metrics["clip_fraction"] == 0.0


def test_a_training_leaves_nothing_in_the_temporary_folder(
    env: TrilVecEnv, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    make_ppo(env).learn(1)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("precision", Precision)
def test_the_critics_warm_up_leaves_the_policy_as_it_is(
    env: TrilVecEnv, precision: Precision
) -> None:
    ppo = make_ppo(env, replace(PLAIN, critic_warm_up_steps=16), precision)
    before = {name: p.detach().clone() for name, p in ppo.policy.named_parameters()}
    ppo.learn(16, log_interval=None)  # type: ignore[arg-type]
    changed = {n for n, p in ppo.policy.named_parameters() if not torch.equal(p, before[n])}
    assert changed == {"value_net.weight", "value_net.bias"}
    ppo.learn(16, log_interval=None, reset_num_timesteps=False)  # type: ignore[arg-type]
    changed = {n for n, p in ppo.policy.named_parameters() if not torch.equal(p, before[n])}
    assert "action_net.weight" in changed


def test_the_kl_penalty_holds_the_policy_at_its_start(env: TrilVecEnv) -> None:
    moved = {}
    for kl_coef in (0.0, 100.0):
        env.games.close()
        env.games = VectorGame(
            SPACE_INVADERS, 2, TrainingStarts(SPACE_INVADERS), n_processes=1, training_seed=5
        )
        ppo = make_ppo(env, replace(PLAIN, kl_coef=kl_coef, learning_rate=1e-3))
        start = make_ppo(env).policy
        start.load_state_dict(ppo.policy.state_dict())
        ppo.start_policy = start
        ppo.learn(64, log_interval=None)  # type: ignore[arg-type]
        inputs = torch.from_numpy(observations(20))
        with torch.no_grad():
            now = ppo.policy.logits_and_values(inputs)[0].log_softmax(1)
            then = start.logits_and_values(inputs)[0].log_softmax(1)
        moved[kl_coef] = float((then.exp() * (then - now)).sum(1).mean())
    assert moved[100.0] < 0.2 * moved[0.0]


def test_frozen_convolutions_stay_and_the_layers_above_them_learn_the_same(env: TrilVecEnv) -> None:
    frozen = replace(PLAIN, warm_start=True, kl_coef=0.1, freeze_convolutions=True)
    weights = {}
    for recipe in (frozen, replace(frozen, freeze_convolutions=False)):
        ppo = make_ppo(env, recipe)
        # With gradients or without, the convolutions do not change.
        ppo.policy.freeze_convolutions()
        ppo.start_policy = make_ppo(env).policy
        ppo.start_policy.load_state_dict(ppo.policy.state_dict())
        before = {name: p.detach().clone() for name, p in ppo.policy.named_parameters()}
        fill_rollout(ppo)
        ppo._current_progress_remaining = 1.0
        ppo._setup_learn(100, reset_num_timesteps=False)
        ppo.train()
        weights[recipe.freeze_convolutions] = weights_of(ppo)
        changed = {n for n, p in ppo.policy.named_parameters() if not torch.equal(p, before[n])}
        assert {name for name in before if ".cnn." not in name} == changed
    torch.testing.assert_close(weights[True], weights[False], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("freeze_convolutions", [False, True])
def test_an_update_is_computed_where_the_policy_is(
    env: TrilVecEnv, freeze_convolutions: bool
) -> None:
    recipe = replace(PLAIN, kl_coef=0.1, warm_start=True, freeze_convolutions=freeze_convolutions)
    ppo = make_ppo(env, recipe, device=ELSEWHERE)
    ppo.start_policy = ppo.policy
    assert device_of(ppo.policy) == ELSEWHERE
    fill_rollout(ppo)
    inputs = ppo._inputs()
    start_log_probs = ppo._start_log_probs(inputs)
    minibatches = list(ppo.rollout_buffer.minibatches(inputs, 8, np.random.default_rng(0)))
    assert len(minibatches) > 1
    for minibatch in minibatches:
        assert {part.device for part in minibatch} == {ELSEWHERE}
        losses = (ppo._loss(minibatch, start_log_probs, 0.1), ppo._critic_loss(minibatch))
        for loss, stats in losses:
            ppo.policy.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            assert stats.shape == (6,)
            torch.nn.utils.clip_grad_norm_(ppo.policy.parameters(), 0.5)


def test_the_kl_coefficient_falls_to_zero(env: TrilVecEnv) -> None:
    ppo = make_ppo(env, replace(PLAIN, kl_coef=0.4))
    coefficients = []
    for steps in (0, 500, 1000, 1500):
        ppo.num_timesteps = steps
        coefficients.append(ppo.current_kl_coef)
    assert coefficients == pytest.approx([0.4, 0.2, 0.0, 0.0])


@pytest.mark.parametrize("n_calls", [3, 8 + 2])
def test_a_cancelled_run_stops_within_a_step_or_a_minibatch(env: TrilVecEnv, n_calls: int) -> None:
    count = 0

    def on_step() -> None:
        nonlocal count
        count += 1
        if count == n_calls:
            raise RunCancelled

    generators = TrainingGenerators.from_seed(3)
    ppo = ImitationPPO(env, PLAIN, 1000, generators, on_step, lambda _: None)
    with pytest.raises(RunCancelled):
        ppo.learn(1000, log_interval=None)  # type: ignore[arg-type]
    assert count == n_calls
    assert ppo.num_timesteps == min(n_calls, 8) * 2

"""Recipes that a person may type: refused with a sentence, or trained to finite numbers."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import torch
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from stable_baselines3.common.logger import configure

from tests.trainer.samples import observations, random_model
from trainer.nn.checkpoints import NotFinite
from trainer.policy.ppo import ImitationPPO, TrainingGenerators
from trainer.policy.reward_shaping import RewardShaping
from trainer.policy.vec_env import TrilVecEnv
from tril.errors import Invalid
from tril.games.space_invaders import SPACE_INVADERS
from tril.play.vector.vector_game import VectorGame
from tril.recipes import PAPER, Recipe, with_values

SCREENS = observations(64, seed=8)


def untrained(recipe: Recipe, steps: int) -> ImitationPPO:
    """Return a PPO of games that are not played."""
    games = cast("VectorGame", SimpleNamespace(game=SPACE_INVADERS, n_games=recipe.policy.n_envs))
    env = TrilVecEnv(games, RewardShaping.of(random_model(), recipe.policy))
    generators = TrainingGenerators.from_seed(3)
    ppo = ImitationPPO(env, recipe.policy, steps, generators, lambda: None, lambda _: None)
    ppo.set_logger(configure(None, []))
    return ppo


def roll_out(ppo: ImitationPPO, rewards: str) -> None:
    """Fill the buffer as if the games had been played."""
    buffer, rng = ppo.rollout_buffer, np.random.default_rng(2)
    shape = (buffer.buffer_size, buffer.n_envs)

    def screens() -> Any:
        return SCREENS[rng.integers(len(SCREENS), size=buffer.n_envs)]

    buffer.begin(screens())
    log_probs = torch.full((buffer.n_envs,), -np.log(6.0))
    for step in range(shape[0]):
        buffer.episode_starts[step] = rng.random(buffer.n_envs) < 0.2
        actions = rng.integers(0, 6, buffer.n_envs)
        buffer.put_actions(
            step, range(buffer.n_envs), actions, torch.zeros(buffer.n_envs), log_probs
        )
        buffer.put_screens(step + 1, range(buffer.n_envs), screens())
    drawn = {"varied": rng.normal(size=shape), "constant": np.ones(shape), "none": np.zeros(shape)}
    buffer.put_rewards(drawn[rewards].astype(np.float32))
    buffer.compute_returns_and_advantage(torch.zeros(buffer.n_envs), np.ones(buffer.n_envs, bool))
    ppo.num_timesteps += shape[0] * shape[1]
    ppo._update_current_progress_remaining(ppo.num_timesteps, ppo.steps)


def usual(*values: float, odd: tuple[float, ...] = ()) -> st.SearchStrategy[float]:
    """Return a strategy of values of which the odd ones come seldom."""
    return st.sampled_from([*values * 8, *odd])


VALUES = st.fixed_dictionaries(
    {
        "policy.network": st.just("small"),
        "policy.n_envs": st.integers(1, 9),
        "policy.n_steps": st.integers(1, 6),
        "policy.n_minibatches": st.integers(1, 9),
        "policy.n_epochs": st.sampled_from([1, 2]),
        "policy.learning_rate": usual(1e-8, 3e-4, 0.1, 1.0, odd=(0.0, 1e6)),
        "policy.anneal_lr": st.booleans(),
        "policy.gamma": usual(0.0, 0.99, 1.0, odd=(1.01,)),
        "policy.gae_lambda": usual(0.0, 1.0, odd=(-1.0,)),
        "policy.clip_range": usual(0.2, 1.0, 10.0, odd=(0.0,)),
        "policy.ent_coef": usual(0.0, 0.01, 1.0),
        "policy.vf_coef": usual(0.0, 0.5, 10.0),
        "policy.max_grad_norm": usual(1e-6, 0.5, 100.0, odd=(0.0,)),
        "policy.critic_warm_up_steps": st.sampled_from([0, 3, 1000]),
    }
)


@pytest.mark.filterwarnings("ignore:You have specified a mini-batch size")
@settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow], derandomize=True)
@given(
    values=VALUES,
    rewards=st.sampled_from(["varied", "constant", "none"]),
    steps=st.sampled_from([1, 50]),
)
def test_a_plausible_recipe_is_refused_or_trains_to_finite_numbers(
    values: dict[str, Any], rewards: str, steps: int
) -> None:
    try:
        recipe = with_values(PAPER, values)
    except Invalid:
        return
    ppo = untrained(recipe, steps)
    for _ in range(2):
        roll_out(ppo, rewards)
        try:
            ppo.train()
        except NotFinite:
            # Only what nobody would choose diverges, and says so before it changes the policy.
            assert recipe.policy.learning_rate >= 0.1
        assert all(p.isfinite().all() for p in ppo.policy.parameters())


@pytest.mark.filterwarnings("ignore:You have specified a mini-batch size")
@pytest.mark.parametrize("minibatches", [3, 5])
def test_a_last_minibatch_of_one_step_leaves_the_policy_finite(minibatches: int) -> None:
    values = {"network": "small", "n_envs": 8, "n_steps": 2, "n_minibatches": minibatches}
    ppo = untrained(with_values(PAPER, {f"policy.{k}": v for k, v in values.items()}), 1000)
    assert 16 % ppo.batch_size == 1
    roll_out(ppo, "varied")
    ppo.train()
    assert all(p.isfinite().all() for p in ppo.policy.parameters())


def test_the_learning_rate_does_not_fall_below_zero_in_the_last_rollout() -> None:
    ppo = untrained(with_values(PAPER, {"policy.network": "small", "policy.anneal_lr": True}), 10)
    assert ppo.lr_schedule(-5.0) == 0.0


@pytest.mark.filterwarnings("ignore:You have specified a mini-batch size")
def test_rewards_that_are_no_numbers_end_the_training_before_the_policy_learns() -> None:
    ppo = untrained(with_values(PAPER, {"policy.network": "small", "policy.n_steps": 2}), 1000)
    roll_out(ppo, "varied")
    ppo.rollout_buffer.returns[0, 0] = np.nan
    with pytest.raises(NotFinite, match="Learning has diverged"):
        ppo.train()
    assert all(p.isfinite().all() for p in ppo.policy.parameters())


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"policy.n_envs": 4, "policy.n_steps": 1, "policy.n_minibatches": 3}, "more than half"),
        ({"policy.n_envs": 4096, "policy.n_steps": 128}, "what fits into memory"),
        ({"policy.learning_rate": 3.0}, "policy.learning_rate must be at most 1, got 3.0"),
        ({"policy.reward_scale": 1e30}, "policy.reward_scale must be at most 1,000, got 1e"),
        ({"reward.fragment_min_steps": 101}, "fragment_min_steps must not be more than"),
        ({"reward.folds": 1}, "or at least 2"),
        ({"evaluation.start_numbers": ()}, "must name a start"),
        ({"evaluation.start_numbers": (0, 0)}, "no start twice"),
        ({"evaluation.start_numbers": (3,)}, "no start twice"),
        ({"policy.n_epochs": 10**30}, "policy.n_epochs must be a whole number from 1 to"),
    ],
)
def test_what_cannot_work_is_refused_where_it_is_typed(values: dict[str, Any], said: str) -> None:
    with pytest.raises(Invalid, match=said):
        with_values(PAPER, values)

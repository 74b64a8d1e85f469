"""Values of recipes for tests."""

from __future__ import annotations

SMALLEST = (
    "reward.updates=12",
    "reward.folds=2",
    "reward.fold_updates=3",
    "cloning.epochs=1",
    "policy.n_envs=4",
    "policy.n_steps=16",
    "policy.n_minibatches=2",
    "policy.n_epochs=1",
    "policy.critic_warm_up_steps=0",
    "policy.snapshot_episodes=1",
    "evaluation.start_numbers=0,",
    "evaluation.further_start_numbers=7,",
)
"""Changes of ``fast`` for ``--set``: every stage, at its smallest."""

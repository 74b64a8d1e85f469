"""Attention maps by occlusion: what a network looks at in a state (thesis, section 6.1).

A 3x3 patch of the game's background occludes each place of each of an observation's four screens.
The absolute change of R, or of the odds of a policy's action, is added to the nine pixels under the
patch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch

from trainer.explain.occlusion import PATCH, OccludedOutputs
from trainer.explain.subject import Subject
from trainer.progress import NullProgress, Progress
from trainer.reward.model import RewardModel
from tril.analysis.outcome import AttentionState
from tril.play.observation import OBSERVATION_SHAPE

POSITIONS = OBSERVATION_SHAPE[1] - PATCH + 1
"""Positions per side of patches that lie inside the screen; T-REX's code omits the last two."""

BATCH = 128
"""Occluded observations per forward pass."""


@dataclass(frozen=True)
class NamedState:
    """A state of a demonstration, chosen by its reward.

    Attributes:
        name: Name of the state in the thesis.
        trajectory: Index of the trajectory.
        step: Index of the observation in it; 0 is the start.
        reward: R of the observation.
    """

    name: AttentionState
    trajectory: int
    step: int
    reward: float


def pick_states(rewards: Sequence[npt.NDArray[np.float32]]) -> tuple[NamedState, ...]:
    """Return the states of minimum, 90th and 95th percentile, and maximum R (thesis, section 6.1).

    Args:
        rewards: For each ranked demonstration R of its observations, float32 (T + 1,).

    Returns:
        The states in the order of AttentionState; of equal rewards the earliest comes first.
    """
    states = states_at(rewards, [name.quantile for name in AttentionState])
    return tuple(
        NamedState(name, *state) for name, state in zip(AttentionState, states, strict=True)
    )


def states_at(
    rewards: Sequence[npt.NDArray[np.float32]], quantiles: Sequence[float]
) -> list[tuple[int, int, float]]:
    """Return the states at quantiles, 0 to 1, of R: trajectory, step and R of each.

    Args:
        rewards: As in pick_states.
        quantiles: Quantiles of the rewards of all states together.
    """
    if not rewards or not sum(len(part) for part in rewards):
        raise ValueError("Expected at least one state to pick from.")
    values = np.concatenate(rewards)
    origins = [(i, step) for i, part in enumerate(rewards) for step in range(len(part))]
    order = np.argsort(values, kind="stable")
    places = [int(order[round(quantile * (len(values) - 1))]) for quantile in quantiles]
    return [(*origins[at], float(values[at])) for at in places]


def attention_map(
    subject: Subject,
    observation: npt.NDArray[np.uint8],
    progress: Progress | None = None,
    background: int = 0,
) -> npt.NDArray[np.float32]:
    """Return the attention map of a network in one state.

    Patches that change no pixel are skipped. Of a reward model only what a patch changes of the
    first two layers is recomputed (see OccludedOutputs), which equals brute force up to rounding.

    Args:
        subject: Subject to explain; of a reward model it is its raw R.
        observation: uint8 (4, 84, 84).
        progress: Counts patches.
        background: Gray of the screen's background, 0 to 255.

    Returns:
        float32 (4, 84, 84), non-negative, one map per screen; the published map is their sum.

    Raises:
        ValueError: The observation has another shape or dtype.
    """
    if observation.shape != OBSERVATION_SHAPE or observation.dtype != np.uint8:
        raise ValueError(
            f"Expected an observation uint8 {OBSERVATION_SHAPE}, got {observation.dtype}"
            f" {observation.shape}."
        )
    positions = changing_positions(observation, background)
    progress = progress or NullProgress()
    if isinstance(subject, RewardModel):
        return spread(positions, changes_at(subject, observation, positions, progress, background))
    changes = _brute_force_changes(subject, observation, positions, progress, background)
    return spread(positions, changes)


def changes_at(
    model: RewardModel,
    observation: npt.NDArray[np.uint8],
    positions: npt.NDArray[np.int64],
    progress: Progress,
    background: int = 0,
) -> npt.NDArray[np.float32]:
    """Return the absolute change of R for each patch, float32 (N,).

    The patches are int64 (N, 3): screen, row, column.
    """
    changes = np.empty(len(positions), np.float32)
    with torch.inference_mode():
        pixels = torch.from_numpy(observation.astype(np.float32))
        outputs = OccludedOutputs(model.network, pixels, background)
        plain = model.of_output(outputs.plain)
        for begin in range(0, len(positions), BATCH):
            part = positions[begin : begin + BATCH]
            difference = (model.of_output(outputs.at(part)) - plain).abs()
            changes[begin : begin + BATCH] = difference.numpy()
            progress.advance(min(begin + BATCH, len(positions)), len(positions))
    return changes


def _brute_force_changes(
    subject: Subject,
    observation: npt.NDArray[np.uint8],
    positions: npt.NDArray[np.int64],
    progress: Progress,
    background: int = 0,
) -> npt.NDArray[np.float32]:
    """Return the same as ``changes_at`` for any subject, scoring whole observations."""
    changes = np.empty(len(positions), np.float32)
    plain = subject.score(observation[None])[0]
    for begin in range(0, len(positions), BATCH):
        part = positions[begin : begin + BATCH]
        occluded = np.repeat(observation[None], len(part), axis=0)
        for target, (screen, row, column) in zip(occluded, part.tolist(), strict=True):
            target[screen, row : row + PATCH, column : column + PATCH] = background
        changes[begin : begin + BATCH] = np.abs(subject.score(occluded) - plain)
        progress.advance(begin + len(part), len(positions))
    return changes


def changing_positions(
    observation: npt.NDArray[np.uint8], background: int = 0
) -> npt.NDArray[np.int64]:
    """Return the patches that change the observation: int64 (N, 3) of screen, row, column."""
    differs = observation != background
    windows = np.lib.stride_tricks.sliding_window_view(differs, (PATCH, PATCH), axis=(1, 2))
    return np.argwhere(windows.any(axis=(-2, -1)))


def spread(
    positions: npt.NDArray[np.int64], changes: npt.NDArray[np.float32]
) -> npt.NDArray[np.float32]:
    """Add each patch's change to the nine pixels under it; float32 (4, 84, 84)."""
    at_corner = np.zeros((OBSERVATION_SHAPE[0], POSITIONS, POSITIONS), np.float64)
    at_corner[tuple(positions.T)] = changes
    result = np.zeros(OBSERVATION_SHAPE, np.float64)
    for row in range(PATCH):
        for column in range(PATCH):
            result[:, row : row + POSITIONS, column : column + POSITIONS] += at_corner
    return result.astype(np.float32)

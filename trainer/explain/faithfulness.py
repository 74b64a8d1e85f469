"""How faithful an attention map is: the deletion and insertion tests of Petsiuk et al. (2018, 4.1).

Pixels that are not background in every screen are replaced by background, or put into an empty
screen, the most important first. R is no probability, so the area is not that under R: it is the
mean over 21 points of the absolute difference from the value of the whole state. Deletion should
make it large early, insertion small early. A random order is what a map without meaning scores.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from trainer.explain.subject import Subject
from tril.analysis.outcome import Faithfulness, MeasuredOrder
from tril.play.observation import Observation

POINTS = 20
"""Parts into which the pixels are deleted or inserted."""
BRIGHTEST = 0.2
"""Share of the pixels whose effect is told in words."""
N_RANDOM = 4
"""Random orders that a map is compared with."""

Map = npt.NDArray[np.float32]
Pixels = npt.NDArray[np.int64]


def occupied_pixels(observation: Observation, background: int = 0) -> Pixels:
    """Return the pixels that are not background in every screen, int64 (N, 2): row and column."""
    return np.argwhere((observation != background).any(0))


def order_of(values: Map, pixels: Pixels) -> Pixels:
    """Return pixels in the order of a map's values, float32 (84, 84), the largest first."""
    return pixels[np.argsort(-values[tuple(pixels.T)], kind="stable")]


def differences(
    subject: Subject, observation: Observation, order: Pixels, *, insert: bool, background: int = 0
) -> npt.NDArray[np.float64]:
    """Return the deviation from the whole state's value while pixels change in an order.

    Args:
        subject: Subject to explain.
        observation: uint8 (4, 84, 84).
        order: The pixels, the most important first.
        insert: Whether they are put into an empty screen, instead of deleted.
        background: Gray of the screen's background, 0 to 255.

    Returns:
        float64 (POINTS + 1,), non-negative, from no pixels changed to all of them.
    """
    changed = np.repeat(observation[None], POINTS + 1, axis=0)
    if insert:
        changed[:] = background
    for target, count in zip(
        changed, np.linspace(0, len(order), POINTS + 1).astype(int), strict=True
    ):
        rows, columns = order[:count].T
        target[:, rows, columns] = observation[:, rows, columns] if insert else background
    values = subject.score(np.concatenate([changed, observation[None]])).astype(np.float64)
    return np.asarray(np.abs(values[:-1] - values[-1]), np.float64)


def measure_faithfulness(
    subject: Subject,
    observation: Observation,
    values: Map,
    scale: float,
    rng: np.random.Generator,
    background: int = 0,
) -> Faithfulness | None:
    """Measure a map against random orders.

    Args:
        subject: Subject of the map.
        observation: uint8 (4, 84, 84).
        values: The map, float32 (84, 84).
        scale: The change that counts as 1: of a reward model from how demonstrations begin to how
            the best ones end. What changes when everything is hidden is no unit: an empty screen
            may be as good as this one.
        rng: Draws the random orders.
        background: Gray of the screen's background, 0 to 255.

    Returns:
        The measurement; None if the screens are empty.
    """
    pixels = occupied_pixels(observation, background)
    if not len(pixels):
        return None
    drawn = [rng.permutation(pixels) for _ in range(N_RANDOM)]
    orders = [order_of(values, pixels), *drawn]
    deleted, inserted = (
        [
            differences(subject, observation, order, insert=insert, background=background)
            for order in orders
        ]
        for insert in (False, True)
    )
    measured = [
        MeasuredOrder(
            deletion=float(deletion.mean() / scale),
            insertion=float(insertion.mean() / scale),
            hidden_fifth=float(deletion[round(BRIGHTEST * POINTS)] / scale),
        )
        for deletion, insertion in zip(deleted, inserted, strict=True)
    ]
    return Faithfulness(map=measured[0], random=_mean(measured[1:]))


def _mean(orders: list[MeasuredOrder]) -> MeasuredOrder:
    values = [order.model_dump() for order in orders]
    return MeasuredOrder(**{key: float(np.mean([v[key] for v in values])) for key in values[0]})

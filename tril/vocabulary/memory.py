"""Bytes of memory: which of them tell a place on the screen, and what goes with the others.

A byte tells a place if the place can be predicted from it in games that the prediction was not
made from: by a line, or by any table of its values. Consoles keep places as tables of their own; a
2600 has a coarse step in one nibble and a fine one, the other way round, in the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tril.vocabulary.groups import IN_ORDER, Axis, Group, Sign, Twin, binned, edges_of
from tril.vocabulary.kinds import Array, Places

MEMORY_BINS = 8
SLOW_SHARE = 0.1
"""A byte that changes in fewer of the steps is slow: its bits are states, as of what is left."""
MIN_STEPS_SEEN = 100
"""In which a thing is there, of each half of the games."""
MIN_VALUES = 4
"""Of a byte that tells a place; fewer are states."""
LEAST_EXPLAINED = 0.85
"""Share of the variance of a place, in games that the prediction was not made from, from which on
a byte tells it."""
LEAST_KNOWN = 0.5
"""Share of the steps of those games in which the byte has a value that was seen in the others."""
LINEAR_CORRELATION = 0.9
"""Between a byte and the place that it tells, from which on one grows with the other."""
LEAST_CORRELATION = 0.4
"""Between a fact of a byte and what goes with it."""
RAREST_FACT = 0.002
"""Share of the steps: what is rarer, or rarer absent, goes with nothing."""

SEEN = ("thing", "pieces", "formation", "button")
"""Sources of facts that may go with a byte."""

Bytes = npt.NDArray[np.uint8]


def memory_groups(memory: Sequence[Bytes], at: Sequence[Places]) -> list[Group]:
    """Return the groups of facts about bytes that change.

    A byte that tells a place has no bits, and its rises and falls say nothing unless the place
    grows with it.

    Args:
        memory: Memory of each game, uint8 (n_steps, n_bytes).
        at: Places of the things in each game.
    """
    together = np.concatenate(memory)
    varying = [byte for byte in range(together.shape[1]) if np.ptp(together[:, byte])]
    twins = _twins(memory, at, varying)
    groups: list[Group] = []
    for byte in varying:
        values, twin = together[:, byte], twins.get(byte)
        if twin is not None:
            told = twin.places(values)
            edges = edges_of(told[~np.isnan(told)], MEMORY_BINS)
            groups.append(Group("memory", (byte,), "value", edges, twin))
            if twin.direction:
                groups.append(Group("memory", (byte,), "changes", twin=twin))
            continue
        edges = edges_of(values.astype(np.float64), MEMORY_BINS)
        groups.append(Group("memory", (byte,), "value", edges))
        groups.append(Group("memory", (byte,), "changes"))
        if (values[1:] != values[:-1]).mean() < SLOW_SHARE:
            groups.append(Group("memory", (byte,), "bits"))
    return groups


def facts_of_byte(group: Group, values: Bytes) -> Array:
    """Return the facts of a byte in every step, float32 (n_steps, n_facts)."""
    if group.aspect == "value":
        told = values.astype(np.float32) if group.twin is None else group.twin.places(values)
        return binned(told, group.edges)
    if group.aspect == "bits":
        return (values[:, None] >> np.arange(8, dtype=np.uint8) & 1).astype(np.float32)
    change = np.diff(values.astype(np.int64), prepend=values[:1])
    return np.stack([change > 0, change < 0, np.abs(change) > 1], 1).astype(np.float32)


def with_signs(
    groups: Sequence[Group], columns: Sequence[npt.NDArray[np.int64]], facts: Sequence[Array]
) -> tuple[Group, ...]:
    """Return the groups, those of bytes that tell no place with what goes with their facts.

    That is the fact of what is seen, or of a button, in the same step or one beside it, whose
    correlation is the highest in the worse half of the games.

    Args:
        groups: All groups of a vocabulary.
        columns: Columns of each group's facts.
        facts: Facts of every step of each game, float32 (n_steps, n_facts).
    """
    unseen = [i for i, group in enumerate(groups) if group.source == "memory" and not group.twin]
    seen = [
        i for i, group in enumerate(groups) if group.source in SEEN and group.aspect not in IN_ORDER
    ]
    if not unseen or not seen:
        return tuple(groups)
    of_unseen = np.concatenate([columns[i] for i in unseen])
    of_seen = np.concatenate([columns[i] for i in seen])
    place = [(groups[i], fact) for i in seen for fact in range(groups[i].n_facts)]
    best = np.zeros((len(of_unseen), len(of_seen)))
    for lag in (0, -1, 1):
        halves = [
            _correlations(
                np.concatenate([_shifted(game[:, of_unseen], lag) for game in facts[half::2]]),
                np.concatenate([_shifted(game[:, of_seen], -lag) for game in facts[half::2]]),
            )
            for half in range(2)
        ]
        agreed = np.where(np.sign(halves[0]) == np.sign(halves[1]), np.sign(halves[0]), 0.0)
        agreed *= np.minimum(np.abs(halves[0]), np.abs(halves[1]))
        best = np.where(np.abs(agreed) > np.abs(best), agreed, best)
    signs: list[Sign | None] = []
    for row in best:
        index = int(np.abs(row).argmax())
        about, fact = place[index]
        is_found = abs(row[index]) >= LEAST_CORRELATION
        signs.append(Sign(about, fact, round(float(row[index]), 3)) if is_found else None)
    result = list(groups)
    begin = 0
    for i in unseen:
        of_group = tuple(signs[begin : begin + groups[i].n_facts])
        begin += groups[i].n_facts
        if any(of_group):
            result[i] = replace(groups[i], signs=of_group)
    return tuple(result)


def _shifted(facts: Array, lag: int) -> Array:
    """Return the steps of a game without the last one, or without the first one where lag is 1."""
    return facts[1:] if lag > 0 else facts[:-1] if lag < 0 else facts


def _correlations(left: Array, right: Array) -> npt.NDArray[np.float64]:
    """Return the correlation of each pair of columns, float64 (n_left, n_right); 0 if rare."""
    columns = []
    for part in (left, right):
        mean = part.mean(0)
        deviation = part.std(0)
        is_rare = (np.minimum(mean, 1 - mean) < RAREST_FACT) | (deviation == 0)
        scaled = (part - mean) / np.where(deviation > 0, deviation, 1)
        columns.append(scaled * ~is_rare)
    product: npt.NDArray[np.float64] = (columns[0].T @ columns[1]).astype(np.float64) / len(left)
    return product


def _twins(
    memory: Sequence[Bytes], at: Sequence[Places], varying: Sequence[int]
) -> dict[int, Twin]:
    """Return the place that each byte tells best, for bytes that tell one."""
    best: dict[int, tuple[float, Twin]] = {}
    axes: tuple[Axis, ...] = ("x", "y")
    for axis in axes:
        for kind in range(at[0].count.shape[1]):
            halves = [
                _Seen.of(memory[half::2], at[half::2], varying, kind, axis) for half in range(2)
            ]
            if min(len(half.place) for half in halves) < MIN_STEPS_SEEN:
                continue
            if min(half.place.std() for half in halves) < 1:
                continue
            for column, byte in enumerate(varying):
                found = _twin_of(kind, axis, halves, column)
                if found is not None and found[0] > best.get(byte, (0.0,))[0]:
                    best[byte] = found
    return {byte: twin for byte, (_, twin) in best.items()}


@dataclass(frozen=True)
class _Seen:
    """The steps of some games in which there is a thing of a kind.

    Attributes:
        values: Bytes that vary, uint8 (n, n_varying).
        place: Coordinate of the thing in pixels, float64 (n,).
    """

    values: Bytes
    place: npt.NDArray[np.float64]

    @classmethod
    def of(
        cls,
        memory: Sequence[Bytes],
        at: Sequence[Places],
        varying: Sequence[int],
        kind: int,
        axis: Axis,
    ) -> _Seen:
        if not memory:
            return cls(np.empty((0, len(varying)), np.uint8), np.empty(0))
        place = np.concatenate([getattr(found, axis)[:, kind] for found in at])
        seen = ~np.isnan(place)
        values = np.concatenate([of_game[:, varying] for of_game in memory])
        return cls(values[seen], place[seen].astype(np.float64))


def _twin_of(
    kind: int, axis: Axis, halves: Sequence[_Seen], column: int
) -> tuple[float, Twin] | None:
    """Return how well a byte tells a place, and the place; None if it does not."""
    values = np.concatenate([half.values[:, column] for half in halves])
    place = np.concatenate([half.place for half in halves])
    if len(np.unique(values)) < MIN_VALUES:
        return None
    correlation = float(np.corrcoef(values, place)[0, 1])
    direction = int(np.sign(correlation)) if abs(correlation) >= LINEAR_CORRELATION else 0
    make = _line if direction else _table
    explained = 1.0
    for known, other in (halves, halves[::-1]):
        table = make(known.values[:, column], known.place)
        told = table[other.values[:, column]]
        known_too = ~np.isnan(told)
        if known_too.mean() < LEAST_KNOWN:
            return None
        error, place_there = (told - other.place)[known_too], other.place[known_too]
        explained = min(explained, 1 - float((error**2).mean() / max(place_there.var(), 1.0)))
    if explained < LEAST_EXPLAINED:
        return None
    table = np.round(make(values, place), 1)
    return explained, Twin(kind, axis, tuple(table.tolist()), direction)


def _line(values: Bytes, place: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the place by the byte's value, float64 (256,), on the line that fits best."""
    x = values.astype(np.float64)
    if not x.std():
        return np.full(256, place.mean())
    slope, offset = np.polyfit(x, place, 1)
    line: npt.NDArray[np.float64] = slope * np.arange(256) + offset
    return line


def _table(values: Bytes, place: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the mean place by the byte's value, float64 (256,); NaN for values never seen."""
    count = np.bincount(values, minlength=256)
    with np.errstate(invalid="ignore", divide="ignore"):
        means: npt.NDArray[np.float64] = np.bincount(values, place, 256) / count
    return means

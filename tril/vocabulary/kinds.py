"""Kinds of things: blobs of one colour and about one size, and where they are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np
import numpy.typing as npt

from tril.games.things import Thing
from tril.vocabulary.blobs import Blobs, box_of
from tril.vocabulary.trace import Trace

Array = npt.NDArray[np.float32]

MAX_KINDS = 20
MIN_SHARE = 0.03
"""Of the steps in which a kind of things is there; rarer ones are no kind."""
SIZES_PER_DOUBLING = 1.5
"""Sizes are of one kind within a factor of 2^(1/1.5), 1.6."""

MIN_LOOK_SHARE = 0.005
"""Of the steps in which a look is seen that may be one of several of a thing."""
SINGLE_SHARE = 0.8
"""Of the steps in which a look is seen, those with one of it, for it to be a single thing."""
MOST_TOGETHER = 0.05
"""Of the steps of the rarer of two looks of a thing, those in which both are there."""
MIN_CHANGES = 5
CONTINUED_SHARE = 0.5
"""Of the comings or goings of a look, those that continue another's track, to be one thing."""
MOST_GAP_PX = 4
"""Between where two looks are, in successive steps, to be one thing."""

MOST_APART_PX = 8
"""Between a kind and a thing that the game names, to be the same in a step."""
SAME_SHARE = 0.7
"""Of the steps in which both are there."""
MIN_STEPS_SAME = 30

PART_SHARE = 0.95
"""Of the steps in which a thing is there, those in which a part of it is there, at its place."""

MIN_EXPLAINED = 0.05
"""Share of a kind's motion that the buttons explain, from which on it is what the player steers."""
AGAINST = 0.2
"""Standard deviations of a motion by which its mean has to go against the buttons, as scenery's."""
_WAYS: Mapping[str, tuple[str, str]] = {"x": ("left", "right"), "y": ("up", "down")}
"""Buttons to lower and to higher places."""
MOST_STEP_PX = 32
"""What moves further in one step is not the same thing, or began anew."""


@dataclass(frozen=True)
class Look:
    """How a thing looks: its colour and its size.

    Attributes:
        colour: Number of the colour.
        width: Bounds of the width in pixels.
        height: Bounds of the height.
    """

    colour: int
    width: tuple[int, int]
    height: tuple[int, int]

    def fits(self, blobs: Blobs) -> npt.NDArray[np.bool_]:
        """Return which blobs look like this."""
        is_like: npt.NDArray[np.bool_] = (
            (blobs["colour"] == self.colour)
            & (blobs["width"] >= self.width[0])
            & (blobs["width"] <= self.width[1])
            & (blobs["height"] >= self.height[0])
            & (blobs["height"] <= self.height[1])
        )
        return is_like


@dataclass(frozen=True)
class Kind:
    """Things that look alike, or one thing with the looks that it has at different times.

    Attributes:
        looks: Its looks, the most frequent first.
        name: Key of the thing among those that the game itself names; None if it is none of them.
    """

    looks: tuple[Look, ...]
    name: str | None = None

    def members(self, blobs: Blobs) -> npt.NDArray[np.bool_]:
        """Return which blobs are of this kind."""
        is_member: npt.NDArray[np.bool_] = np.logical_or.reduce(
            [look.fits(blobs) for look in self.looks]
        )
        return is_member


@dataclass(frozen=True)
class Places:
    """Where the things of each kind are, float32 (n_steps, n_kinds); NaN where there are none.

    Attributes:
        count: How many there are.
        x: Mean of their centres.
        y: The same, downwards.
    """

    count: Array
    x: Array
    y: Array


def find_kinds(traces: Sequence[Trace]) -> tuple[Kind, ...]:
    """Find the kinds of things in varied play, the most frequent first."""
    n_steps = sum(played.n_steps for played in traces)
    first = np.cumsum([0, *(played.n_steps for played in traces)])
    blobs = np.concatenate([played.blobs for played in traces])
    # The step among those of all games.
    moment = np.concatenate(
        [played.blobs["step"] + begin for played, begin in zip(traces, first[:-1], strict=True)]
    )
    size = np.stack([blobs["width"], blobs["height"]], 1).astype(np.float64)
    size_class = np.round(np.log2(size) * SIZES_PER_DOUBLING)
    looks = np.column_stack([blobs["colour"], size_class])
    _, look_of = np.unique(looks, axis=0, return_inverse=True)
    look_of = look_of.ravel()
    sightings: list[_Sighting] = []
    for index in np.unique(look_of):
        mine = look_of == index
        sighting = _Sighting.of(blobs[mine], moment[mine], n_steps)
        if sighting.share >= MIN_LOOK_SHARE:
            sightings.append(sighting)
    sightings.sort(key=lambda sighting: -sighting.share)
    is_first = np.zeros(n_steps, np.bool_)
    # A game that was over within its first step has none.
    begins = first[:-1]
    is_first[begins[begins < n_steps]] = True
    joined = [thing for thing in _joined(sightings, is_first) if thing.share >= MIN_SHARE]
    joined.sort(key=lambda thing: -thing.share)
    return tuple(Kind(thing.looks) for thing in _without_parts(joined)[:MAX_KINDS])


@dataclass(frozen=True)
class _Sighting:
    """Where things of some looks are seen in all steps of varied play.

    Attributes:
        looks: The looks, the most frequent first.
        count: How many there are in each step, int64 (n_steps,).
        box: Left, top, right and bottom edge of one in each step, float32 (n_steps, 4).
    """

    looks: tuple[Look, ...]
    count: npt.NDArray[np.int64]
    box: Array

    @classmethod
    def of(cls, blobs: Blobs, moment: npt.NDArray[np.int64], n_steps: int) -> _Sighting:
        look = Look(
            int(blobs["colour"][0]),
            (int(blobs["width"].min()), int(blobs["width"].max())),
            (int(blobs["height"].min()), int(blobs["height"].max())),
        )
        left, top = box_of(blobs)
        box = np.full((n_steps, 4), np.nan, np.float32)
        box[moment] = np.stack([left, top, left + blobs["width"], top + blobs["height"]], 1)
        return cls((look,), np.bincount(moment, minlength=n_steps), box)

    def __add__(self, other: _Sighting) -> _Sighting:
        box = np.where(np.isnan(self.box), other.box, self.box)
        return _Sighting(self.looks + other.looks, self.count + other.count, box)

    @cached_property
    def is_there(self) -> npt.NDArray[np.bool_]:
        """In which steps there is one, bool (n_steps,)."""
        is_there: npt.NDArray[np.bool_] = self.count > 0
        return is_there

    @cached_property
    def share(self) -> float:
        """Share of the steps in which there is one."""
        return float(self.is_there.mean())

    @cached_property
    def is_single(self) -> bool:
        """Whether there is hardly ever more than one."""
        return float((self.count[self.is_there] == 1).mean()) >= SINGLE_SHARE

    def continues(self, other: _Sighting, is_first: npt.NDArray[np.bool_]) -> bool:
        """Return whether it is the same thing as another one.

        They are hardly ever there at once, and where this one comes, or where it goes, the other
        one goes or comes at the same place, more often than not.

        Args:
            other: The other one.
            is_first: Which steps are the first of a game.
        """
        here, there = self.is_there, other.is_there
        if (here & there).sum() > MOST_TOGETHER * min(here.sum(), there.sum()):
            return False
        before, after = slice(None, -1), slice(1, None)
        for old, new in ((before, after), (after, before)):
            changes = np.flatnonzero(here[new] & ~here[old] & ~is_first[1:])
            least = CONTINUED_SHARE * len(changes)
            if len(changes) >= MIN_CHANGES and there[old][changes].sum() > least:
                gap = _gap(self.box[new][changes], other.box[old][changes])
                if (gap <= MOST_GAP_PX).sum() > least:
                    return True
        return False

    def is_part_of(self, other: _Sighting) -> bool:
        """Return whether it moves with one that is seen as often, at its edge.

        Args:
            other: The other one.
        """
        least, most = sorted((self.share, other.share))
        if least < PART_SHARE * most:
            return False
        both = self.is_there & other.is_there
        if both.mean() < PART_SHARE * most:
            return False
        ours, others = self.box[both], other.box[both]
        apart = ours[:, :2] - others[:, :2]
        return bool(
            max(others[:, 0].std(), others[:, 1].std()) >= 1
            and (np.abs(apart - np.median(apart, axis=0)).max(1) <= 1).mean() >= PART_SHARE
            and np.median(_gap(ours, others)) <= MOST_GAP_PX
        )


def _gap(boxes: Array, others: Array) -> Array:
    """Return the gap between boxes, float32 (n,), 0 or less where they touch; NaN: not there."""
    gap: Array = np.maximum(boxes[:, :2] - others[:, 2:], others[:, :2] - boxes[:, 2:]).max(1)
    return gap


def _joined(sightings: Sequence[_Sighting], is_first: npt.NDArray[np.bool_]) -> list[_Sighting]:
    """Return things, of which one at several sizes or in several colours is one.

    Args:
        sightings: The looks, the most frequent first.
        is_first: Which steps are the first of a game.
    """
    joined = list(sightings)
    while pair := next(_same_things(joined, is_first), None):
        index, other = pair
        joined[index] = joined[index] + joined.pop(other)
    return joined


def _same_things(
    things: Sequence[_Sighting], is_first: npt.NDArray[np.bool_]
) -> Iterator[tuple[int, int]]:
    """Yield pairs of indices of what is the same thing, the more frequent one first."""
    single = [index for index, thing in enumerate(things) if thing.is_single]
    for index, other in combinations(single, 2):
        one, rarer = things[index], things[other]
        if rarer.continues(one, is_first) or one.continues(rarer, is_first):
            yield index, other


def _without_parts(things: Sequence[_Sighting]) -> list[_Sighting]:
    """Return things without those that are parts of another: one is drawn in several colours."""
    whole: list[_Sighting] = []
    for thing in things:
        if not (thing.is_single and any(thing.is_part_of(other) for other in whole)):
            whole.append(thing)
    return whole


def places(played: Trace, kinds: Sequence[Kind]) -> Places:
    """Return where the things of each kind are in each step."""
    n_steps, blobs = played.n_steps, played.blobs
    count, x, y = (np.zeros((n_steps, len(kinds)), np.float32) for _ in range(3))
    for index, kind in enumerate(kinds):
        mine = blobs[kind.members(blobs)]
        count[:, index] = np.bincount(mine["step"], minlength=n_steps)
        with np.errstate(invalid="ignore", divide="ignore"):
            x[:, index] = np.bincount(mine["step"], mine["x"], n_steps) / count[:, index]
            y[:, index] = np.bincount(mine["step"], mine["y"], n_steps) / count[:, index]
    return Places(count, x, y)


def named_kinds(
    kinds: Sequence[Kind],
    at: Sequence[Places],
    memory: Sequence[npt.NDArray[np.uint8]],
    things: Mapping[str, Thing],
) -> tuple[Kind, ...]:
    """Return the kinds, with the names of those that are things the game itself names.

    Args:
        kinds: The kinds.
        at: Their places in each game.
        memory: Memory of each game, uint8 (n_steps, n_bytes).
        things: Things whose place the memory tells, by their names.
    """
    count = np.concatenate([found.count for found in at])
    x, y = (np.concatenate([getattr(found, axis) for found in at]) for axis in "xy")
    found: list[tuple[int, int, str]] = []
    for name, thing in things.items():
        place = np.concatenate([thing.places(of_game) for of_game in memory])
        for index in range(len(kinds)):
            both = (count[:, index] == 1) & ~np.isnan(place).any(axis=1)
            distance = np.hypot(x[both, index] - place[both, 0], y[both, index] - place[both, 1])
            n_same = int((distance <= MOST_APART_PX).sum())
            if n_same >= max(SAME_SHARE * len(distance), MIN_STEPS_SAME):
                found.append((n_same, index, name))
    named: dict[int, str] = {}
    for _, index, name in sorted(found, reverse=True):
        if index not in named and name not in named.values():
            named[index] = name
    return tuple(replace(kind, name=named.get(index)) for index, kind in enumerate(kinds))


def offset_to_nearest(played: Trace, kind: Kind, x: Array, y: Array) -> tuple[Array, Array]:
    """Return dx and dy from a place to the nearest thing of a kind, float32 (n_steps,) each.

    Args:
        played: The game.
        kind: The kind of things.
        x: The place in each step, float32 (n_steps,); NaN where there is none.
        y: The same, downwards.
    """
    mine = played.blobs[kind.members(played.blobs)]
    step = mine["step"]
    dx, dy = mine["x"] - x[step], mine["y"] - y[step]
    distance = np.nan_to_num(np.hypot(dx, dy), nan=np.inf)
    order = np.lexsort((distance, step))
    steps, first = np.unique(step[order], return_index=True)
    result = np.full((2, played.n_steps), np.nan, np.float32)
    result[0, steps], result[1, steps] = dx[order][first], dy[order][first]
    return result[0], result[1]


def find_player(
    traces: Sequence[Trace], at: Sequence[Places], buttons: Sequence[str]
) -> int | None:
    """Return the index of the kind that answers the buttons; None if none does.

    Of each kind of which there are as many as in the step before, it is asked how much of the
    variance of its motion from step to step is between the buttons held. There may be several, as
    of a thing that is drawn in parts. What moves against the buttons, as the scenery does where the
    screen follows the player, is not steered.

    Args:
        traces: The games.
        at: Where the kinds are in each of them.
        buttons: Names of the buttons; "left" and "right", "up" and "down" say where to.
    """
    # Of the step in which it moved, and of the one before: some games answer late.
    answers = []
    for lag in (slice(1, None), slice(None, -1)):
        keys = np.concatenate([played.held[lag] for played in traces])
        answers.append(np.unique(keys, return_inverse=True))
    best, player = MIN_EXPLAINED, None
    for kind in range(at[0].count.shape[1]):
        as_many = np.concatenate(
            [
                (found.count[1:, kind] > 0) & (found.count[1:, kind] == found.count[:-1, kind])
                for found in at
            ]
        )
        for axis, names in _WAYS.items():
            moved = np.concatenate([np.diff(getattr(found, axis)[:, kind]) for found in at])
            usable = as_many & ~np.isnan(moved) & (np.abs(moved) < MOST_STEP_PX)
            motion = moved[usable]
            if usable.sum() < 100 or motion.var() < 0.01:
                continue
            ways = [1 << buttons.index(name) if name in buttons else 0 for name in names]
            for patterns, held in answers:
                keys = held[usable]
                means = np.bincount(keys, motion) / np.maximum(np.bincount(keys), 1)
                explained = means[keys].var() / motion.var() * usable.mean()
                if explained > best and not _moves_against(motion, patterns[keys], ways):
                    best, player = float(explained), kind
    return player


def _moves_against(motion: Array, held: npt.NDArray[np.int64], ways: Sequence[int]) -> bool:
    """Return whether a thing clearly moves the other way than the buttons say.

    Args:
        motion: In steps, along an axis, (n_steps,).
        held: The buttons held, as bits, int64 (n_steps,).
        ways: The button to lower places and the one to higher ones, as bits; 0 if there is none.
    """
    down, up = ((held & one != 0) & (held & other == 0) for one, other in (ways, ways[::-1]))
    if not down.any() or not up.any():
        return False
    return bool(motion[up].mean() - motion[down].mean() < -AGAINST * motion.std())

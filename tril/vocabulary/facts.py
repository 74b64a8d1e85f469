"""The vocabulary of a game: facts of every step, in groups that one sentence can tell.

A fact is 1 or 0 in a step (a number of things is a share of eight), and its value in a game is its
sum over the steps by the length of a whole game, so that a game that ends early forfeits the rest.
Nothing in it is made for one game.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, Self
from zipfile import BadZipFile, ZipFile

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid
from tril.games.things import Thing
from tril.vocabulary.formations import FORMATION, Formation
from tril.vocabulary.groups import (
    BY_PLACE,
    IN_ORDER,
    NEAR_PX,
    Aspect,
    Group,
    Source,
    binned,
    edges_of,
)
from tril.vocabulary.kinds import (
    Array,
    Kind,
    Look,
    Places,
    find_kinds,
    find_player,
    named_kinds,
    offset_to_nearest,
    places,
)
from tril.vocabulary.lasting import Mask
from tril.vocabulary.memory import facts_of_byte, memory_groups, with_signs
from tril.vocabulary.pieces import cells_of, find_pieces, gone_items, gone_pieces
from tril.vocabulary.trace import Scene, Trace

FORMAT_VERSION = 7

_UNREADABLE = (
    OSError,
    EOFError,
    BadZipFile,
    zlib.error,
    RuntimeError,
    KeyError,
    ValueError,
    TypeError,
)
"""What reading a damaged file raises; RuntimeError where a bit says that it is encrypted."""
PLACE_BINS = 6
LINE_BINS = 10
"""Columns, or rows, of a formation that are told apart."""
MIN_SPAN_PX = 4
"""What moves less has no place worth a fact."""
MIN_STEPS_SEEN = 100
STEPS_COMPARED = 600
"""Steps of a game that bytes are compared with things in; whole long games take gigabytes."""
COUNT_SCALE = 8

SPREAD_FLOOR = 0.04
"""Smallest standard deviation by which a fact is divided, so that rare ones are held down."""

Role = Literal["place", "relation", "thing", "gone", "order", "memory", "button", "time"]

PRIOR_SHARES: dict[Role, float] = {
    "place": 0.25,
    "relation": 0.2,
    "thing": 0.2,
    "gone": 0.05,
    "order": 0.05,
    "memory": 0.25,
    "button": 0.05,
    "time": 0.05,
}
"""Prior probability of what a statement's group is about: where the player's own thing is, how it
stands to others, other things, what is cleared of the still picture or of a formation, in which
order, memory that follows no thing, buttons, how long the game lasts; of these, what the game has.
Buttons are few and are held differently by whoever plays better, so that they fit most orders a
little."""


@dataclass(frozen=True, eq=False)
class Vocabulary:
    """The facts of a game.

    Attributes:
        horizon: Steps of a whole game.
        scene: What the game's screens have in common.
        kinds: Kinds of things on the screen.
        player: Index of the kind that answers the buttons; None if none does.
        pieces: Which pixels of the beginning are pieces that games clear, bool (height, width);
            None if there are none.
        groups: What the facts are about.
        pool: Facts of the varied games that it was made from, float32 (n_games, n_facts).
        names: Names that people gave to kinds of things, by `tril.vocabulary.names.thing_key`;
            they are no part of its file.
    """

    horizon: int
    scene: Scene
    kinds: tuple[Kind, ...]
    player: int | None
    pieces: Mask | None
    groups: tuple[Group, ...]
    pool: Array
    names: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of_games(
        cls,
        traces: Sequence[Trace],
        scene: Scene,
        buttons: Sequence[str],
        horizon: int,
        things: Mapping[str, Thing] | None = None,
    ) -> Self:
        """Make the vocabulary of varied games.

        Args:
            traces: The games.
            scene: What the game's screens have in common.
            buttons: Names of the game's buttons.
            horizon: Steps of a whole game.
            things: Things that the game itself names, by their keys.
        """
        kinds = find_kinds(traces)
        at = [places(played, kinds) for played in traces]
        kinds = named_kinds(kinds, at, [played.memory for played in traces], things or {})
        player = find_player(traces, at, buttons)
        pieces = find_pieces(traces, scene.beginning)
        groups = (
            *memory_groups([played.memory for played in traces], at),
            *(Group("button", (button,), "held") for button in range(len(buttons))),
            Group("time", (), "played"),
            *_thing_groups(at, len(kinds)),
            *_relation_groups(traces, at, kinds, player),
            *_piece_groups(pieces),
            *_formation_groups(traces, at, scene.formation, player),
        )
        empty = np.empty((0, 0), np.float32)
        words = cls(horizon, scene, kinds, player, pieces, groups, empty)
        pool, beginnings = [], []
        for played in traces:
            facts = words.facts(played)
            pool.append(words.summary(facts))
            beginnings.append(facts[:STEPS_COMPARED].copy())
        signed = with_signs(groups, words.columns, beginnings)
        return cls(horizon, scene, kinds, player, pieces, signed, np.stack(pool))

    def with_names(self, names: Mapping[str, str]) -> Self:
        """Return the vocabulary with names that people gave to kinds of things."""
        return replace(self, names=dict(names))

    @cached_property
    def columns(self) -> tuple[npt.NDArray[np.int64], ...]:
        """Columns of each group's facts."""
        ends = np.cumsum([group.n_facts for group in self.groups])
        return tuple(
            np.arange(end - group.n_facts, end)
            for group, end in zip(self.groups, ends, strict=True)
        )

    @property
    def n_facts(self) -> int:
        """Number of facts."""
        return sum(group.n_facts for group in self.groups)

    @cached_property
    def log_prior(self) -> npt.NDArray[np.float64]:
        """Log of the prior probability of each group, float64 (n_groups,)."""
        roles = [self._role(group) for group in self.groups]
        total = sum(PRIOR_SHARES[role] for role in set(roles))
        return np.log([PRIOR_SHARES[role] / total / roles.count(role) for role in roles])

    def _role(self, group: Group) -> Role:
        subject = group.subject
        if group.twin is not None:
            # A byte that follows a thing stands for its place.
            subject = (group.twin.kind,)
        elif group.aspect in IN_ORDER:
            return "order"
        elif group.source == "pieces" or group.aspect in ("gone", *BY_PLACE):
            return "gone"
        elif group.source == "formation":
            return "relation"
        elif group.source != "thing":
            return group.source
        if len(subject) == 2:
            return "relation"
        is_place = group.aspect in ("x", "y", "value", "moves", "changes")
        return "place" if is_place and subject == (self.player,) else "thing"

    def facts(self, played: Trace) -> Array:
        """Return the facts of every step, float32 (n_steps, n_facts), 0 to 1 but for counts."""
        at = places(played, self.kinds)
        offsets: dict[int, tuple[Array, Array]] = {}
        gone = gone_pieces(played, self.pieces) if self.pieces is not None else None
        followed = played.followed
        items = gone_items(followed) if followed is not None else None
        parts: list[Array] = []
        for group in self.groups:
            if group.source == "memory":
                parts.append(facts_of_byte(group, played.memory[:, group.subject[0]]))
            elif group.source == "button":
                parts.append(_of_button(played.held >> group.subject[0] & 1))
            elif group.source == "time":
                parts.append(np.ones((played.n_steps, 1), np.float32))
            elif group.source == "pieces":
                assert gone is not None
                parts.append(gone.facts(group))
            elif group.source == "formation" and not group.subject:
                assert items is not None
                parts.append(items.facts(group))
            elif group.source == "formation":
                assert followed is not None
                player = group.subject[0]
                if FORMATION not in offsets:
                    offsets[FORMATION] = followed.offset_to_nearest(
                        at.x[:, player], at.y[:, player]
                    )
                parts.append(_of_relation(group, *offsets[FORMATION]))
            elif len(group.subject) == 1:
                parts.append(_of_things(group, at))
            else:
                player, other = group.subject
                if other not in offsets:
                    offsets[other] = offset_to_nearest(
                        played, self.kinds[other], at.x[:, player], at.y[:, player]
                    )
                parts.append(_of_relation(group, *offsets[other]))
        return np.concatenate(parts, axis=1)

    def summary(self, facts: Array) -> Array:
        """Return the facts of a game, float32 (n_facts,), from those of its steps."""
        total = facts[: self.horizon].sum(0, dtype=np.float64) / self.horizon
        summed: Array = total.astype(np.float32)
        return summed

    def spread(self, games: Array) -> npt.NDArray[np.float64]:
        """Return the deviation by which each fact is divided, float64 (n_facts,).

        Args:
            games: Facts of further games, float32 (n_games, n_facts).
        """
        deviation = np.concatenate([self.pool, games]).std(0, dtype=np.float64)
        floored: npt.NDArray[np.float64] = np.maximum(deviation, SPREAD_FLOOR)
        return floored

    def save(self, path: Path) -> None:
        """Write the vocabulary as a compressed .npz."""
        header = {
            "version": FORMAT_VERSION,
            "horizon": self.horizon,
            "player": self.player,
            "kinds": [asdict(kind) for kind in self.kinds],
            "groups": [group.to_json() for group in self.groups],
        }
        formation = self.scene.formation
        with path.open("wb") as file:
            np.savez_compressed(
                file,
                header=np.frombuffer(json.dumps(header).encode(), np.uint8),
                background=self.scene.background,
                beginning=self.scene.beginning,
                pieces=np.zeros(0, np.bool_) if self.pieces is None else self.pieces,
                items=np.zeros((0, 0), np.uint8) if formation is None else formation.items,
                item_colours=np.zeros((0, 0), np.uint8) if formation is None else formation.colours,
                pool=self.pool,
            )

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a vocabulary that `save` wrote.

        Raises:
            Invalid: The file is none, or of another format version.
        """
        try:
            # NumPy reads an array's header before it compares checksums.
            with ZipFile(path) as archive:
                if damaged := archive.testzip():
                    raise BadZipFile(f"{damaged} is damaged")
            with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
                header: dict[str, Any] = json.loads(arrays["header"].tobytes())
                if header["version"] != FORMAT_VERSION:
                    raise Invalid(f"{path.name} is a vocabulary of format {header['version']}.")
                kinds = (
                    Kind(
                        tuple(
                            Look(look["colour"], tuple(look["width"]), tuple(look["height"]))
                            for look in kind["looks"]
                        ),
                        kind["name"],
                    )
                    for kind in header["kinds"]
                )
                items = arrays["items"]
                groups = (Group.from_json(group) for group in header["groups"])
                return cls(
                    header["horizon"],
                    Scene(
                        arrays["background"],
                        arrays["beginning"],
                        Formation(items, arrays["item_colours"]) if items.size else None,
                    ),
                    tuple(kinds),
                    header["player"],
                    arrays["pieces"] if arrays["pieces"].size else None,
                    tuple(groups),
                    arrays["pool"],
                )
        except _UNREADABLE as error:
            raise Invalid(f"{path.name} cannot be read as a vocabulary: {error}") from error


def _thing_groups(at: Sequence[Places], n_kinds: int) -> list[Group]:
    groups: list[Group] = []
    for kind in range(n_kinds):
        x, y = (np.concatenate([getattr(found, axis)[:, kind] for found in at]) for axis in "xy")
        count = np.concatenate([found.count[:, kind] for found in at])
        for aspect, values in (("x", x), ("y", y)):
            seen = values[~np.isnan(values)]
            if np.ptp(seen) >= MIN_SPAN_PX:
                edges = edges_of(seen, PLACE_BINS)
                groups.append(Group("thing", (kind,), "x" if aspect == "x" else "y", edges))
        if np.ptp(count) > 0:
            groups.append(Group("thing", (kind,), "count"))
            groups.append(Group("thing", (kind,), "comes"))
        groups.append(Group("thing", (kind,), "moves"))
    return groups


def _relation_groups(
    traces: Sequence[Trace], at: Sequence[Places], kinds: Sequence[Kind], player: int | None
) -> list[Group]:
    groups: list[Group] = []
    if player is None:
        return groups
    for other, kind in enumerate(kinds):
        if other == player:
            continue
        offsets = [
            offset_to_nearest(played, kind, found.x[:, player], found.y[:, player])
            for played, found in zip(traces, at, strict=True)
        ]
        groups += _offset_groups("thing", (player, other), offsets)
    return groups


def _offset_groups(
    source: Source, subject: tuple[int, ...], offsets: Sequence[tuple[Array, Array]]
) -> list[Group]:
    """Return the groups about where something is as seen from what the player steers.

    Args:
        source: Of the groups.
        subject: Of the groups.
        offsets: dx and dy in each step of each game; NaN where it is not there.
    """
    dx, dy = (np.concatenate([pair[axis] for pair in offsets]) for axis in range(2))
    seen = ~np.isnan(dx)
    if seen.sum() < MIN_STEPS_SEEN:
        return []
    groups: list[Group] = []
    if np.ptp(dx[seen]) >= MIN_SPAN_PX:
        groups.append(Group(source, subject, "dx", edges_of(dx[seen], PLACE_BINS)))
        groups.append(Group(source, subject, "level x"))
    if np.ptp(dy[seen]) >= MIN_SPAN_PX:
        groups.append(Group(source, subject, "dy", edges_of(dy[seen], PLACE_BINS)))
        groups.append(Group(source, subject, "level y"))
    groups.append(Group(source, subject, "near"))
    return groups


def _piece_groups(pieces: Mask | None) -> list[Group]:
    if pieces is None:
        return []
    groups = [Group("pieces", (), "gone")]
    rows, columns = cells_of(pieces)
    aspects: tuple[tuple[Aspect, Array], ...] = (
        ("gone x", columns.astype(np.float32)),
        ("gone y", rows.astype(np.float32)),
    )
    for (aspect, values), in_order in zip(aspects, IN_ORDER, strict=True):
        if np.ptp(values) >= MIN_SPAN_PX:
            groups.append(Group("pieces", (), aspect, edges_of(values, PLACE_BINS)))
            groups.append(Group("pieces", (), in_order))
    return groups


def _formation_groups(
    traces: Sequence[Trace], at: Sequence[Places], formation: Formation | None, player: int | None
) -> list[Group]:
    if formation is None:
        return []
    groups = [Group("formation", (), "gone")]
    for aspect, in_order, lines in zip(BY_PLACE, IN_ORDER, formation.lines, strict=True):
        if np.ptp(lines):
            groups.append(Group("formation", (), aspect, edges_of(lines.astype(float), LINE_BINS)))
            groups.append(Group("formation", (), in_order))
    if player is not None:
        offsets = [
            played.followed.offset_to_nearest(found.x[:, player], found.y[:, player])
            for played, found in zip(traces, at, strict=True)
            if played.followed is not None
        ]
        groups += _offset_groups("formation", (player,), offsets)
    return groups


def _of_button(is_held: npt.NDArray[np.int64]) -> Array:
    is_pressed = np.diff(is_held, prepend=0) > 0
    return np.stack([is_held, is_pressed], 1).astype(np.float32)


def _of_things(group: Group, at: Places) -> Array:
    kind = group.subject[0]
    x, y, count = at.x[:, kind], at.y[:, kind], at.count[:, kind]
    if group.aspect in ("x", "y"):
        return binned(x if group.aspect == "x" else y, group.edges)
    if group.aspect == "count":
        return np.stack([count > 0, count / COUNT_SCALE], 1).astype(np.float32)
    if group.aspect == "comes":
        change = np.diff(count, prepend=count[:1])
        return np.stack([change > 0, change < 0], 1).astype(np.float32)
    dx, dy = np.diff(x, prepend=x[:1]), np.diff(y, prepend=y[:1])
    return np.stack([dx > 0.5, dx < -0.5, dy > 0.5, dy < -0.5], 1).astype(np.float32)


def _of_relation(group: Group, dx: Array, dy: Array) -> Array:
    if group.aspect in ("dx", "dy"):
        return binned(dx if group.aspect == "dx" else dy, group.edges)
    if group.aspect == "near":
        distance = np.hypot(dx, dy)
    else:
        distance = np.abs(dx if group.aspect == "level x" else dy)
    return np.stack([distance < limit for limit in NEAR_PX], 1).astype(np.float32)

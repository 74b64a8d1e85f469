"""Recordings to and from the exchange format."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from tril.exchange.formats.recording_object import (
    FORMAT,
    VERSION,
    RecordingObject,
    Source,
    parse,
    shortened,
)
from tril.game import space_invaders as game
from tril.game.console import Console
from tril.game.episode import Ending, EndReason, Hit, Start
from tril.ranking import Ranking
from tril.recording import Recording, Replay, verify


@dataclass(frozen=True)
class Exchanged:
    """A verified recording out of the exchange format, with what was said about it.

    Attributes:
        recording: The recording, cut at the end of its episode, with all RAM hashes.
        replay: What a replay of it gave.
        tier: Its place in a ranking, equal meaning a tie; None if it has none.
        perfect: Whether it is marked as perfect.
        source: Who played it; None if it doesn't say.
        notes: A person's remarks.
        conditions: How it was played.
        parent: What it goes on from.
        notices: What was left out or is worth knowing, in sentences.
    """

    recording: Recording
    replay: Replay
    tier: int | None
    perfect: bool
    source: Source | None
    notes: str
    conditions: dict[str, Any]
    parent: dict[str, Any] | str | None
    notices: tuple[str, ...]

    @property
    def hits(self) -> tuple[Hit, ...]:
        """The aliens shot, in order of time."""
        return self.replay.hits


def to_exchange(
    recording: Recording,
    *,
    hits: Sequence[Hit] | None = None,
    end: EndReason | None = None,
    tier: int | None = None,
    perfect: bool | None = None,
    source: Source | None = None,
    conditions: dict[str, Any] | None = None,
    parent: dict[str, Any] | str | None = None,
    notes: str = "",
) -> dict[str, Any]:
    """Write a recording in the exchange format, as an object ready for json.dumps."""
    optional = {
        "hits": None if hits is None else [[hit.row, hit.column] for hit in hits],
        "tier": tier,
        "perfect": perfect,
        "source": source,
        "end": None if end is None else str(end),
        "ending": None if recording.ending is Ending.HIT else str(recording.ending),
        "ram_hashes": list(recording.ram_hashes) or None,
        "conditions": conditions or None,
        "parent": parent,
        "notes": notes or None,
    }
    start = recording.start
    return {
        "format": FORMAT,
        "version": VERSION,
        "game": game.GAME,
        "rom_md5": recording.rom_md5,
        "start": {
            "idle_frames": start.idle_frames,
            "mode": start.mode,
            "difficulty": start.difficulty,
        },
        "actions": base64.b64encode(recording.actions).decode("ascii"),
    } | {key: value for key, value in optional.items() if value is not None}


def from_exchange(content: object, console: Console | None = None) -> Exchanged:
    """Read a recording from the exchange format and verify it by replaying it.

    Args:
        content: Parsed JSON.
        console: The console to replay on; None loads one.

    Raises:
        RecordingRefused: It is not of this format, was played on another ROM, or its replay
            differs from its hits or its RAM hashes.
    """
    given = parse(content)
    recording = Recording(
        start=Start(given.start.idle_frames, given.start.mode, given.start.difficulty),
        actions=base64.b64decode(given.actions),
        ram_hashes=tuple(given.ram_hashes or ()),
        rom_md5=given.rom_md5,
        ending=Ending(given.ending or Ending.HIT),
    )
    hits = None if given.hits is None else [(row, column) for row, column in given.hits]
    verified = verify(recording, hits, console)
    return Exchanged(
        recording=verified.recording,
        replay=verified.replay,
        tier=given.tier,
        perfect=bool(given.perfect),
        source=given.source,
        notes=given.notes or "",
        conditions=given.conditions or {},
        parent=given.parent,
        notices=tuple(_notices(given, verified.replay, verified.n_cut)),
    )


def ranked(recordings: Sequence[Exchanged]) -> tuple[Ranking, tuple[str, ...]]:
    """The ranking that a file of recordings stands for, as indices into it, and notices.

    The order of the lines is the order from best to worst, and recordings of equal tier are tied.
    Lines that follow neither the rising nor the falling order of their tiers are sorted by tier,
    the lowest first, which a notice says.
    """
    tiers = [recording.tier for recording in recordings]
    known = [tier for tier in tiers if tier is not None]
    notices: tuple[str, ...] = ()
    order = list(range(len(recordings)))
    if len(known) == len(tiers) and known not in (sorted(known), sorted(known, reverse=True)):
        order.sort(key=lambda index: known[index])
        notices = ("The lines are not in the order of their tiers; tier 1 was taken as the best.",)
    groups: dict[object, list[int]] = {}
    for index in order:
        tier = tiers[index]
        groups.setdefault(("alone", index) if tier is None else tier, []).append(index)
    return Ranking(tuple(tuple(group) for group in groups.values())), notices


def _notices(given: RecordingObject, played: Replay, n_cut: int) -> Iterator[str]:
    if n_cut:
        why = {
            EndReason.HIT: "the player was hit",
            EndReason.LIVES: "the player lost a life",
            EndReason.LANDED: "the aliens landed",
            EndReason.CLEARED: "no alien was left",
        }.get(played.end or EndReason.STEPS, f"{game.MAX_STEPS} steps were over")
        yield f"Cut at frame {played.n_frames}, where {why}: {n_cut} more actions were left out."
    elif given.end is not None and given.end != played.end:
        end = f"it ended by {str(played.end)!r}" if played.end else "nothing ended it"
        hint = "" if given.end in [*EndReason] else f" The ends are {', '.join(EndReason)}."
        yield f"Its end is {shortened(repr(given.end))}; in the replay {end}.{hint}"
    unknown = [
        *(given.model_extra or {}),
        *(f"start.{key}" for key in given.start.model_extra or {}),
    ]
    if unknown:
        yield f"Unknown members were left out: {shortened(', '.join(unknown), 200)}."

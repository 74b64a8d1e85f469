"""Dump recordings to the exchange format and load and verify them."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from tril.errors import Invalid, NotFound
from tril.exchange.formats.action_list import ActionList, is_action_list, read_action_list
from tril.exchange.formats.recording_object import (
    FORMAT,
    VERSION,
    RecordingObject,
    Source,
    parse_recording,
    truncated,
)
from tril.games import game_named
from tril.games.base import Game, Taken
from tril.games.settings import MAX_STEPS, GameSettings
from tril.play.consoles import Consoles
from tril.ranking import Ranking
from tril.recording import Recording, RecordingRefused, Replay, Verified, verify


@dataclass(frozen=True)
class ImportedRecording:
    """A verified recording from the exchange format with its metadata.

    Attributes:
        recording: The recording, cut at the end of its episode, with all RAM hashes.
        replay: The outcome of its replay.
        tier: Place in a ranking, equal meaning a tie; None if unranked.
        perfect: Whether the recording is marked as perfect.
        source: Kind of player, None if unknown.
        notes: A person's notes.
        conditions: Conditions of play.
        parent: The recording that it continues.
        notices: Messages about what was ignored or differs.
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
    def taken(self) -> tuple[Taken, ...]:
        """The items taken, in order of time."""
        return self.replay.taken


def dump_recording(
    recording: Recording,
    *,
    taken: Sequence[Taken] | None = None,
    end: str | None = None,
    tier: int | None = None,
    perfect: bool | None = None,
    source: Source | None = None,
    conditions: dict[str, Any] | None = None,
    parent: dict[str, Any] | str | None = None,
    notes: str = "",
) -> dict[str, Any]:
    """Return a recording in the exchange format, ready for json.dumps."""
    optional = {
        "taken": None if taken is None else [[item.row, item.column] for item in taken],
        "tier": tier,
        "perfect": perfect,
        "source": source,
        "end": end,
        "max_steps": recording.game.settings.max_steps,
        "end_rule": None if recording.end_rule == recording.game.end_rule else recording.end_rule,
        "hashes": list(recording.hashes) or None,
        "conditions": conditions or None,
        "parent": parent,
        "notes": notes or None,
    }
    return {
        "format": FORMAT,
        "version": VERSION,
        "game": recording.game.name,
        "game_version": recording.version,
        "start": recording.start.to_json(),
        "actions": base64.b64encode(recording.actions).decode("ascii"),
    } | {key: value for key, value in optional.items() if value is not None}


def load_recording(content: object, consoles: Consoles | None = None) -> ImportedRecording:
    """Load a recording from the exchange format or an action list; verify it by a replay.

    Args:
        content: Parsed JSON.
        consoles: Consoles to replay on, shared by the recordings of a file.

    Raises:
        RecordingRefused: The content is invalid, is of a game that is not installed or was played
            on another version of it, or its items, hashes or rewards differ from the replay's.
    """
    actions = None
    if isinstance(content, dict) and is_action_list(content):
        actions = read_action_list(content)
        content = actions.content
    parsed = parse_recording(content)
    recording = as_recording(parsed)
    game = recording.game
    cells = None if parsed.taken is None else [(row, column) for row, column in parsed.taken]
    rewards = None if actions is None else actions.rewards
    verified = verify(recording, cells, (consoles or Consoles()).of(game), rewards)
    return ImportedRecording(
        recording=verified.recording,
        replay=verified.replay,
        tier=parsed.tier,
        perfect=bool(parsed.perfect),
        source=parsed.source,
        notes=parsed.notes or "",
        conditions=parsed.conditions or {},
        parent=parsed.parent,
        notices=(
            *_notices(game, parsed, verified.replay, verified.n_cut),
            *(() if actions is None else _action_notices(game, actions, verified)),
        ),
    )


def as_recording(recording: RecordingObject) -> Recording:
    """Return the recording that an object holds, not replayed yet.

    Raises:
        RecordingRefused: The game is not installed, or has no such start, rule or action.
    """
    try:
        game = game_named(recording.game).with_settings(GameSettings(max_steps=recording.max_steps))
        return Recording(
            game=game,
            start=game.starts.parse(recording.start),
            actions=base64.b64decode(recording.actions),
            hashes=tuple(recording.hashes or ()),
            version=recording.game_version,
            end_rule=recording.end_rule or "",
        )
    except RecordingRefused:
        raise
    except (Invalid, NotFound) as refusal:
        raise RecordingRefused(str(refusal)) from None


def ranking_of(recordings: Sequence[ImportedRecording]) -> tuple[Ranking, tuple[str, ...]]:
    """Return the ranking given by a file of recordings, as indices into it, and notices.

    Lines are ordered from best to worst; recordings of equal tier are tied. If the tiers neither
    rise nor fall from line to line, the recordings are sorted by tier, lowest first, with a notice.
    """
    tiers = [recording.tier for recording in recordings]
    known_tiers = [tier for tier in tiers if tier is not None]
    notices: tuple[str, ...] = ()
    order = list(range(len(recordings)))
    if len(known_tiers) == len(tiers) and known_tiers not in (
        sorted(known_tiers),
        sorted(known_tiers, reverse=True),
    ):
        order.sort(key=lambda index: known_tiers[index])
        notices = (
            "The lines are not in the order of their tiers; they were sorted with tier 1 first.",
        )
    groups: dict[object, list[int]] = {}
    for index in order:
        tier = tiers[index]
        groups.setdefault(("alone", index) if tier is None else tier, []).append(index)
    return Ranking(tuple(tuple(group) for group in groups.values())), notices


def _notices(game: Game, recording: RecordingObject, played: Replay, n_cut: int) -> Iterator[str]:
    if n_cut:
        why = game.end(played.end or game.time_end).sentence
        yield f"Cut at frame {played.n_frames}, where {why}; {n_cut} more actions were ignored."
    elif recording.end is not None and recording.end != played.end:
        end = f"ends with {str(played.end)!r}" if played.end else "does not end"
        names = [names.name for names in game.ends]
        hint = "" if recording.end in names else f" Known ends: {', '.join(names)}."
        yield f"The given end is {truncated(repr(recording.end))}, but the replay {end}.{hint}"
    if unknown := list(recording.model_extra or {}):
        yield f"Unknown members were ignored: {truncated(', '.join(unknown), 200)}."


def _action_notices(game: Game, actions: ActionList, verified: Verified) -> Iterator[str]:
    yield from actions.notices
    clock = game.clock
    if verified.n_cut and verified.replay.end == game.time_end and clock.max_steps < MAX_STEPS:
        longest_s = MAX_STEPS * clock.frames_per_step / clock.frame_rate_hz
        yield (
            f"Its first {clock.max_frames:,} frames were imported, the longest game of the"
            f" behaviour. A behaviour may have games of up to {longest_s:g} s, and a list names"
            " its own max_steps."
        )

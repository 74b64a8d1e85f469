"""Answers for which recordings are replayed: their files, the ghost, and rewards."""

from __future__ import annotations

import asyncio
import threading
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Depends, Query, Request
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from server.api.schemas.behaviours import Ghost
from server.api.schemas.runs import RewardTrace
from server.clips import MEDIA_TYPES, ClipKind
from server.dependencies import BehaviourId, RecordingId, RunId, services_of
from server.play.replays import ReplayTask
from server.play.replays.products import read_observation, read_observations
from server.replay_cache import ReplayCache, version_of
from server.web.problems import NOT_FOUND
from tril.errors import NotFound
from tril.games import game_of
from tril.games.settings import MAX_STEPS
from tril.inference import AttentionMethod, AttentionNetwork, GivenUp
from tril.recording import Recording
from tril.store import behaviours, rankings, recordings
from tril.store.models import BehaviourRow, RecordingRow
from tril.store.training import runs

router = APIRouter()

_BYTES = "application/octet-stream"
_IMMUTABLE = "private, max-age=31536000, immutable"

ACTION_HEADER = "X-Tril-Action"
_DISCONNECT_POLL_S = 0.05
_CLIENT_CLOSED_REQUEST = 499
"""Nobody receives it; the status that nginx logs for this."""


@dataclass(frozen=True)
class _Source:
    """A recording whose files are asked for.

    Attributes:
        recording: The recording.
        name: Name of its files, without the ending.
        cache: Replays it.
        cache_control: Cache-Control header of the response.
    """

    recording: Recording
    name: str
    cache: ReplayCache
    cache_control: str

    def file(self, task: ReplayTask, media_type: str) -> Response:
        """Answer with what a replay yields."""
        return self.answer(self.cache.get(self.recording, task), media_type)

    def answer(self, content: bytes, media_type: str, **headers: str) -> Response:
        """Answer with a file."""
        headers |= {"Cache-Control": self.cache_control}
        return Response(content, media_type=media_type, headers=headers)


def _source(
    request: Request,
    recording_id: RecordingId,
    v: Annotated[
        str | None, Query(max_length=40, description="Makes the answer cacheable.")
    ] = None,
) -> _Source:
    services = services_of(request)
    with services.database.reading() as session:
        row = recordings.get(session, recording_id)
        recording, name = recordings.as_recording(row), recordings.file_name(session, row)
    cache_control = _IMMUTABLE if v == version_of(recording) else "private, no-cache"
    return _Source(recording, name, services.replay_cache, cache_control)


Source = Annotated[_Source, Depends(_source)]


def _file_route(*media_types: str, **extra_content: Any) -> dict[str, Any]:
    """Return the common arguments of the routes of a recording's files."""
    file = {"content": {media_type: {} for media_type in media_types}, **extra_content}
    return {
        "response_class": Response,
        "responses": NOT_FOUND | {200: file},
        "tags": ["recordings"],
    }


@router.get(
    "/recordings/{recording_id}/frames", **_file_route(_BYTES, description="docs/protocol.md")
)
def get_recording_frames(source: Source) -> Response:
    """Return every frame of a recording, as docs/protocol.md describes."""
    return source.file(ReplayTask.FRAMES, _BYTES)


@router.get("/recordings/{recording_id}/strip.webp", **_file_route("image/webp"))
def get_recording_strip(source: Source) -> Response:
    """Return a recording's film strip: the first frame, the last, and six between that differ.

    They are row by row in two columns, of the size that the game's ``strip`` says. Below them are
    the same, reduced, in four columns.
    """
    return source.file(ReplayTask.STRIP, "image/webp")


@router.get("/recordings/{recording_id}/memory", **_file_route(_BYTES))
def get_recording_memory(source: Source) -> Response:
    """Return the memory at the start and after every frame of a recording, as many bytes each.

    An Atari 2600 has 128 bytes; a game that has no memory to show is refused.
    """
    game = source.recording.game
    if not game.has_memory:
        raise NotFound(f"{game.title} shows no memory.")
    return source.file(ReplayTask.MEMORY, _BYTES)


@router.get("/recordings/{recording_id}/clip.{kind}", **_file_route(*MEDIA_TYPES.values()))
def get_recording_clip(source: Source, kind: ClipKind) -> Response:
    """Return a recording as a moving picture; making it takes seconds the first time."""
    content = source.cache.clip(source.recording, kind)
    name = f'attachment; filename="{source.name}.{kind}"'
    return source.answer(content, MEDIA_TYPES[kind], **{"Content-Disposition": name})


@router.get("/behaviours/{behaviour_id}/ghost", responses=NOT_FOUND, tags=["behaviours"])
def get_ghost(request: Request, behaviour_id: BehaviourId) -> Ghost | None:
    """Return where the player of the best demonstration stood in every frame.

    The best one is the first of the ranking's best tier, without a ranking the newest one that is
    marked as perfect; null if there is neither, or the game does not tell.
    """
    services = services_of(request)
    with services.database.reading() as session:
        behaviours.get(session, behaviour_id)
        row = _best(session, behaviour_id)
        if row is None:
            return None
        recording = recordings.as_recording(row)
        shown = {"recording_id": row.id, "number": row.number, "source": row.source}
    if recording.game.ghost is None:
        return None
    memory = services.replay_cache.get(recording, ReplayTask.MEMORY)
    track = recording.game.ghost(memory, recording.start)
    return Ghost.of(track, **shown)


def _as_learned_from(session: Session, run_id: RunId, recording_id: int) -> Recording:
    """Return a recording with what a training's behaviour hides from learning."""
    behaviour_id = runs.get(session, str(run_id)).behaviour_id
    taught = behaviours.as_behaviour(session.get_one(BehaviourRow, behaviour_id))
    row = recordings.get(session, recording_id)
    return recordings.as_recording(row).with_hidden_areas_of(game_of(taught))


@router.get("/runs/{run_id}/reward/{recording_id}", responses=NOT_FOUND, tags=["runs"])
def get_reward_trace(request: Request, run_id: RunId, recording_id: RecordingId) -> RewardTrace:
    """Return what a training's reward model says of every observation of a recording."""
    services = services_of(request)
    with services.database.reading() as session:
        recording = _as_learned_from(session, run_id, recording_id)
    content = services.replay_cache.get(recording, ReplayTask.OBSERVATIONS)
    judged = services.inference.judge(str(run_id), read_observations(content))
    zero_level, unit_level = services.inference.scale(str(run_id))
    deviations = judged.deviations
    return RewardTrace(
        run_id=str(run_id),
        recording_id=recording_id,
        rewards=judged.rewards.tolist(),
        levels=((judged.rewards - zero_level) / (unit_level - zero_level)).tolist(),
        zero_level_reward=zero_level,
        unit_level_reward=unit_level,
        reward_deviations=None if deviations is None else deviations.tolist(),
        level_deviations=None
        if deviations is None
        else (deviations / (unit_level - zero_level)).tolist(),
    )


@router.get(
    "/runs/{run_id}/attention/{recording_id}",
    response_class=Response,
    responses=NOT_FOUND
    | {
        200: {
            "content": {_BYTES: {}},
            "description": "float32 (84, 84), little-endian.",
            "headers": {
                ACTION_HEADER: {
                    "description": "Number of the action that a policy would choose.",
                    "schema": {"type": "integer"},
                }
            },
        }
    },
    tags=["runs"],
)
async def get_attention(
    request: Request,
    run_id: RunId,
    recording_id: RecordingId,
    step: Annotated[int, Query(ge=0, le=MAX_STEPS)],
    method: AttentionMethod,
    network: AttentionNetwork = "reward",
) -> Response:
    """Return what a network of a training looks at in a state of a recording.

    The map is non-negative, in the observation's 84x84 pixels. It says how much the level of R
    changes, or the log odds of the action that a policy would choose: by the gradient if a pixel
    became background, to first order; by occlusion if patches of 3x3 pixels of one screen did, the
    sum of all over a pixel; by patches of 9x9 pixels of all screens, the mean of those over a
    pixel. Its computation stops when the client disconnects.
    """
    services = services_of(request)
    given_up = threading.Event()

    def compute() -> Response:
        with services.database.reading() as session:
            recording = _as_learned_from(session, run_id, recording_id)
        content = services.replay_cache.get(recording, ReplayTask.OBSERVATIONS)
        observation = read_observation(content, step)
        attention = services.inference.attention(
            str(run_id),
            observation,
            network,
            method,
            given_up.is_set,
            recording.game.screen.background,
        )
        values = attention.values
        if network == "reward":
            zero_level, unit_level = services.inference.scale(str(run_id))
            values = values / np.float32(abs(unit_level - zero_level))
        headers = {} if attention.action is None else {ACTION_HEADER: str(int(attention.action))}
        return Response(values.tobytes(), headers=headers, media_type=_BYTES)

    async def watch() -> None:
        while not await request.is_disconnected():
            await asyncio.sleep(_DISCONNECT_POLL_S)
        given_up.set()

    watching = asyncio.create_task(watch())
    try:
        return await run_in_threadpool(compute)
    except GivenUp:
        return Response(status_code=_CLIENT_CLOSED_REQUEST)
    finally:
        watching.cancel()


def _best(session: Session, behaviour_id: int) -> RecordingRow | None:
    ranking = rankings.as_ranking(rankings.current(session, behaviour_id))
    if ranking.tiers:
        return recordings.get(session, ranking.tiers[0][0])
    perfect = recordings.perfect_ids(session, behaviour_id)
    return recordings.get(session, perfect[-1]) if perfect else None

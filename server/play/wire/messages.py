"""Text messages about a game: greeting, hits, outcome. Pure."""

from __future__ import annotations

from server.play.wire.codec import palette_json
from server.play.wire.protocol import AlienGeometry, Ended, Hello, HitAt, HitMessage
from tril.behaviours import Behaviour, score
from tril.games.space_invaders import memory as game
from tril.play.episode import Episode, Hit


def greeting(behaviour: Behaviour, episode: Episode, epoch: int, speed_percent: int) -> Hello:
    """Return the first message to a page that joins."""
    height, width = game.SCREEN_SHAPE
    return Hello(
        palette=palette_json(),
        width=width,
        height=height,
        frame_rate_hz=game.FRAME_RATE_HZ,
        max_frames=episode.max_frames,
        frame=episode.frame,
        epoch=epoch,
        resumed=episode.frame > 0,
        hits=all_hits(behaviour, episode),
        speed_percent=speed_percent,
        aliens=alien_geometry(),
    )


def alien_geometry() -> AlienGeometry:
    """Return the layout of the grid of aliens on the screen."""
    height, width = game.ALIEN_SIZE
    return AlienGeometry(
        width=width, height=height, column_px=game.COLUMN_WIDTH, row_px=game.ROW_HEIGHT
    )


def hits_after(behaviour: Behaviour, episode: Episode, n_known: int) -> list[HitMessage]:
    """Return a message for each hit after the first ``n_known``, with the score at that hit."""
    messages = []
    cells = _cells(episode)
    for n, hit in enumerate(episode.hits[n_known:], start=n_known + 1):
        found = score(behaviour, cells[:n])
        messages.append(
            HitMessage(
                **_hit(behaviour, hit).model_dump(),
                targets=None if found is None else found.targets,
                strays=None if found is None else found.strays,
            )
        )
    return messages


def outcome(
    behaviour: Behaviour, episode: Episode, recording_id: int, refusal: str | None
) -> Ended:
    """Return the last message of a game.

    Args:
        behaviour: What was to be demonstrated.
        episode: The game.
        recording_id: Its recording.
        refusal: Why the recording does not replay; None if it does.
    """
    found = score(behaviour, _cells(episode))
    return Ended(
        reason=None if episode.end is None else str(episode.end),
        frame=episode.frame,
        hits=all_hits(behaviour, episode),
        targets=None if found is None else found.targets,
        strays=None if found is None else found.strays,
        order_errors=None if found is None else found.order_errors,
        recording_id=recording_id,
        verification="verified" if refusal is None else "failed",
        verification_note=refusal or "",
    )


def all_hits(behaviour: Behaviour, episode: Episode) -> list[HitAt]:
    """Return every hit of a game."""
    return [_hit(behaviour, hit) for hit in episode.hits]


def _hit(behaviour: Behaviour, hit: Hit) -> HitAt:
    target = behaviour.target
    on_target = None if target is None else (hit.row, hit.column) in target
    return HitAt(row=hit.row, column=hit.column, frame=hit.frame, on_target=on_target)


def _cells(episode: Episode) -> tuple[tuple[int, int], ...]:
    return tuple((hit.row, hit.column) for hit in episode.hits)

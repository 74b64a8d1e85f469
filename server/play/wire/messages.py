"""Text messages about a game: greeting, items taken, outcome. Pure."""

from __future__ import annotations

from server.play.wire.codec import palette_json
from server.play.wire.protocol import Ended, Hello, HitAt, HitMessage, OverlayLayout
from tril.games.base import Cell, Game, Taken
from tril.games.behaviours import Behaviour, score
from tril.play.episode import Episode


def greeting(behaviour: Behaviour, episode: Episode, epoch: int, speed_percent: int) -> Hello:
    """Return the first message to a page that joins."""
    game = episode.game
    return Hello(
        game=game.name,
        palette=palette_json(game.screen),
        width=game.screen.width,
        height=game.screen.height,
        frame_rate_hz=game.clock.frame_rate_hz,
        max_frames=episode.max_frames,
        frame=episode.frame,
        epoch=epoch,
        resumed=episode.frame > 0,
        hits=all_hits(behaviour, episode),
        speed_percent=speed_percent,
        overlay=overlay_layout(game),
    )


def overlay_layout(game: Game) -> OverlayLayout | None:
    """Return the layout of the page's overlay for a game."""
    if game.overlay is None:
        return None
    return OverlayLayout(painter=game.overlay.painter, geometry=dict(game.overlay.geometry))


def hits_after(behaviour: Behaviour, episode: Episode, n_known: int) -> list[HitMessage]:
    """Return a message for each hit after the first ``n_known``, with the score at that hit."""
    messages = []
    cells = _cells(episode)
    for n, hit in enumerate(episode.taken[n_known:], start=n_known + 1):
        result = score(behaviour, cells[:n])
        messages.append(
            HitMessage(
                **_hit(behaviour, hit).model_dump(),
                targets=None if result is None else result.targets,
                strays=None if result is None else result.strays,
            )
        )
    return messages


def outcome(
    behaviour: Behaviour, episode: Episode, recording_id: int, refusal: str | None
) -> Ended:
    """Return the last message of a game.

    Args:
        behaviour: Behaviour to demonstrate.
        episode: The game.
        recording_id: Recording of the game.
        refusal: Why the recording does not replay; None if it does.
    """
    result = score(behaviour, _cells(episode))
    return Ended(
        reason=episode.end,
        frame=episode.frame,
        hits=all_hits(behaviour, episode),
        targets=None if result is None else result.targets,
        strays=None if result is None else result.strays,
        order_errors=None if result is None else result.order_errors,
        recording_id=recording_id,
        verification="verified" if refusal is None else "failed",
        verification_note=refusal or "",
    )


def all_hits(behaviour: Behaviour, episode: Episode) -> list[HitAt]:
    """Return every hit of a game."""
    return [_hit(behaviour, hit) for hit in episode.taken]


def _hit(behaviour: Behaviour, item: Taken) -> HitAt:
    target = behaviour.target
    on_target = None if target is None else item.cell in target
    return HitAt(row=item.row, column=item.column, frame=item.frame, on_target=on_target)


def _cells(episode: Episode) -> tuple[Cell, ...]:
    return tuple(item.cell for item in episode.taken)

"""The games that can be taught, whether anybody has played them or not."""

from __future__ import annotations

from datetime import datetime
from urllib.parse import quote

from fastapi import APIRouter, Request
from sqlalchemy import func, select
from sqlalchemy.orm import Session
from starlette.responses import Response

from server.api.schemas.behaviours import Settings
from server.api.schemas.catalogue import (
    Items,
    NamedEnd,
    NamedRule,
    ReadyMade,
    Strip,
    TaughtGame,
    Title,
)
from server.api.schemas.measures import Measure
from server.dependencies import ReadSession, Who, services_of
from server.play.replays import ReplayTask
from server.play.replays.strip import StripFormat
from server.web.problems import NOT_FOUND
from tril import __version__
from tril.demonstrators.varied import has_player
from tril.games import UnknownGame, game_named, game_titles
from tril.games.behaviours import Behaviour
from tril.games.settings import MAX_STEPS
from tril.play.pictures import drawn_picture
from tril.sample import sample
from tril.store import behaviours
from tril.store.access.credentials import Identity
from tril.store.models import BehaviourRow, RecordingRow, Source

router = APIRouter(prefix="/catalogue", tags=["catalogue"])

_IMMUTABLE = "private, max-age=31536000, immutable"


@router.get("")
def list_catalogue(session: ReadSession) -> list[Title]:
    """Return the games that can be taught: those played last first, then in order of titles."""
    taught = select(BehaviourRow.game, func.count()).where(BehaviourRow.deleted_at.is_(None))
    n_behaviours = {row[0]: row[1] for row in session.execute(taught.group_by(BehaviourRow.game))}
    played = select(RecordingRow.game, func.max(RecordingRow.created_at)).where(
        RecordingRow.source == Source.PERSON
    )
    last_played = {row[0]: row[1] for row in session.execute(played.group_by(RecordingRow.game))}
    titles = [
        Title(
            name=name,
            title=title,
            picture_url=_picture_url(name),
            n_behaviours=n_behaviours.get(name, 0),
            last_played_at=last_played.get(name),
        )
        for name, title in game_titles().items()
    ]
    # Sorting keeps the order of titles among those that nobody has played.
    return sorted(titles, key=lambda title: -_seconds(title.last_played_at))


@router.get("/games/{name:path}", responses=NOT_FOUND)
def get_title(session: ReadSession, identity: Who, name: str) -> TaughtGame:
    """Return a game: its screen, time, buttons, ends and what else the page needs.

    A participant gets the games of the behaviours that they play.
    """
    _refuse_foreign_title(session, identity, name)
    return game_view(name)


def game_view(name: str) -> TaughtGame:
    """Show a game; raises UnknownGame."""
    game = game_named(name)
    items = game.items
    return TaughtGame(
        name=game.name,
        title=game.title,
        picture_url=_picture_url(game.name),
        width=game.screen.width,
        height=game.screen.height,
        pixel_aspect=game.screen.pixel_aspect,
        strip=Strip.of(StripFormat.of(game.screen)),
        frame_rate_hz=game.clock.frame_rate_hz,
        frames_per_step=game.clock.frames_per_step,
        max_steps=game.clock.max_steps,
        longest_steps=MAX_STEPS,
        actions=list(game.controls.actions),
        buttons=list(game.controls.buttons),
        held=list(game.controls.held),
        default_keys=dict(game.controls.default_keys),
        waits=game.controls.waits,
        end_rules=[NamedRule.of(rule) for rule in game.end_rules],
        ends=[NamedEnd.of(end) for end in game.ends],
        options={option: list(values) for option, values in game.starts.options.items()},
        hidden=[(area.left, area.top, area.right, area.bottom) for area in game.screen.hidden],
        items=None if items is None else Items.of(items, row_colours=list(items.row_colours)),
        counters=dict(game.counters),
        things={name: thing.title for name, thing in game.things.items()},
        tallies={name: tally.title for name, tally in game.tallies.items()},
        ready_made=[_ready_made(behaviour) for behaviour in game.behaviours],
        saves_states=game.saves_states,
        has_memory=game.has_memory,
        has_player=has_player(game.name),
        attribution=game.attribution,
    )


@router.get(
    "/pictures/{name:path}",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {"image/png": {}}}},
)
def get_title_picture(request: Request, session: ReadSession, identity: Who, name: str) -> Response:
    """Return a picture of a game, some seconds after its start.

    A participant gets those of the behaviours that they play.
    """
    _refuse_foreign_title(session, identity, name)
    content = drawn_picture(name)
    if content is None:
        played = sample(game_named(name))
        content = services_of(request).replay_cache.get(played, ReplayTask.THUMBNAIL)
    return Response(content, media_type="image/png", headers={"Cache-Control": _IMMUTABLE})


def _refuse_foreign_title(session: Session, identity: Identity, name: str) -> None:
    """Raise UnknownGame for a game that a participant does not play.

    A request for an unknown game makes the server import and play environments, for seconds each.
    """
    if not identity.is_participant:
        return
    rows = behaviours.listing(session, ids=identity.behaviour_ids)
    if name not in {row.game for row in rows}:
        raise UnknownGame(f"There is no game {name!r} here.")


def _ready_made(behaviour: Behaviour) -> ReadyMade:
    return ReadyMade.of(
        behaviour,
        settings=Settings.model_validate(behaviour.settings.to_json()),
        measures=[Measure.of_measure(measure) for measure in behaviour.measures],
    )


def _picture_url(name: str) -> str:
    return f"/api/catalogue/pictures/{quote(name)}?v={__version__}"


def _seconds(moment: datetime | None) -> float:
    return 0.0 if moment is None else moment.timestamp()

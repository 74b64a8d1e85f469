"""The things of a game that statements about a ranking are about."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Annotated

from fastapi import APIRouter, Path, Query, Request
from starlette.responses import Response

from server.api.schemas.rankings import (
    Meaning,
    NamedThing,
    NamedThings,
    ThingInSight,
    ThingName,
)
from server.dependencies import MAX_ID, BehaviourId, Who, services_of
from server.services import Services
from server.vocabularies import VocabularyMaker
from server.web.problems import CONFLICT, NOT_FOUND
from tril.analysis.outcome import ToldStatement
from tril.errors import NameTaken, NotFound
from tril.games import game_of
from tril.games.base import Game
from tril.games.settings import MAX_STEPS
from tril.recording import Recording
from tril.store import behaviours, recordings, thing_names
from tril.store.changes import note_change
from tril.text import folded
from tril.vocabulary.answers import kinds_about
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.making import vocabulary_key
from tril.vocabulary.names import bare_name, given_name, kind_name, one_name, thing_key
from tril.vocabulary.pointing import meanings_of

router = APIRouter(prefix="/behaviours/{behaviour_id}/ranking/things", tags=["ranking"])


def picture_url(behaviour_id: int, game: Game) -> str:
    """Return the URL of a thing's picture, with braces for its kind."""
    return f"/api/behaviours/{behaviour_id}/ranking/things/{{}}.png?v={vocabulary_key(game)}"


def statement_pictures(
    vocabularies: VocabularyMaker,
    behaviour_id: int,
    game: Game,
    statements: Sequence[ToldStatement],
) -> list[list[str]]:
    """Return the URLs of the pictures of what each statement of a run is about.

    Statements name what they are about in the terms of the vocabulary that the run learned with.
    There are no pictures before Tril has learned to see the game here.
    """
    pictured = vocabularies.pictured(game) if statements else frozenset[int]()
    words = vocabularies.known(game) if pictured else None
    if words is None:
        return [[] for _ in statements]
    picture = picture_url(behaviour_id, game)
    return [
        [
            picture.format(kind)
            for kind in kinds_about(words, statement.subjects)
            if kind in pictured
        ]
        for statement in statements
    ]


@router.get("", responses=NOT_FOUND)
def list_things(request: Request, behaviour_id: BehaviourId) -> NamedThings:
    """Return the meanings to choose from, by kind of thing, and those that belong to no thing."""
    services = services_of(request)
    game = _game_of(services, behaviour_id)
    words = Vocabulary.load(_vocabulary(services, game))
    with services.database.reading() as session:
        names = thing_names.current(session, game.name)
    return _named_things(services, behaviour_id, game, words.with_names(names))


@router.put("/names", responses=NOT_FOUND | CONFLICT)
def name_thing(
    request: Request, identity: Who, behaviour_id: BehaviourId, update: ThingName
) -> NamedThings:
    """Name a kind of things, for all behaviours of the game; return the things."""
    services = services_of(request)
    game = _game_of(services, behaviour_id)
    words = Vocabulary.load(_vocabulary(services, game))
    kinds = {meaning.kind for meaning in meanings_of(words, game) if meaning.kind is not None}
    kind = next((index for index in kinds if thing_key(words, index) == update.key), None)
    if kind is None:
        raise NotFound("There is no such thing in this game (any more). Reload the page.")
    with services.database.writing() as session:
        names = thing_names.current(session, game.name) | {update.key: update.name}
        words = words.with_names(names)
        name = kind_name(words, kind, game)
        # Statements about two things that read the same would count as one.
        others = set().union(*(_names(words, index, game) for index in kinds - {kind}))
        if update.name and not others.isdisjoint(_names(words, kind, game)):
            raise NameTaken(
                f"Another thing in this game is called \u201c{name}\u201d. Choose another name."
            )
        thing_names.give(session, game.name, update.key, update.name, identity.player_id)
        for row in behaviours.listing(session):
            if row.game == game.name:
                note_change(session, "ranking", row.id)
    return _named_things(services, behaviour_id, game, words)


def _names(words: Vocabulary, kind: int, game: Game) -> set[str]:
    """Return what a kind of things is called, such that equal names are equal strings."""
    names = (kind_name(words, kind, game), one_name(words, kind, game))
    return {folded(bare_name(name)) for name in names}


def _named_things(
    services: Services, behaviour_id: int, game: Game, words: Vocabulary
) -> NamedThings:
    meanings: dict[int | None, list[Meaning]] = defaultdict(list)
    for pointed in meanings_of(words, game):
        meanings[pointed.kind].append(
            Meaning(subjects=[pointed.subject], sentence=pointed.sentence)
        )
    pictured, picture = services.vocabularies.pictured(game), picture_url(behaviour_id, game)
    kinds = sorted(
        (kind for kind in meanings if kind is not None),
        key=lambda kind: (kind != words.player, kind),
    )
    return NamedThings(
        things=[
            NamedThing(
                kind=kind,
                key=thing_key(words, kind),
                name=kind_name(words, kind, game),
                given=given_name(words, kind),
                picture=picture.format(kind) if kind in pictured else None,
                meanings=meanings[kind],
            )
            for kind in kinds
        ],
        others=meanings[None],
    )


@router.get("/in-sight", responses=NOT_FOUND)
def list_things_in_sight(
    request: Request,
    behaviour_id: BehaviourId,
    recording_id: Annotated[int, Query(ge=1, le=MAX_ID)],
    step: Annotated[int, Query(ge=0, le=MAX_STEPS)],
) -> list[ThingInSight]:
    """Return the things on the screen after a step of a recording, the largest first."""
    services = services_of(request)
    game, recording = _recording(services, behaviour_id, recording_id)
    watched = services.replay_cache.watched(recording, _vocabulary(services, game))
    things = [
        ThingInSight(
            kind=int(thing["kind"]),
            left=int(thing["left"]),
            top=int(thing["top"]),
            width=int(thing["width"]),
            height=int(thing["height"]),
        )
        for thing in watched.things(step)
    ]
    return sorted(things, key=lambda thing: -thing.width * thing.height)


@router.get(
    "/{kind}.png",
    response_class=Response,
    responses=NOT_FOUND | {200: {"content": {"image/png": {}}}},
)
def get_thing_picture(
    request: Request,
    behaviour_id: BehaviourId,
    kind: Annotated[int, Path(ge=0, le=255)],
    v: Annotated[
        str | None, Query(max_length=40, description="Makes the answer cacheable.")
    ] = None,
) -> Response:
    """Return a picture of a thing that statements are about, by its kind."""
    services = services_of(request)
    game = _game_of(services, behaviour_id)
    cache_control = "private, max-age=31536000, immutable"
    return Response(
        services.vocabularies.picture(game, kind),
        media_type="image/png",
        headers={
            "Cache-Control": cache_control if v == vocabulary_key(game) else "private, no-cache"
        },
    )


def _game_of(services: Services, behaviour_id: int) -> Game:
    with services.database.reading() as session:
        return game_of(behaviours.as_behaviour(behaviours.get(session, behaviour_id)))


def _recording(services: Services, behaviour_id: int, recording_id: int) -> tuple[Game, Recording]:
    """Return a behaviour's game, and a recording of it as it is learned from."""
    game = _game_of(services, behaviour_id)
    with services.database.reading() as session:
        recording = recordings.as_recording(recordings.get(session, recording_id))
    if recording.game.name != game.name:
        raise NotFound(f"Recording {recording_id} is of another game.")
    return game, recording.with_hidden_areas_of(game)


def _vocabulary(services: Services, game: Game) -> FilePath:
    path = services.vocabularies.vocabulary(game).path
    if path is None:
        raise NotFound(f"Tril has not learned to see {game.title} yet.")
    return path

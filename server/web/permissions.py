"""What each role may do: the one place that says so.

Every operation of the API declares here what it needs, by the name of its route; a route that does
not keeps the application from being built (``check_all_declared``). So do the fields of responses
that not everybody reads who may ask for them. ``scripts/permissions_page.py`` writes
docs/permissions.md of it.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum, auto
from typing import Any, TypeVar

from fastapi.exceptions import WebSocketException
from pydantic import BaseModel
from starlette.requests import HTTPConnection

from server.dependencies import identity_of, services_of
from tril.errors import Forbidden, NotFound
from tril.store import games, recordings
from tril.store.access.credentials import Identity
from tril.store.models import Role

Shown = TypeVar("Shown", bound=BaseModel)


class Need(Enum):
    """What an operation needs.

    NOTHING: no sign-in. SIGNED_IN: its answer is only about the person who asks. OWN_BEHAVIOUR,
    OWN_RECORDING and OWN_GAME: researchers, and participants for what is named in the path, if it
    is theirs.
    WORKER: a worker's key and nobody else, since the answer has the database's password.
    """

    NOTHING = auto()
    SIGNED_IN = auto()
    OWN_BEHAVIOUR = auto()
    OWN_RECORDING = auto()
    OWN_GAME = auto()
    RESEARCHER = auto()
    OWNER = auto()
    WORKER = auto()


OPERATIONS: dict[Need, tuple[str, ...]] = {
    Need.NOTHING: ("get_health",),
    Need.SIGNED_IN: (
        "get_player",
        "get_title",
        "get_title_picture",
        "update_player",
        "sign_out",
        "list_behaviours",
        "create_game",
        "stream_events",
    ),
    Need.OWN_BEHAVIOUR: (
        "get_behaviour",
        "get_checklist",
        "list_recordings",
        "get_library",
        "list_shown_recordings",
    ),
    Need.OWN_RECORDING: (
        "get_recording",
        "delete_recording",
        "keep_recording",
        "discard_recording",
        "restore_recording",
        "get_recording_course",
        "export_recording",
        "get_recording_frames",
        "get_recording_strip",
        "get_recording_memory",
        "get_recording_clip",
        "create_game_from",
    ),
    Need.OWN_GAME: ("get_game", "play"),
    Need.RESEARCHER: (
        "get_system",
        "list_catalogue",
        "create_behaviour",
        "update_behaviour",
        "delete_behaviour",
        "restore_behaviour",
        "get_ghost",
        "change_recordings",
        "export_recordings",
        "export_chosen_recordings",
        "update_recording",
        "import_recordings_file",
        "open_finished_example",
        "get_ranking",
        "save_ranking",
        "undo_ranking",
        "redo_ranking",
        "get_ranking_opinion",
        "understand_ranking",
        "answer_statement",
        "list_statement_answers",
        "get_thing_picture",
        "list_things",
        "list_things_in_sight",
        "name_thing",
        "add_games",
        "list_borrowed_games",
        "add_varied_games",
        "give_game_back",
        "list_recipes",
        "list_runs",
        "create_run",
        "get_run",
        "update_run",
        "delete_run",
        "restore_run",
        "cancel_run",
        "resume_run",
        "get_run_metrics",
        "get_run_results",
        "get_blind_comparison",
        "answer_blind",
        "get_blind_frames",
        "get_run_archive",
        "get_run_page",
        "get_artifact",
        "get_reward_trace",
        "get_attention",
        "watch",
    ),
    Need.OWNER: (
        "list_people",
        "change_role",
        "list_browsers",
        "sign_browser_out",
        "list_keys",
        "create_key",
        "revoke_key",
        "list_invitations",
        "create_invitation",
        "revoke_invitation",
        "list_audit",
    ),
    Need.WORKER: ("let_worker_in",),
}

RESEARCHERS_FIELDS: dict[str, dict[str, Any]] = {
    "Behaviour": {
        "n_recordings": 0,
        "n_ranked": 0,
        "n_perfect": 0,
        "n_runs": 0,
        "has_example": False,
    },
    "Library": {"ranked": []},
    "LibraryColumns": {"run_id": None, "perfect": False},
    "Recording": {
        "run_id": None,
        "begun_by": None,
        "perfect": False,
        "notes": "",
        "ranked": False,
    },
}
"""What participants don't read, and what they get instead: it tells of other people's work. They
read all other fields, which docs/permissions.md lists; a test says if one is new."""

RESEARCHERS_MEMBERS = frozenset({"tier", "perfect", "notes"})
"""Members of an exported recording that participants don't get."""

NEEDS = {name: need for need, names in OPERATIONS.items() for name in names}

_NOT_YOURS = {
    Need.OWN_BEHAVIOUR: "There is no such behaviour.",
    Need.OWN_RECORDING: "There is no such recording.",
    Need.OWN_GAME: "There is no such game.",
}


async def check_permission(connection: HTTPConnection) -> None:
    """Let a request pass if its maker's role allows it; a dependency of every route.

    Raises:
        Forbidden: The identity's role does not allow the request.
        NotFound: It is another person's, which looks as if it did not exist.
    """
    need = NEEDS[connection.scope["endpoint"].__name__]
    if need is Need.NOTHING:
        return
    identity = identity_of(connection)
    if _suffices(identity.role, need):
        return
    if need in _NOT_YOURS and identity.role is not Role.WORKER:
        if await _is_own(connection, need, identity):
            return
        refusal: Exception = NotFound(_NOT_YOURS[need])
    elif identity.role is Role.WORKER:
        refusal = Forbidden("This key lets workers join, and nothing else.")
    elif need is Need.WORKER:
        refusal = Forbidden(
            "Only the key of a worker may do this. The owner makes one on the page People, or by"
            " `tril people key NAME --worker`."
        )
    else:
        roles = "owner" if need is Need.OWNER else "owner and researchers"
        refusal = Forbidden(f"Only the {roles} may do this. Ask whoever runs this server.")
    if connection.scope["type"] == "websocket":
        raise WebSocketException(1008, str(refusal))
    raise refusal


def refuse_foreign_behaviour(identity: Identity, behaviour_id: int) -> None:
    """Raise NotFound if an identity may not play the behaviour of a request's body."""
    if identity.is_participant and behaviour_id not in identity.behaviour_ids:
        raise NotFound(_NOT_YOURS[Need.OWN_BEHAVIOUR])


def for_reader(identity: Identity, response: Shown) -> Shown:
    """Return a response as its reader may see it, without the fields that are for researchers."""
    if not identity.is_participant:
        return response
    return response.model_copy(update=RESEARCHERS_FIELDS.get(type(response).__name__, {}))


def check_all_declared(operations: Iterable[str]) -> None:
    """Raise RuntimeError unless the API's operations are those that declare a need."""
    different = set(operations) ^ NEEDS.keys()
    if different:
        raise RuntimeError(
            "server/web/permissions.py has to declare every operation of the API, and no other: "
            f"{', '.join(sorted(different))}."
        )


def _suffices(role: Role, need: Need) -> bool:
    if role is Role.WORKER or need is Need.WORKER:
        return role is Role.WORKER and need is Need.WORKER
    if role is Role.OWNER or need is Need.SIGNED_IN:
        return True
    return role is Role.RESEARCHER and need is not Need.OWNER


async def _is_own(connection: HTTPConnection, need: Need, identity: Identity) -> bool:
    """Whether what a path names is a participant's own; what is no id is nobody's."""
    if need is Need.OWN_BEHAVIOUR:
        behaviour_id = connection.path_params["behaviour_id"]
        return behaviour_id in {str(behaviour) for behaviour in identity.behaviour_ids}
    name = "recording_id" if need is Need.OWN_RECORDING else "game_id"
    key = str(connection.path_params[name])
    access = services_of(connection).access
    if need is Need.OWN_GAME:
        owner = await access.query(lambda session: games.player_of(session, key))
    elif key.isdecimal() and len(key) < 10:
        owner = await access.query(lambda session: recordings.player_of(session, int(key)))
    else:
        return False
    if owner is None:
        return False
    player_id, behaviour_id = owner
    return player_id == identity.player_id and behaviour_id in identity.behaviour_ids

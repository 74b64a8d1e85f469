"""Signing in: by the key in the printed address, or by an invitation."""

from __future__ import annotations

from collections.abc import Collection
from urllib.parse import parse_qsl, unquote

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import Response

from server.dependencies import services_of
from server.web.problems import problem
from server.web.small_pages import SmallPages
from tril.errors import NotFound, TrilError
from tril.store import behaviours, players
from tril.store.access import credentials, invitations
from tril.store.models import Role
from tril.store.players import TooManyPeople
from tril.text import TextRefused

MAX_FIELDS = 8
"""Most fields of a form or a query of somebody who is not signed in."""

_BROWSERS = (("Edg", "Edge"), ("OPR/", "Opera"), ("Firefox/", "Firefox"), ("Chrome/", "Chrome"))
_SYSTEMS = (
    ("Android", "Android"),
    ("iPhone", "iPhone"),
    ("iPad", "iPad"),
    ("Windows", "Windows"),
    ("Mac OS X", "macOS"),
    ("CrOS", "ChromeOS"),
    ("Linux", "Linux"),
)


async def sign_in(request: Request, pages: SmallPages) -> Response:
    """Sign a browser in as the owner, by the key in its address."""
    services = services_of(request)
    token = _token_in(_query_of(request).get("token", ""))
    if not await run_in_threadpool(services.access.is_token, token):
        return pages.key_page(pages.texts.wrong_key, pages.texts.wrong_key_why)
    identity = await services.access.identify(request)
    if identity is not None and identity.role is Role.OWNER:
        return _redirect()
    browser = _browser_of(request)

    def add() -> str:
        with services.database.writing() as session:
            return credentials.sign_in(session, players.owner(session).id, browser)

    return _with_cookie(request, await run_in_threadpool(add))


async def join(request: Request, pages: SmallPages) -> Response:
    """Ask somebody who was invited for a name, and sign their browser in."""
    if request.method in {"GET", "HEAD"}:
        return await _ask_for_name(request, pages, _query_of(request).get("invitation", ""))
    if request.method != "POST":
        return problem(405, "Open the link of an invitation.")
    fields = _fields_of(await request.body())
    services = services_of(request)
    signed = fields.get("invitation", "")
    secret = services.access.secrets.secret_in(signed)
    name, browser = fields.get("name", ""), _browser_of(request)

    def accept(secret: str) -> tuple[str, int | None]:
        with services.database.writing() as session:
            return invitations.accept(session, secret, name, browser, fields.get("form", ""))

    if secret is not None:
        try:
            async with services.write_limit.slot(request.client and request.client.host):
                secret_of_browser, behaviour_id = await run_in_threadpool(accept, secret)
            # Somebody who may play one behaviour has nothing to choose from on the first page.
            path = "/" if behaviour_id is None else f"/behaviours/{behaviour_id}/play"
            return _with_cookie(request, secret_of_browser, path)
        except TextRefused as refusal:
            wrong = pages.texts.name_too_long
            if refusal.character is not None:
                wrong = pages.texts.name_refused.format(character=refusal.character)
            return await _ask_for_name(request, pages, signed, wrong)
        except TooManyPeople:
            return await _ask_for_name(request, pages, signed, pages.texts.too_many)
        except TrilError:
            # The name is missing, or the invitation is over; the page says which.
            pass
    return await _ask_for_name(request, pages, signed, pages.texts.name_missing)


async def _ask_for_name(
    request: Request, pages: SmallPages, signed: str, wrong: str | None = None
) -> Response:
    services = services_of(request)
    secret = services.access.secrets.secret_in(signed)
    present = await services.access.identify(request)
    if secret is None:
        return pages.no_invitation(is_over=False, is_signed_in=present is not None)

    def answer() -> Response:
        with services.database.reading() as session:
            row = invitations.find(session, secret)
            if row is None:
                is_over = invitations.is_over(session, secret)
                return pages.no_invitation(is_over, present is not None)
            behaviour = player = None
            if row.behaviour_id is not None:
                behaviour = behaviours.get(session, row.behaviour_id).name
            if present is not None:
                player = players.get(session, present.player_id).name
            return pages.name_page(invitations.PATH, signed, behaviour, player, wrong)

    try:
        async with services.read_limit.slot(request.client and request.client.host):
            return await run_in_threadpool(answer)
    except NotFound:
        # The behaviour was deleted, so the invitation leads nowhere.
        return pages.no_invitation(is_over=True, is_signed_in=present is not None)


def _with_cookie(request: Request, secret: str, path: str = "/") -> Response:
    access = services_of(request).access
    answer = _redirect(path)
    answer.set_cookie(
        access.cookie_name,
        access.secrets.signed(secret),
        max_age=int(credentials.BROWSER_LIFETIME.total_seconds()),
        path="/",
        httponly=True,
        samesite="strict",
        secure=request.url.scheme == "https",
    )
    return answer


def _redirect(path: str = "/") -> Response:
    return Response(status_code=303, headers={"Location": path, "Cache-Control": "no-store"})


def _query_of(request: Request) -> dict[str, str]:
    return _fields_of(request.scope["query_string"])


def _fields_of(encoded: bytes) -> dict[str, str]:
    """Return the fields of a form or a query, none if there are too many."""
    try:
        return dict(parse_qsl(encoded.decode(errors="replace"), max_num_fields=MAX_FIELDS))
    except ValueError:
        return {}


def _browser_of(request: Request) -> str:
    return browser_name(request.headers.get("user-agent", ""))


def browser_name(user_agent: str) -> str:
    """Return a browser's name, to tell it from others: "Firefox on Linux"."""
    browser = _first(_BROWSERS, user_agent) or ("Safari" if "Safari/" in user_agent else None)
    system = _first(_SYSTEMS, user_agent)
    if browser is None:
        return user_agent.partition("/")[0].strip()[:80] or "Unknown browser"
    return browser if system is None else f"{browser} on {system}"


def _first(names: Collection[tuple[str, str]], text: str) -> str | None:
    return next((name for mark, name in names if mark in text), None)


def _token_in(text: str) -> str:
    """Return the token of what was typed, which may be the whole address."""
    return unquote(text.strip().rpartition("token=")[2])

"""Signing in: by the key in the printed address, or by an invitation."""

from __future__ import annotations

from collections.abc import Collection
from html import escape
from urllib.parse import parse_qs, unquote

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

from server.dependencies import services_of
from server.web.problems import problem
from tril.errors import TrilError
from tril.store import behaviours, players
from tril.store.access import credentials, invitations
from tril.store.models import InvitationRow, Role

_STYLE = "font: inherit; padding: .5rem"
_PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">{head}
<title>{title} · Tril</title>
<body style="font: 1.1rem/1.5 system-ui; max-width: 36rem; margin: 15vh auto; padding: 0 1rem;
  color-scheme: light dark">
<main>
<h1>{title}</h1>
<p>{text}</p>
{form}
</main>
"""

_KEY_FORM = f"""<form action="/" style="display: grid; gap: .5rem">
<label for="key">Key, or the whole address</label>
<input id="key" name="token" type="password" autocomplete="off" required autofocus
  style="{_STYLE}">
<button style="{_STYLE} 1rem; justify-self: start">Sign in</button>
</form>"""

_NAME_FORM = """<form action="{path}" method="post" style="display: grid; gap: .5rem">
<label for="name">Your name</label>
<input id="name" name="name" maxlength="80" autocomplete="nickname" required autofocus
  style="{style}">
<input type="hidden" name="invitation" value="{invitation}">
<button style="{style} 1rem; justify-self: start">Begin</button>
</form>"""

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


def small_page(
    status: int, title: str, text: str, head: str = "", form: str = _KEY_FORM
) -> Response:
    """Return a page that works without the frontend; its texts are HTML."""
    return HTMLResponse(
        _PAGE.format(title=title, text=text, head=head, form=form),
        status,
        headers={"Cache-Control": "no-store"},
    )


async def sign_in(request: Request) -> Response:
    """Sign a browser in as the owner, by the key in its address."""
    services = services_of(request)
    if not services.access.is_token(_token_in(request.query_params["token"])):
        return small_page(
            401,
            "This key does not fit",
            "It is not the one of this server. <code>tril address</code> in a terminal prints the "
            "address that contains it.",
        )
    identity = await services.access.identify(request)
    if identity is not None and identity.role is Role.OWNER:
        return _to_the_page()
    browser = _browser_of(request)

    def add() -> str:
        with services.database.writing() as session:
            return credentials.sign_in(session, players.owner(session).id, browser)

    return _with_cookie(request, await run_in_threadpool(add))


async def join(request: Request) -> Response:
    """Ask somebody who was invited for a name, and sign their browser in."""
    if request.method in {"GET", "HEAD"}:
        return await _ask_for_name(request, request.query_params.get("invitation", ""))
    if request.method != "POST":
        return problem(405, "Open the link of an invitation.")
    given = parse_qs((await request.body()).decode(errors="replace"))
    services = services_of(request)
    signed = given.get("invitation", [""])[0]
    secret = services.access.secrets.secret_in(signed)
    if secret is None:
        return _no_invitation()
    name, browser = given.get("name", [""])[0], _browser_of(request)

    def accept() -> tuple[str, int | None]:
        with services.database.writing() as session:
            return invitations.accept(session, secret, name, browser)

    try:
        secret_of_browser, behaviour_id = await run_in_threadpool(accept)
        # Somebody who may play one behaviour has nothing to choose from on the first page.
        path = "/" if behaviour_id is None else f"/behaviours/{behaviour_id}/play"
        return _with_cookie(request, secret_of_browser, path)
    except TrilError:
        # The name is missing, or the invitation was revoked since; the page says which.
        return await _ask_for_name(request, signed)


async def _ask_for_name(request: Request, signed: str) -> Response:
    services = services_of(request)
    secret = services.access.secrets.secret_in(signed)

    def find() -> tuple[InvitationRow, str | None] | None:
        with services.database.reading() as session:
            row = None if secret is None else invitations.find(session, secret)
            if row is None:
                return None
            found = None
            if row.behaviour_id is not None:
                found = behaviours.get(session, row.behaviour_id).name
            return row, found

    try:
        found = await run_in_threadpool(find)
    except TrilError:
        found = None
    if found is None:
        return _no_invitation()
    behaviour = found[1]
    text = (
        "You are invited to teach and rank here, as a researcher."
        if behaviour is None
        else f"You are invited to play Space Invaders: {escape(behaviour)}. Your games are "
        "recorded, and an agent may learn from them."
    )
    present = await services.access.identify(request)
    if present is not None:
        text += " This browser is signed in already; if you go on, it is signed in as you instead."
    form = _NAME_FORM.format(path=invitations.PATH, style=_STYLE, invitation=escape(signed))
    return small_page(200, "Welcome to Tril", f"{text} What is your name?", form=form)


def _no_invitation() -> Response:
    why = "It was revoked, or the link is incomplete. Ask for a new link."
    return small_page(404, "This invitation is not valid", why, form="")


def _with_cookie(request: Request, secret: str, path: str = "/") -> Response:
    access = services_of(request).access
    answer = _to_the_page(path)
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


def _to_the_page(path: str = "/") -> Response:
    return Response(status_code=303, headers={"Location": path, "Cache-Control": "no-store"})


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


def _token_in(given: str) -> str:
    """Return the token of what was typed, which may be the whole address."""
    return unquote(given.strip().rpartition("token=")[2])

"""The pages: the files of the built frontend, and sign-in by token."""

from __future__ import annotations

import mimetypes
from pathlib import Path
from urllib.parse import quote

from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, PlainTextResponse, Response
from starlette.types import Receive, Scope, Send

from server.dependencies import services_of
from server.web.middleware import is_signed_in
from server.web.problems import problem
from server.web.security import COOKIE_LIFETIME_S
from tril.errors import Unavailable

FRONTEND = Path(__file__).with_name("static")
_HASHED = "/assets/"
"""Where the build puts files whose names change with their content."""
_IMMUTABLE = "public, max-age=31536000, immutable"

_PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">{head}
<title>{title} · Tril</title>
<body style="font: 1.1rem/1.5 system-ui; max-width: 36rem; margin: 15vh auto; padding: 0 1rem;
  color-scheme: light dark">
<h1>{title}</h1>
<p>{text}</p>
"""


class Frontend:
    """The built frontend; only files found by listing its folder are served.

    Args:
        folder: The build.
    """

    def __init__(self, folder: Path = FRONTEND) -> None:
        self._folder = folder
        self._built_at: int | None = None
        self._files: dict[str, Path] = {}

    @property
    def index(self) -> Path:
        """The application's page.

        Raises:
            Unavailable: The frontend was not built.
        """
        path = self._folder / "index.html"
        if not path.is_file():
            raise Unavailable(
                f"The page has not been built: {path} is missing. Run `make frontend`, then reload."
            )
        return path

    def find(self, path: str) -> Path | None:
        """Return the file for a URL path, None if there is none."""
        built_at = self.index.stat().st_mtime_ns
        if built_at != self._built_at:
            self._files = {
                f"/{file.relative_to(self._folder).as_posix()}": file
                for file in self._folder.rglob("*")
                if file.is_file() and not file.is_symlink()
            }
            self._built_at = built_at
        return self._files.get(path)


def check_frontend(folder: Path = FRONTEND) -> None:
    """Raise Unavailable, saying what to do, unless the frontend was built."""
    _ = Frontend(folder).index


class Pages:
    """Answers what no route of the API matches: files, pages and sign-in.

    Args:
        frontend: The built frontend.
    """

    def __init__(self, frontend: Frontend) -> None:
        self._frontend = frontend

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request; a WebSocket is refused."""
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": "No such stream."})
            return
        request = Request(scope)
        path = request.url.path
        if path == "/api" or path.startswith("/api/"):
            answer: Response = problem(404, f"There is nothing at {path}.")
        elif request.method not in {"GET", "HEAD"}:
            answer = problem(405, "Pages can only be read.")
            answer.headers["Allow"] = "GET, HEAD"
        else:
            answer = self._page(request, path)
        await answer(scope, receive, send)

    def _page(self, request: Request, path: str) -> Response:
        if path == "/" and "token" in request.query_params:
            return _sign_in(request)
        file = self._frontend.find(path)
        if file is not None and file != self._frontend.index:
            media_type = mimetypes.guess_type(file.name)[0] or "application/octet-stream"
            cached = _IMMUTABLE if path.startswith(_HASHED) else "no-cache"
            return FileResponse(file, media_type=media_type, headers={"Cache-Control": cached})
        if "." in path.rpartition("/")[2]:
            return PlainTextResponse("There is no such file.", 404)
        if not is_signed_in(request):
            return _not_signed_in(request)
        return FileResponse(
            self._frontend.index, media_type="text/html", headers={"Cache-Control": "no-store"}
        )


def _sign_in(request: Request) -> Response:
    access = services_of(request).access
    if not access.is_token(request.query_params["token"]):
        return _small_page(
            401,
            "This address does not fit",
            "Its token is not the one of this server. Open the address that Tril printed when it "
            "started.",
        )
    answer = Response(status_code=303, headers={"Location": "/", "Cache-Control": "no-store"})
    answer.set_cookie(
        access.cookie_name,
        access.new_cookie(),
        max_age=COOKIE_LIFETIME_S,
        path="/",
        httponly=True,
        samesite="strict",
        secure=request.url.scheme == "https",
    )
    return answer


def _not_signed_in(request: Request) -> Response:
    # Browsers withhold a SameSite=Strict cookie when a link on another site leads here. A reload
    # starts from this page and sends the cookie.
    again = request.headers.get("sec-fetch-site") in {"cross-site", "same-site"}
    # One leading slash and everything quoted, so that the address stays on this server.
    here = quote("/" + request.url.path.lstrip("/"))
    head = f'\n<meta http-equiv="refresh" content="0; url={here}">' * again
    return _small_page(
        401,
        "You are not signed in",
        "Open the address that Tril printed when it started; it contains the key. If it is gone "
        "from the terminal, stop Tril and start it again.",
        head,
    )


def _small_page(status: int, title: str, text: str, head: str = "") -> Response:
    return HTMLResponse(
        _PAGE.format(title=title, text=text, head=head),
        status,
        headers={"Cache-Control": "no-store"},
    )

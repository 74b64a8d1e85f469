"""The pages: the files of the built frontend, and sign-in by token."""

from __future__ import annotations

import asyncio
import mimetypes
import re
from pathlib import Path
from urllib.parse import quote

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, PlainTextResponse, Response
from starlette.types import Receive, Scope, Send

from server.dependencies import services_of
from server.web.compression import accepts, compressed, is_compressible
from server.web.preloads import PRELOADS, Preload, Subject, read_preloads, subject_of
from server.web.problems import problem
from server.web.sign_in import join, sign_in
from server.web.small_pages import SmallPages
from tril.errors import Unavailable
from tril.store.access import invitations
from tril.store.database import Database

FRONTEND = Path(__file__).with_name("static")
_HASHED = "/assets/"
"""Where the build puts files whose names change with their content."""
_BROTLI = ".br"
"""Ending of files that the build has compressed, beside those that they hold."""
_IMMUTABLE = "public, max-age=31536000, immutable"


def share_parts(folder: Path = FRONTEND) -> tuple[str, str]:
    """Return style and script of pages that are sent, see trainer.sharing.

    Args:
        folder: The build.

    Raises:
        Unavailable: The frontend was not built.
    """
    paths = [folder / "share" / name for name in ("share.css", "share.js")]
    if missing := [path for path in paths if not path.is_file()]:
        raise Unavailable(
            f"The page has not been built: {missing[0]} is missing. Run `make frontend`."
        )
    style, script = (path.read_text(encoding="utf-8").strip() for path in paths)
    return style, script


class Frontend:
    """The built frontend; only files found by listing its folder are served.

    Args:
        folder: The build.
    """

    def __init__(self, folder: Path = FRONTEND) -> None:
        self._folder = folder
        self._built_at: int | None = None
        self._files: dict[str, Path] = {}
        self._compressed: dict[Path, bytes] = {}
        self._preloads: list[Preload] = []

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
                if file.is_file() and not file.is_symlink() and file.suffix != _BROTLI
            }
            self._files.pop(f"/{PRELOADS}", None)
            self._compressed = {}
            self._preloads = read_preloads(self._folder)
            self._built_at = built_at
        return self._files.get(path)

    def preload(self, path: str) -> tuple[Preload, str] | None:
        """Return what the page at a path needs, and its id if any; None for other pages."""
        for preload in self._preloads:
            if match := preload.path.fullmatch(path):
                return preload, match[1] if preload.path.groups else ""
        return None

    def page(self, links: str = "") -> str:
        """Return the application's page with links to what is needed first."""
        page = self.index.read_text(encoding="utf-8")
        return page.replace("</head>", f"{links}</head>", 1)

    @property
    def stylesheets(self) -> list[str]:
        """Paths of the stylesheets that the application's page has; none without a build."""
        try:
            page = self.index.read_text(encoding="utf-8")
        except Unavailable:
            return []
        return re.findall(r'<link rel="stylesheet"[^>]* href="([^"]+)"', page)

    def brotli(self, file: Path) -> Path | None:
        """Return the file that holds another with Brotli, None if the build made none."""
        path = file.with_name(file.name + _BROTLI)
        return path if path.is_file() and not path.is_symlink() else None

    async def compressed(self, file: Path) -> bytes:
        """Return a file's content with gzip, compressed once per build."""
        if file not in self._compressed:
            self._compressed[file] = await compressed(await asyncio.to_thread(file.read_bytes))
        return self._compressed[file]


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
        request = Request(scope, receive)
        path = request.url.path
        if path == "/api" or path.startswith("/api/"):
            answer: Response = problem(404, f"There is nothing at {path}.")
        elif path == invitations.PATH:
            answer = await join(request, self._small(request))
        elif request.method not in {"GET", "HEAD"}:
            answer = problem(405, "Pages can only be read.")
            answer.headers["Allow"] = "GET, HEAD"
        else:
            answer = await self._page(request, path)
        await answer(scope, receive, send)

    def _small(self, request: Request) -> SmallPages:
        return SmallPages(request, self._frontend.stylesheets)

    async def _page(self, request: Request, path: str) -> Response:
        if path == "/" and b"token=" in request.scope["query_string"]:
            return await sign_in(request, self._small(request))
        file = self._frontend.find(path)
        if file is not None and file != self._frontend.index:
            media_type = mimetypes.guess_type(file.name)[0] or "application/octet-stream"
            cached = _IMMUTABLE if path.startswith(_HASHED) else "no-cache"
            return await self._file(request, file, media_type, cached)
        if "." in path.rpartition("/")[2]:
            return PlainTextResponse("There is no such file.", 404)
        identity = await services_of(request).access.identify(request)
        if identity is None:
            return _not_signed_in(request, self._small(request))
        links = ""
        if found := self._frontend.preload(path):
            preload, shown = found
            # Participants may not read some of the data.
            if identity.is_participant:
                links = preload.files
            else:
                database = services_of(request).database
                links = preload.links(
                    await run_in_threadpool(_subject_of, database, preload.shows, shown)
                )
        page = self._frontend.page(links)
        return HTMLResponse(page, headers={"Cache-Control": "no-store"})

    async def _file(
        self, request: Request, file: Path, media_type: str, cache_control: str
    ) -> Response:
        headers = {"Cache-Control": cache_control}
        if not is_compressible(media_type):
            return FileResponse(file, media_type=media_type, headers=headers)
        headers["Vary"] = "Accept-Encoding"
        if accepts(request.headers, "br") and (brotli := self._frontend.brotli(file)):
            headers["Content-Encoding"] = "br"
            return FileResponse(brotli, media_type=media_type, headers=headers)
        if not accepts(request.headers, "gzip"):
            return FileResponse(file, media_type=media_type, headers=headers)
        headers["Content-Encoding"] = "gzip"
        content = await self._frontend.compressed(file)
        return Response(content, media_type=media_type, headers=headers)


def _not_signed_in(request: Request, pages: SmallPages) -> Response:
    # Browsers withhold a SameSite=Strict cookie when a link on another site leads here. A reload
    # starts from this page and sends the cookie.
    again = request.headers.get("sec-fetch-site") in {"cross-site", "same-site"}
    # One leading slash and everything quoted, so that the address stays on this server.
    path = quote("/" + request.url.path.lstrip("/"))
    head = f'\n<meta http-equiv="refresh" content="0; url={path}">' * again
    return pages.key_page(pages.texts.signed_out, pages.texts.signed_out_why, head)


def _subject_of(database: Database, shows: str | None, shown: str) -> Subject:
    with database.reading() as session:
        return subject_of(session, shows, shown)

"""The web application."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import cache
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Depends, FastAPI
from fastapi.routing import APIRoute
from starlette.middleware import Middleware
from starlette.routing import BaseRoute

from server.api import (
    artifacts,
    behaviours,
    blind,
    catalogue,
    events,
    games,
    health,
    imports,
    people,
    rankings,
    recordings,
    replays,
    runs,
    system,
    things,
)
from server.dependencies import limited_by
from server.play import stream
from server.play.rules import DEFAULT_RULES, PlayRules
from server.play.watch import stream as watch_stream
from server.services import running_services
from server.web import permissions, problems, submissions
from server.web.compression import Compression
from server.web.exposure import TrustedProxies
from server.web.middleware import (
    Authentication,
    BodyLimit,
    SameOrigin,
    SecurityHeaders,
)
from server.web.pages import FRONTEND, Frontend, Pages, check_frontend
from server.web.security_headers import SECURITY_HEADERS
from server.web.submissions import Submissions
from tril import __version__
from tril.settings import Settings
from tril.store.rankings import RankingConflict

__all__ = ["check_frontend", "create_app"]


class _Application(FastAPI):
    def openapi(self) -> dict[str, Any]:
        if self.openapi_schema is None:
            problems.describe_once(super().openapi())
        return super().openapi()


def create_app(
    settings: Settings, frontend: Path = FRONTEND, rules: PlayRules = DEFAULT_RULES
) -> FastAPI:
    """Build the application. Nothing is opened before its lifespan begins.

    Args:
        settings: The data folder and the host names that are answered.
        frontend: Folder of the built frontend.
        rules: The times by which games are played and kept.
    """

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        async with running_services(settings, rules) as services:
            app.state.services = services
            yield

    app = _Application(
        title="Tril",
        version=__version__,
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        openapi_url="/api/openapi.json",
        routes=_routes(),
        middleware=[
            *([Middleware(TrustedProxies, settings=settings)] if settings.proxies else []),
            Middleware(SecurityHeaders),
            Middleware(Compression),
            Middleware(SameOrigin, host_names=settings.host_names),
            Middleware(Authentication),
            Middleware(BodyLimit),
            Middleware(Submissions),
        ],
    )
    problems.install(app, SECURITY_HEADERS)
    submissions.install(app)
    app.add_exception_handler(RankingConflict, rankings.on_conflict)
    # The pages get only what no route matches, so that a wrong method answers 405.
    app.router.default = Pages(Frontend(frontend))
    return app


@cache
def _routes() -> list[BaseRoute]:
    """Build the routes, which takes half a second, once for all applications of this process."""
    app = FastAPI(openapi_url=None, generate_unique_id_function=_operation_id)
    app.include_router(_api(), dependencies=[Depends(permissions.check_permission)])
    return app.router.routes


def _api() -> APIRouter:
    api = APIRouter(prefix="/api", responses=problems.PROBLEMS)
    requests = limited_by(lambda s, writes: s.write_limit if writes else s.read_limit)
    uploads = limited_by(lambda s, _: s.upload_limit)
    replaying = limited_by(lambda s, _: s.replay_limit)
    resources = (system, people, catalogue, behaviours, recordings, rankings, games, runs, blind)
    routers = [(resource.router, [requests]) for resource in resources]
    # An object store that hangs keeps a thread for half a minute.
    routers.insert(1, (system.joining_router, [replaying]))
    routers += [(artifacts.router, [replaying]), (imports.router, [uploads])]
    routers += [(rankings.borrowed_router, [requests])]
    slow = (
        replays.router,
        blind.frames_router,
        rankings.slow_router,
        things.router,
        artifacts.archive_router,
    )
    for router in slow:
        routers.append((router, [replaying]))
    for unlimited in (health, events, stream, watch_stream):
        routers.append((unlimited.router, []))
    for router, limits in routers:
        api.include_router(router, dependencies=limits)
    permissions.check_all_declared(route.name for router, _ in routers for route in router.routes)
    return api


def _operation_id(route: APIRoute) -> str:
    return route.name

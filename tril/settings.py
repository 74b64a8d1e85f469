"""Configuration, read by entry points and passed to everything else."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Literal

from pydantic import Field, field_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

PREFIX = "TRIL_"
_INTERNAL = frozenset({"TRIL_PARENT_PID"})
"""Set by Tril itself."""


class Settings(BaseSettings):
    """Settings of every Tril process, read from the environment (``TRIL_*``) and ``.env``.

    Attributes:
        data: Folder of databases, artifacts, caches, the access token and sockets.
        host: Address the server binds to.
        port: TCP port the server binds to.
        allowed_hosts: Host names (without port) accepted in requests besides the loopback names,
            comma-separated.
        database_url: SQLAlchemy URL of the application's database; SQLite in ``data`` if empty.
        jobs_database_url: URL of the job queue's own database; SQLite in ``data`` if empty.
        artifacts_url: fsspec URL of the artifact store; a folder in ``data`` if empty.
        cache_limit_bytes: Maximum size of cached files (frames, thumbnails) on disk.
        server_processes: Server processes behind one port; 1 suffices for a few players, use one
            per core for many.
        max_games: Maximum number of open games; 0 means 32 per server process.
        max_games_per_player: Maximum number of open games per person. All browsers with the
            printed key are one person.
        max_recordings_per_player: Maximum number of recordings that are stored per person.
        max_queued_runs: Maximum number of runs that wait in the queue; further ones are refused.
        max_queued_runs_per_player: Maximum number of those per person.
        learning_threads: Threads for training; 0 means all cores.
        learning_precision: Number format of policy training: "float32", "bfloat16", or "auto" for
            bfloat16 where the device supports its multiplication.
        learning_device: Device for training: "cpu", "cuda", or "auto" for a GPU if there is one.
    """

    model_config = SettingsConfigDict(env_prefix=PREFIX, env_file=".env", extra="ignore")

    data: Path = Path("data")
    host: str = "127.0.0.1"
    port: int = Field(default=8000, ge=0, le=65535)
    allowed_hosts: str = ""
    database_url: str = ""
    jobs_database_url: str = ""
    artifacts_url: str = ""
    cache_limit_bytes: int = Field(default=512 * 1024 * 1024, ge=0)
    server_processes: int = Field(default=1, ge=1, le=64)
    max_games: int = Field(default=0, ge=0)
    max_games_per_player: int = Field(default=32, ge=1)
    max_recordings_per_player: int = Field(default=20_000, ge=1)
    max_queued_runs: int = Field(default=50, ge=1)
    max_queued_runs_per_player: int = Field(default=50, ge=1)
    learning_threads: int = Field(default=0, ge=0)
    learning_precision: Literal["auto", "float32", "bfloat16"] = "auto"
    learning_device: Literal["auto", "cpu", "cuda"] = "auto"

    @field_validator("data")
    @classmethod
    def _absolute(cls, value: Path) -> Path:
        return value.expanduser().resolve()

    @property
    def application_url(self) -> str:
        """URL of the application's database."""
        return self.database_url or f"sqlite:///{self.data / 'tril.sqlite'}"

    @property
    def queue_url(self) -> str:
        """URL of the job queue's database."""
        return self.jobs_database_url or f"sqlite:///{self.data / 'jobs.sqlite'}"

    @property
    def artifact_root(self) -> str:
        """fsspec URL of the artifact store."""
        return self.artifacts_url or str(self.data / "artifacts")

    @property
    def cache_folder(self) -> Path:
        """Folder of cached files."""
        return self.data / "cache"

    @property
    def inference_socket(self) -> Path:
        """Local socket of the inference process."""
        return self.data / "inference.sock"

    @property
    def token_file(self) -> Path:
        """File (mode 0600) that holds the access token and the cookie secret."""
        return self.data / "secrets.json"

    @property
    def host_names(self) -> frozenset[str]:
        """Lower-case host names accepted in a request's Host and Origin headers."""
        extra = {name.strip().lower() for name in self.allowed_hosts.split(",") if name.strip()}
        return frozenset({"127.0.0.1", "localhost", "[::1]", "::1"} | extra)


def unknown_settings(names: Iterable[str]) -> dict[str, str | None]:
    """Return the variables that look like settings and are none, each with the nearest setting.

    Args:
        names: Names of environment variables, in upper case.
    """
    known = [f"{PREFIX}{name}".upper() for name in Settings.model_fields]
    wrong = sorted(
        name for name in names if name.startswith(PREFIX) and name not in {*known, *_INTERNAL}
    )
    return {name: next(iter(get_close_matches(name, known, 1)), None) for name in wrong}

"""The one place where configuration is read. Entry points read it, everything else is passed it."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field, field_validator
from pydantic_settings import BaseSettings, SettingsConfigDict


class Settings(BaseSettings):
    """Settings of every Tril process, read from the environment (``TRIL_*``) and ``.env``.

    Attributes:
        data: Folder of everything Tril keeps: databases, artifacts, caches, token, sockets.
        host: Address the server binds to.
        port: TCP port the server binds to.
        allowed_hosts: Host names (without port) that requests may name, comma separated in the
            environment. The loopback names are always allowed.
        database_url: SQLAlchemy URL of the application's database; SQLite in ``data`` if empty.
        jobs_database_url: URL of the job queue's own database; SQLite in ``data`` if empty.
        artifacts_url: fsspec URL of the artifact store; a folder in ``data`` if empty.
        cache_limit_bytes: Upper bound of re-derived files (frames, thumbnails) kept on disk.
        server_processes: Server processes behind one port; 1 is enough for a house, one per core
            for many players.
        max_games: Most games open at the same time, of everybody; 0 means as many as the server
            processes can play, 32 each.
        max_games_per_player: Most games of one player open at the same time. Everybody who opens
            the page with the same key is one player.
        learning_threads: Threads that learning may use; 0 means all cores.
        learning_precision: The numbers that policies learn in: "float32", "bfloat16", or "auto" for
            the shorter ones where the device multiplies them.
        learning_device: Where networks learn: "cpu", "cuda", or "auto" for a GPU if there is one.
    """

    model_config = SettingsConfigDict(env_prefix="TRIL_", env_file=".env", extra="ignore")

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
        """URL of the job queue's database, apart from the application's."""
        return self.jobs_database_url or f"sqlite:///{self.data / 'jobs.sqlite'}"

    @property
    def artifact_root(self) -> str:
        """fsspec URL under which artifacts are kept."""
        return self.artifacts_url or str(self.data / "artifacts")

    @property
    def cache_folder(self) -> Path:
        """Folder of re-derivable files."""
        return self.data / "cache"

    @property
    def inference_socket(self) -> Path:
        """Local socket on which the inference process answers."""
        return self.data / "inference.sock"

    @property
    def token_file(self) -> Path:
        """File (mode 0600) that holds the access token and the cookie secret."""
        return self.data / "secrets.json"

    @property
    def host_names(self) -> frozenset[str]:
        """Lower-case host names that a request's Host and Origin may carry."""
        extra = {name.strip().lower() for name in self.allowed_hosts.split(",") if name.strip()}
        return frozenset({"127.0.0.1", "localhost", "[::1]", "::1"} | extra)

"""Configuration, read by entry points and passed to everything else."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, SecretStr, field_validator, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict
from sqlalchemy import URL

from tril.addresses import (
    Network,
    TcpAddress,
    is_loopback,
    parse_networks,
    parse_tcp_address,
)
from tril.errors import Invalid
from tril.text import clean_line

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
        tls_certificate: PEM file of the server's certificate, with those that lead to a known
            authority; without it the server speaks plain HTTP.
        tls_key: PEM file of the certificate's key, without a password.
        trusted_proxies: Addresses and networks of proxies, comma-separated, whose forwarded headers
            are believed.
        plain_http: Whether an address that is open to other machines may be served, and a server or
            an inference process of another machine asked, without TLS.
        database_url: SQLAlchemy URL of the application's database; SQLite in ``data`` if empty.
        jobs_database_url: URL of the job queue's database. If empty, the queue is in the
            application's database where that is PostgreSQL, else SQLite in ``data``.
        artifacts_url: fsspec URL of the artifact store; a folder in ``data`` if empty.
        cache_limit_bytes: Maximum size of cached files (frames, film strips) on disk.
        server_processes: Server processes behind one port; 1 suffices for a few players, use one
            per core for many.
        max_games: Maximum number of open games; 0 means 32 per server process.
        max_games_per_player: Maximum number of open games per person. All browsers with the
            printed key are one person.
        max_recordings_per_player: Maximum number of recordings that are stored per person.
        max_runs_per_player: Maximum number of runs that are stored per person.
        max_connections: Maximum number of connections to a server process.
        max_connections_per_address: Maximum number of these from one address.
        max_queued_runs: Maximum number of runs that wait in the queue; further ones are refused.
        max_queued_runs_per_player: Maximum number of those per person.
        worker_key: Key with which ``tril worker --join`` asks a server of another machine.
        worker_key_file: File that has this key.
        inference_address: Address at which the inference process answers instead of on a socket in
            ``data``: ``tls://HOST:PORT``, or ``tcp://HOST:PORT`` without encryption.
        inference_key: Key that the inference process and the servers prove to each other there.
        inference_key_file: File that has this key.
        learning_threads: Threads for training; 0 means all cores.
        learning_niceness: Niceness of workers, from 0 to 19, which leaves the cores to games first.
        learning_precision: Number format of policy training: "float32", "bfloat16", or "auto" for
            bfloat16 where the device supports its multiplication.
        learning_device: Device for training: "cpu", "cuda", or "auto" for a GPU if there is one.
    """

    model_config = SettingsConfigDict(env_prefix=PREFIX, env_file=".env", extra="ignore")

    data: Path = Path("data")
    host: str = "127.0.0.1"
    port: int = Field(default=8000, ge=0, le=65535)
    allowed_hosts: str = ""
    tls_certificate: Path | None = None
    tls_key: Path | None = None
    trusted_proxies: str = ""
    plain_http: bool = False
    database_url: str = ""
    jobs_database_url: str = ""
    artifacts_url: str = ""
    cache_limit_bytes: int = Field(default=512 * 1024 * 1024, ge=0)
    server_processes: int = Field(default=1, ge=1, le=64)
    max_games: int = Field(default=0, ge=0)
    max_games_per_player: int = Field(default=8, ge=1)
    max_recordings_per_player: int = Field(default=20_000, ge=1)
    max_runs_per_player: int = Field(default=5_000, ge=1)
    # Below 1024, the usual limit of open files, with room for files and the database.
    max_connections: int = Field(default=768, ge=1)
    max_connections_per_address: int = Field(default=256, ge=1)
    max_queued_runs: int = Field(default=50, ge=1)
    max_queued_runs_per_player: int = Field(default=25, ge=1)
    worker_key: SecretStr = SecretStr("")
    worker_key_file: Path | None = None
    inference_address: str = ""
    inference_key: SecretStr = SecretStr("")
    inference_key_file: Path | None = None
    learning_threads: int = Field(default=0, ge=0)
    learning_niceness: int = Field(default=19, ge=0, le=19)
    learning_precision: Literal["auto", "float32", "bfloat16"] = "auto"
    learning_device: Literal["auto", "cpu", "cuda"] = "auto"

    @field_validator("data", mode="before")
    @classmethod
    def _is_named(cls, value: Any) -> Any:
        if value == "":
            raise ValueError("name a folder, or leave the setting out")
        return value

    @field_validator("data")
    @classmethod
    def _absolute(cls, value: Path) -> Path:
        try:
            return value.expanduser().resolve()
        except RuntimeError as error:
            # Nobody's home, or links that go in circles.
            raise ValueError(str(error)) from error

    @field_validator(
        "tls_certificate", "tls_key", "worker_key_file", "inference_key_file", mode="before"
    )
    @classmethod
    def _none_if_empty(cls, value: Any) -> Any:
        return None if value == "" else value

    @field_validator(
        "host",
        "allowed_hosts",
        "trusted_proxies",
        "database_url",
        "jobs_database_url",
        "artifacts_url",
        "inference_address",
    )
    @classmethod
    def _is_a_line(cls, value: str) -> str:
        clean_line(value)
        # As it was given: spaces belong to the name of a folder.
        return value

    @field_validator("trusted_proxies")
    @classmethod
    def _are_networks(cls, value: str) -> str:
        parse_networks(value)
        return value

    @field_validator("inference_address")
    @classmethod
    def _is_address(cls, value: str) -> str:
        if value:
            parse_tcp_address(value)
        return value

    @model_validator(mode="after")
    def _certificate_and_key(self) -> Self:
        if (self.tls_certificate is None) != (self.tls_key is None):
            raise ValueError("TRIL_TLS_CERTIFICATE and TRIL_TLS_KEY have to be set together")
        return self

    @property
    def uses_tls(self) -> bool:
        """Whether the server itself speaks HTTPS."""
        return self.tls_certificate is not None

    @property
    def is_local(self) -> bool:
        """Whether only this machine can reach the server."""
        return is_loopback(self.host)

    @property
    def proxies(self) -> tuple[Network, ...]:
        """Networks of the proxies whose forwarded headers are believed."""
        return parse_networks(self.trusted_proxies)

    @property
    def application_url(self) -> str:
        """URL of the application's database."""
        return self.database_url or self._sqlite_url("tril.sqlite")

    @property
    def queue_url(self) -> str:
        """URL of the job queue's database."""
        if self.jobs_database_url:
            return self.jobs_database_url
        # Workers of other machines reach it there, and its tables have a schema of their own.
        is_shared = self.database_url.startswith("postgresql")
        return self.database_url if is_shared else self._sqlite_url("jobs.sqlite")

    def _sqlite_url(self, name: str) -> str:
        """Return the URL of an SQLite file in the data folder, whatever that is called."""
        url = URL.create("sqlite", database=str(self.data / name))
        return url.render_as_string(hide_password=False)

    @property
    def artifact_root(self) -> str:
        """fsspec URL of the artifact store."""
        return self.artifacts_url or str(self.data / "artifacts")

    @property
    def cache_folder(self) -> Path:
        """Folder of cached files."""
        return self.data / "cache"

    @property
    def upgrade_copies(self) -> Path:
        """Folder of the databases as they were before the last upgrades."""
        return self.data / "before-upgrades"

    @property
    def inference_socket(self) -> Path:
        """Local socket of the inference process."""
        return self.data / "inference.sock"

    @property
    def inference_tcp_address(self) -> TcpAddress | None:
        """Address of the inference process; None if it answers on the local socket."""
        return parse_tcp_address(self.inference_address) if self.inference_address else None

    def secret(self, name: Literal["worker_key", "inference_key"]) -> str:
        """Return a key from its setting, else from the file that is named; empty without both.

        Raises:
            Invalid: The file can't be read, or the key has characters that no key has.
        """
        key: str = getattr(self, name).get_secret_value()
        path: Path | None = getattr(self, f"{name}_file")
        if not key and path is not None:
            try:
                key = path.expanduser().read_text(encoding="utf-8")
            except (OSError, UnicodeDecodeError, RuntimeError) as error:
                raise Invalid(
                    f"The key in {path} ({PREFIX}{name.upper()}_FILE) can't be read: {error}."
                ) from error
        return checked_key(key)

    @property
    def token_file(self) -> Path:
        """File (mode 0600) that holds the access token and the cookie secret."""
        return self.data / "secrets.json"

    @property
    def host_names(self) -> frozenset[str]:
        """Lower-case host names accepted in a request's Host and Origin headers."""
        return frozenset({"127.0.0.1", "localhost", "[::1]", "::1", *self.further_host_names})

    @property
    def further_host_names(self) -> list[str]:
        """The names in ``allowed_hosts``, lower case."""
        names = (name.strip().lower() for name in self.allowed_hosts.split(","))
        return [name for name in names if name]


def checked_key(key: str) -> str:
    """Return a key without what surrounds it; raises Invalid if it has what no key has."""
    key = key.strip()
    if not key.isascii() or not key.isprintable() or " " in key:
        raise Invalid("The key has characters that no key has; copy it again.")
    return key


def unknown_settings(names: Iterable[str]) -> dict[str, str | None]:
    """Return the variables that look like settings and are none, each with the nearest setting.

    Args:
        names: Names of environment variables, in upper case.
    """
    known_names = [f"{PREFIX}{name}".upper() for name in Settings.model_fields]
    wrong = sorted(
        name for name in names if name.startswith(PREFIX) and name not in {*known_names, *_INTERNAL}
    )
    return {name: next(iter(get_close_matches(name, known_names, 1)), None) for name in wrong}

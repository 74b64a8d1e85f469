"""What workers of other machines have to reach: the database, the queue, the files of runs."""

from __future__ import annotations

import hashlib

from sqlalchemy import make_url

from tril.errors import Conflict
from tril.settings import Settings
from tril.store.access.credentials import Identity


def refuse_unshared(settings: Settings) -> None:
    """Raise Conflict if the data is kept where only this machine can use it.

    Raises:
        Conflict: A database is SQLite, or the files of runs are in the data folder; says which
            settings have to change.
    """
    problems = []
    urls = (settings.application_url, settings.queue_url)
    if any(make_url(url).get_backend_name() == "sqlite" for url in urls):
        problems.append(
            "its database or job queue is SQLite, which only one machine can use: set"
            " TRIL_DATABASE_URL to a PostgreSQL database, and leave TRIL_JOBS_DATABASE_URL empty"
        )
    if not settings.artifacts_url:
        problems.append(
            "the files of its runs are in its data folder: set TRIL_ARTIFACTS_URL to a shared"
            " folder or an object store"
        )
    if problems:
        raise Conflict(
            f"Workers of other machines can't join this server: {'; '.join(problems)}."
            " docs/databases.md says how."
        )


def probe_of(worker: Identity) -> tuple[str, str]:
    """Return path and content of the file by which a worker's key knows the artifact store.

    It is the same for every worker with the key, so that those who join at once don't disturb each
    other, and it tells nothing of the key.
    """
    content = hashlib.sha256(f"tril artifact store {worker.secret_hash}".encode()).hexdigest()
    return f"workers/key-{worker.credential_id}", content

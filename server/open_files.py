"""How many files a server process may open."""

from __future__ import annotations

import resource

from tril.errors import Unavailable
from tril.settings import Settings

OWN_FILES = 224
"""Files that a server process opens beside those of its connections, with room to spare."""


def allow_open_files(settings: Settings) -> None:
    """Let this process open a file for each connection, besides its own.

    At the limit the emulator, which finds that it can't open its ROM, would end the process with
    all games.

    Raises:
        Unavailable: The system does not allow so many; says what to do.
    """
    needed = settings.max_connections + OWN_FILES
    allowed, maximum = resource.getrlimit(resource.RLIMIT_NOFILE)
    if allowed == resource.RLIM_INFINITY or allowed >= needed:
        return
    if maximum != resource.RLIM_INFINITY and maximum < needed:
        raise Unavailable(
            f"A server for {settings.max_connections} connections opens up to {needed} files, and"
            f" this system allows {maximum}. Allow more (ulimit -n {needed}), or fewer connections"
            " (TRIL_MAX_CONNECTIONS)."
        )
    resource.setrlimit(resource.RLIMIT_NOFILE, (needed, maximum))

"""A progress bar for what the command itself works on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.progress import Progress as Bar

from cli.output import errors


class Watched:
    """Shows how far the work is, as learning functions report it."""

    def __init__(self, bar: Bar, label: str) -> None:
        self._bar = bar
        self._task = bar.add_task(label)

    def advance(self, done: int, total: int, values: object = None) -> None:
        """Show how much is done."""
        self._bar.update(self._task, completed=done, total=total)


@contextmanager
def progress_bar(label: str) -> Iterator[Watched]:
    """Show a bar until the work is done, then take it away."""
    with Bar(console=errors, transient=True) as bar:
        yield Watched(bar, label)

"""A progress bar for work done by the command itself."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.progress import Progress as Bar

from cli.output import errors


class ProgressReporter:
    """Shows the progress that learning functions report."""

    def __init__(self, bar: Bar, label: str) -> None:
        self._bar = bar
        self._task = bar.add_task(label)

    def advance(self, done: int, total: int, values: object = None) -> None:
        """Update the bar."""
        self._bar.update(self._task, completed=done, total=total)


@contextmanager
def progress_bar(label: str) -> Iterator[ProgressReporter]:
    """Show a bar while the work goes on, then remove it."""
    with Bar(console=errors, transient=True) as bar:
        yield ProgressReporter(bar, label)

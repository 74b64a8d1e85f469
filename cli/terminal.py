"""What the command line prints on."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from tril.text import printable


class PlainConsole(Console):
    """A console on which no text acts: control sequences in what anybody wrote are escaped.

    What is printed, in whatever form, becomes segments; those of the console itself, such as the
    movements of a progress bar, are marked as such.
    """

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """Return a renderable as segments of text that is safe to print."""
        for segment in super().render(renderable, options):
            if segment.control:
                yield segment
            else:
                yield Segment(printable(segment.text, keep="\n\t"), segment.style)


MORE_MEMORY = "Close other programs, or allow more memory, and start again."
NO_MEMORY = f"Error: There is not enough memory. {MORE_MEMORY}"

console = PlainConsole(highlight=False, soft_wrap=True, markup=False, emoji=False)
errors = PlainConsole(stderr=True, highlight=False, soft_wrap=True, markup=False, emoji=False)

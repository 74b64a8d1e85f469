"""Commands that are imported when they are called: most calls need one of them."""

from __future__ import annotations

import gc
from collections.abc import Mapping
from functools import cached_property
from importlib import import_module
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command, get_group

from cli.terminal import NO_MEMORY, errors

_NO_ROOM = ("failed to map segment", "cannot allocate memory")
"""What the loader of libraries says where memory is limited; Python makes an ImportError of it."""


class LazyCommand(TyperCommand):
    """A command, or a group of commands, known by its name and its help until it is called."""

    def __init__(self, name: str, reference: str, summary: str) -> None:
        """Keep where it is.

        Args:
            name: Name of the command.
            reference: Module and attribute, e.g. "cli.commands.up:up": a function or a Typer.
            summary: First line of its help.
        """
        super().__init__(name=name, help=summary, callback=None, params=[])
        self._reference = reference

    @cached_property
    def command(self) -> Any:
        """The command itself.

        Raises:
            typer.Exit: There is not enough memory to import it.
        """
        module, _, attribute = self._reference.partition(":")
        # Modules stay until the end: looking for garbage among them takes a third of `tril status`.
        gc.disable()
        try:
            target = getattr(import_module(module), attribute)
        except (MemoryError, ImportError) as error:
            message = str(error).lower()
            if isinstance(error, ImportError) and not any(words in message for words in _NO_ROOM):
                raise
            errors.print(NO_MEMORY)
            raise typer.Exit(1) from error
        finally:
            gc.freeze()
            gc.enable()
        if isinstance(target, typer.Typer):
            group = get_group(target)
            group.name = self.name
            return group
        alone = typer.Typer(add_completion=False, pretty_exceptions_show_locals=False)
        alone.command(self.name)(target)
        return get_command(alone)

    def make_context(self, *args: Any, **kwargs: Any) -> Any:
        """Parse the arguments as the command itself does, which the context then runs."""
        return self.command.make_context(*args, **kwargs)


def lazy_group(commands: Mapping[str, tuple[str, str]]) -> type[TyperGroup]:
    """Return a class of groups with these commands.

    Args:
        commands: Reference and summary of each, by name, in the order of the help.
    """
    lazy_commands = {name: LazyCommand(name, *target) for name, target in commands.items()}

    class LazyGroup(TyperGroup):
        def list_commands(self, ctx: Any) -> list[str]:
            return list(lazy_commands)

        def get_command(self, ctx: Any, cmd_name: str) -> Any:
            return lazy_commands.get(cmd_name)

    return LazyGroup

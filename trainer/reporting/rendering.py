"""Pages of Markdown and HTML from the templates beside this module."""

from __future__ import annotations

import base64
import re
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from tril.analysis.summary import Interval


def render(template: str, **view: object) -> str:
    """Return a page.

    Args:
        template: Name of its file in ``templates``.
        view: The template's variables.
    """
    return _environment().get_template(template).render(view)


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("trainer.reporting"),
        undefined=StrictUndefined,
        autoescape=select_autoescape(["html.j2"]),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {
        "number": _number,
        "interval": _interval,
        "counting": _counting,
        "plain": _plain,
        "code": _code,
        "data_url": png_url,
    }
    return environment


def png_url(picture: bytes) -> str:
    """Return a PNG as a URL that holds it."""
    return f"data:image/png;base64,{base64.b64encode(picture).decode()}"


def _plain(text: object) -> str:
    """Return text as Markdown shows it: on one line, no markup, HTML, role or mathematics."""
    escaped = re.sub(r"([\\`*_{}\[\]<>#|~$&])", r"\\\1", " ".join(str(text).split()))
    # At the beginning of a line these make lists and headings.
    return re.sub(r"^(\d+(?=[.)](?:\s|$))|(?=[-+=:]))", r"\1\\", escaped)


def _code(text: object) -> str:
    """Return text for a span of code in Markdown: on one line, without backticks."""
    return " ".join(str(text).split()).replace("`", "'")


def _number(value: float | None, form: str) -> str:
    """Return a number in a format of Python's; nothing for None."""
    return "" if value is None else format(value, form)


def _interval(value: Interval | None, form: str = ".2f") -> str:
    """Return a mean with its interval in brackets; nothing for None."""
    if value is None:
        return ""
    return f"{value.mean:{form}} [{value.low:{form}}, {value.high:{form}}]"


def _counting(count: int, noun: str) -> str:
    """Format a count: "1 stray", "2 strays"."""
    return f"{count} {noun}" + ("" if count == 1 else "s")

"""Text that people and other programs write: what is accepted, compared and shown of it.

Every text that comes in goes through ``clean_line`` or ``clean_lines``, whichever way it comes: a
request, a form, an import, a command, the environment. They refuse what can't be seen or changes
how other text is seen: control characters, overrides of the writing direction, invisible
characters, characters that Unicode has not assigned. Joiners and variation selectors are accepted
where writing needs them (RFC 5892, appendices A.1 and A.2; Unicode Technical Standard 51), and at
most four nonspacing marks in a row (Unicode Technical Standard 39, section 5.4).
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Annotated, Any

from pydantic import BeforeValidator

from tril.errors import Invalid

MAX_MARKS = 4
"""Most nonspacing marks on one character."""

_REFUSED = {
    "Cc": "a control character",
    "Cf": "an invisible character",
    "Cs": "half of a character",
    "Co": "a character that means nothing elsewhere",
    "Cn": "a character that Unicode has not assigned",
    "Zl": "a line break",
    "Zp": "a line break",
}
"""What is refused, by Unicode's general category."""
_ZWNJ, _ZWJ = "\u200c", "\u200d"
_DIRECTIONS = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
_BLANKS = frozenset("\u034f\u115f\u1160\u17b4\u17b5\u2800\u3164\uffa0\ufffc\U0001d159")
"""Letters, marks and symbols that show nothing."""
_NUMBER_SIGNS = frozenset(
    "\u0600\u0601\u0602\u0603\u0604\u0605\u06dd\u070f\u0890\u0891\u08e2\U000110bd\U000110cd"
)
"""Format characters that are seen: signs around Arabic, Syriac and Kaithi numbers."""
_TAGS = (
    "".join(chr(0xE0000 + ord(letter)) for letter in code) for code in ("gbeng", "gbsct", "gbwls")
)
_FLAGS = re.compile(f"\U0001f3f4(?:{'|'.join(_TAGS)})\U000e007f")
"""The flags of England, Scotland and Wales, which are spelled with tags."""
_SPACES = re.compile("[ \t\u00a0\u1680\u2000-\u200a\u202f\u205f\u3000]+")
_LINE_BREAKS = re.compile("\r\n|[\r\x85\u2028\u2029]")
_KEPT_IN_LINES = "\n\t"
_REPLACEMENT = "\ufffd"


class TextRefused(Invalid, ValueError):
    """A text that can't be accepted; says which character is wrong, and what to do.

    Attributes:
        character: The character, as U+200B; None if the text is too long.
    """

    def __init__(self, message: str, character: str | None = None) -> None:
        super().__init__(message)
        self.character = character


def clean_line(text: str, max_length: int | None = None) -> str:
    """Return a name or another text of one line as it is stored.

    It is composed (NFC), without spaces at its ends and with single ones between words. Unless it
    is empty, something of it is seen.

    Args:
        text: Text as entered.
        max_length: Most characters accepted, counted after cleaning.

    Raises:
        TextRefused: It has a character that can't be accepted, or is too long.
    """
    return _checked(_composed_line(text), max_length, "")


def clean_lines(text: str, max_length: int | None = None) -> str:
    """Return a text of any number of lines as it is stored: composed (NFC), with LF between lines.

    Args:
        text: Text as entered.
        max_length: Most characters accepted, counted after cleaning.

    Raises:
        TextRefused: It has a character that can't be accepted, or is too long.
    """
    return _checked(_composed_lines(text), max_length, _KEPT_IN_LINES)


def shown_line(text: str, max_length: int | None = None) -> str:
    """Return a stored text such that ``clean_line`` accepts it.

    Earlier versions stored what is refused today. Each such character becomes U+FFFD.
    """
    return _replaced(_composed_line(text)[:max_length].rstrip(" "), "")


def shown_lines(text: str, max_length: int | None = None) -> str:
    """Return a stored text such that ``clean_lines`` accepts it, as ``shown_line`` does."""
    return _replaced(_composed_lines(text)[:max_length], _KEPT_IN_LINES)


def shown_json(value: Any) -> Any:
    """Return stored JSON with keys as ``shown_line`` and other texts as ``shown_lines``."""
    return _each_text(value, shown_line, shown_lines)


def _if_text(clean: Callable[[str], str]) -> BeforeValidator:
    return BeforeValidator(lambda value: clean(value) if isinstance(value, str) else value)


Line = Annotated[str, _if_text(clean_line)]
"""A field of one line. Its length is that of the clean text."""
Lines = Annotated[str, _if_text(clean_lines)]
"""A field of any number of lines. Its length is that of the clean text."""


def folded(text: str) -> str:
    """Return the key by which names are compared: names that look the same have the same key.

    Case, other forms of a character (NFKC), spaces of any kind and number, and what is invisible
    make no difference.
    """
    visible = "".join(character for character in text if not _is_invisible(character))
    # Folding case can undo a composition, and composing can leave something to fold.
    for _ in range(2):
        visible = unicodedata.normalize("NFKC", visible).casefold()
    return " ".join(unicodedata.normalize("NFKC", visible).split())


def printable(text: str, keep: str = "") -> str:
    r"""Return a text for a terminal or a log: what is invisible or acts is escaped, as \x1b.

    Args:
        text: Text from any source.
        keep: Characters that stay as they are, such as line breaks.
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        character if character in keep or _is_harmless(character) else ascii(character)[1:-1]
        for character in text
    )


def _composed_line(text: str) -> str:
    # A line break within a name is refused; one at its end comes along when it is pasted.
    return unicodedata.normalize("NFC", _SPACES.sub(" ", text).strip(" \t\r\n"))


def _composed_lines(text: str) -> str:
    return unicodedata.normalize("NFC", _LINE_BREAKS.sub("\n", text))


def _checked(text: str, max_length: int | None, accepted: str) -> str:
    for place, reason in _faults(text, accepted):
        code, name = f"U+{ord(text[place]):04X}", unicodedata.name(text[place], "").lower()
        raise TextRefused(
            f"Character {place + 1} is {code}{name and f' ({name})'}: {reason}. Remove it, or type"
            " the text instead of pasting it.",
            code,
        )
    if max_length is not None and len(text) > max_length:
        raise TextRefused(f"This can have at most {max_length} characters, got {len(text)}.")
    return text


def _replaced(text: str, accepted: str) -> str:
    # A replaced character can leave behind a joiner or a mark that belonged to it.
    while places := {place for place, _ in _faults(text, accepted)}:
        text = "".join(_REPLACEMENT if at in places else c for at, c in enumerate(text))
    return text


def _each_text(value: Any, line: Callable[[str], str], lines: Callable[[str], str]) -> Any:
    match value:
        case str():
            return lines(value)
        case dict():
            return {line(key): _each_text(inner, line, lines) for key, inner in value.items()}
        case list():
            return [_each_text(inner, line, lines) for inner in value]
    return value


def _faults(text: str, accepted: str) -> Iterator[tuple[int, str]]:
    """Yield the place of each character that can't be accepted, and why."""
    if all(map(_is_plain, set(text) - set(accepted))):
        return
    in_flags = {place for flag in _FLAGS.finditer(text) for place in range(*flag.span())}
    n_marks = 0
    for place, character in enumerate(text):
        kind = unicodedata.category(character)
        n_marks = n_marks + 1 if kind in ("Mn", "Me") else 0
        if character in accepted or place in in_flags:
            continue
        if character in (_ZWNJ, _ZWJ):
            if not _joins(text, place):
                yield place, "an invisible character that joins nothing here"
        elif _is_variation_selector(character):
            if not _has_variations(character, text[place - 1 : place]):
                yield place, "an invisible character that changes nothing here"
        elif character in _DIRECTIONS:
            yield place, "an invisible character that changes the direction of writing"
        elif character in _BLANKS:
            yield place, "a character that shows nothing"
        elif kind in _REFUSED and not _is_visible(character):
            yield place, _REFUSED[kind]
        elif n_marks > MAX_MARKS:
            yield place, f"one of more than {MAX_MARKS} marks on one character"
        elif n_marks and (place == 0 or text[place - 1] in " \n\t"):
            yield place, "a mark without a character that it belongs to"


@lru_cache(maxsize=4096)
def _is_plain(character: str) -> bool:
    """Whether a character is accepted wherever it is."""
    kind = unicodedata.category(character)
    return kind not in _REFUSED and kind not in ("Mn", "Me") and character not in _BLANKS


def _joins(text: str, place: int) -> bool:
    """Whether a joiner or non-joiner is where writing or an emoji needs it."""
    before = text[max(0, place - 2) : place].rstrip("\ufe0f")[-1:]
    after = text[place + 1 : place + 2]
    if not before:
        return False
    if unicodedata.combining(before) == 9:
        return True  # After a virama, which Indic scripts draw in several ways.
    if not after:
        return False
    kind = unicodedata.category(before)
    if text[place] == _ZWJ and (kind in ("So", "Sk") or _is_visible(before)):
        return unicodedata.category(after) in ("So", "Sm") or _is_visible(after)
    # Letters without case: the scripts whose letters join (Arabic, Mongolian, Indic) have none.
    within_word = ("Lo", "Lm", "Mn", "Mc")
    return kind in within_word and unicodedata.category(after) in within_word


def _is_variation_selector(character: str) -> bool:
    return (
        "\ufe00" <= character <= "\ufe0f"
        or "\U000e0100" <= character <= "\U000e01ef"
        or character in "\u180b\u180c\u180d\u180f"
    )


def _has_variations(selector: str, before: str) -> bool:
    """Whether a variation selector follows something that is drawn in several ways."""
    if not before or before in _BLANKS:
        return False
    kind = unicodedata.category(before)
    if selector in ("\ufe0e", "\ufe0f"):
        is_emoji = kind in ("So", "Sm", "Sk", "Po", "Pd", "Nd") or before == "\u2139"
        return is_emoji or _is_visible(before)
    return kind == "Lo" or (kind in ("Sm", "So", "Po", "Nd") and selector < "\ufe0e")


def _is_visible(character: str) -> bool:
    """Whether a character of a refused category is visible."""
    # Emoji are added each year, in a range that is reserved for them (Extended_Pictographic).
    is_pictograph = "\U0001f000" <= character <= "\U0001faff"
    is_new = is_pictograph and unicodedata.category(character) == "Cn"
    return is_new or character in _NUMBER_SIGNS


def _is_invisible(character: str) -> bool:
    is_format = unicodedata.category(character) == "Cf" and character not in _NUMBER_SIGNS
    return is_format or character in _BLANKS or _is_variation_selector(character)


def _is_harmless(character: str) -> bool:
    """Whether a terminal shows a character and does nothing else."""
    if character in (_ZWNJ, _ZWJ) or _is_visible(character):
        return True
    return unicodedata.category(character) not in _REFUSED and character not in _BLANKS

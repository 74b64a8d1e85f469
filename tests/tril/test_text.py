"""What is accepted as text, and what becomes of the rest."""

from __future__ import annotations

import json
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tril.text import (
    TextRefused,
    clean_line,
    clean_lines,
    folded,
    printable,
    shown_json,
    shown_line,
    shown_lines,
)

WRITTEN = [
    "Column 5",
    "Zoë Çelik-O’Neill",
    "سارا محمدی",
    "می‌خواهم",  # Persian, with a zero-width non-joiner within the word
    "דוד בן־גוריון",
    "שָׁלוֹם",
    "क्‍ष",  # Devanagari, with a zero-width joiner after a virama
    "അവന്‍",  # Malayalam, with one at the end
    "Nguyễn Thị Hồng",
    "葛\U000e0100城",  # a variant of a letter that names are written with
    "ᠮᠣᠩᠭᠣᠯ",
    "👩🏽‍🚀 ❤️‍🔥 🏳️‍🌈 1️⃣ ℹ️ ☺️ 🇹🇷",
    "🏴\U000e0067\U000e0062\U000e0073\U000e0063\U000e0074\U000e007f",
    "🙂‍↔️",
    "\U0001fae9",  # an emoji that is newer than Python's tables
    "½ × 2 = 1 €",
]

REFUSED = [
    "\0", "\x1b[31m", "\x07", "\x7f", "\x9b", "a\nb", "a\rb", "a\x0bb", "a\x85b",
    "a\u2028b", "a\u2029b",
    *("a" + chr(code) + "b" for code in (*range(0x202A, 0x202F), *range(0x2066, 0x206A))),
    "a\u200eb", "a\u200fb", "a\u061cb",
    "a\u200bb", "a\u200cb", "a\u200db", "a\u2060b", "a\ufeffb", "a\u00adb", "a\u180eb", "a\u2064b",
    "\u200d👩", "👩\u200d", "سارا\u200c", "می\u200c\u200cخواهم",
    "a\ufe0fb", "😀\ufe0f\ufe0f", "a\U000e0100",
    "\ud800", "a\udfffb", "\ue000", "\U0010ffff", "\ufdd0", "\u0378",
    "\U000e0001", "a\U000e0041", "🏴\U000e0061\U000e007f",
    "\u3164", "\u115f", "\uffa0", "\u2800", "\u034f",
    "\u0301a", "a \u0301", "e" + "\u0316" * 5, "a\ufff9b",
]  # fmt: skip


@pytest.mark.parametrize("text", WRITTEN)
def test_what_people_write_is_accepted_as_it_is(text: str) -> None:
    text = unicodedata.normalize("NFC", text)
    assert clean_line(text) == clean_lines(text) == shown_line(text) == text
    assert printable(text) == text or "\U000e007f" in text


@pytest.mark.parametrize("text", REFUSED, ids=ascii)
def test_what_is_not_seen_is_refused_by_name(text: str) -> None:
    with pytest.raises(
        TextRefused, match=r"^Character \d+ is U\+[0-9A-F]{4,6}.* Remove it"
    ) as error:
        clean_line(text)
    assert str(error.value).isprintable()
    assert clean_line(shown_line(text)) == shown_line(text)


def test_the_refusal_says_which_character_and_what_to_do() -> None:
    with pytest.raises(TextRefused) as error:
        clean_line("Column\u200b 5")
    assert str(error.value) == (
        "Character 7 is U+200B (zero width space): an invisible character. Remove it, or type the"
        " text instead of pasting it."
    )


def test_lines_keep_their_breaks_and_nothing_else_that_is_not_seen() -> None:
    assert clean_lines("a\r\nb\rc\u2028d\te\n") == "a\nb\nc\nd\te\n"
    for text in ("a\x0cb", "a\n\u0301", "a\x1bb"):
        with pytest.raises(TextRefused):
            clean_lines(text)


def test_names_are_composed_and_have_single_spaces() -> None:
    assert clean_line(" \tAnna\u00a0 \t\u3000Zoe\u0308\n") == "Anna Zoë"
    assert clean_line(" \u2003 ") == ""


def test_lengths_are_those_of_the_clean_text() -> None:
    assert clean_line("e\u0301" * 80, 80) == "é" * 80
    assert len(shown_line("x" * 90, 80)) == 80
    with pytest.raises(TextRefused, match="at most 80 characters, got 81"):
        clean_line("x" * 81, 80)


@pytest.mark.parametrize(
    "twin",
    [
        "column 5", "COLUMN 5", "Column  5", "Column\u00a05", "Co\u200blumn 5", "Column 5\u2060",
        "Ｃｏｌｕｍｎ　５", "Column ⁵", "\u202eColumn 5", "Column\ufe0f 5", "\u3164Column 5",
        "Co\u00adlumn 5", "Column\n5",
    ],
    ids=ascii,
)  # fmt: skip
def test_names_that_look_the_same_have_the_same_key(twin: str) -> None:
    assert folded(twin) == folded("Column 5")


def test_names_that_look_different_have_different_keys() -> None:
    assert len({folded(text) for text in WRITTEN}) == len(WRITTEN)
    assert folded("Spaß") == folded("SPASS")
    assert folded("Zoe\u0308") == folded("ZOË")


def test_texts_within_json_are_shown_with_their_keys() -> None:
    given = {"e\u0301": ["a\r\nb", 1, None, {"x": 2.5}]}
    assert shown_json(given) == {"é": ["a\nb", 1, None, {"x": 2.5}]}
    assert shown_json({"a\nb": 1}) == {"a\ufffdb": 1}
    assert shown_json([["\ud800", "\0"]]) == [["\ufffd", "\ufffd"]]


def test_a_long_text_is_read_in_linear_time() -> None:
    with pytest.raises(TextRefused):
        clean_lines("क्‍ष" * 50_000 + "\0")


@given(st.text(st.characters(exclude_categories=[]), max_size=40))
def test_whatever_is_stored_is_shown_as_what_would_be_accepted(text: str) -> None:
    for clean, shown in ((clean_line, shown_line), (clean_lines, shown_lines)):
        assert clean(shown(text)) == shown(text)
        json.dumps(shown(text)).encode()
    assert clean_line(shown_line(text, 7), 7) is not None


@given(st.text(st.characters(exclude_categories=[]), max_size=40))
def test_what_is_printed_acts_on_no_terminal(text: str) -> None:
    shown = printable(text)
    assert not any(unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") for c in shown)
    assert printable(shown) == shown
    shown.encode()


@given(st.text(max_size=40))
def test_cleaning_is_idempotent_and_keeps_the_key(text: str) -> None:
    try:
        clean = clean_line(text)
    except TextRefused:
        return
    assert clean_line(clean) == clean
    assert folded(clean) == folded(text)

"""Files that differ from good ones in one place: accepted, or refused with a sentence, in time."""

from __future__ import annotations

import json
import random
import time
import zipfile
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tril.errors import Invalid, TrilError
from tril.exchange.example import EXAMPLE
from tril.exchange.formats.behaviour_file import parse_behaviour
from tril.exchange.formats.jsonl import read_lines
from tril.exchange.formats.recording_object import parse_recording
from tril.exchange.formats.run_file import parse_run
from tril.exchange.run_archive import RANKED, RUN_FILE
from tril.recipes import FAST, checked, recipe_from_dict

MAX_SECONDS = 10.0
MAX_SENTENCE = 900

RAW = {
    "@nan": "NaN",
    "@infinity": "-Infinity",
    "@digits": "9" * 5_000,
    "@exponent": "1e400",
    "@double": "1e308",
    "@tiny": "1e-400",
    "@zero": "-0",
    "@minus zero": "-0.0",
    "@float": "1.0",
    "@deep": "[" * 3_000 + "]" * 3_000,
    "@surrogate": r'"\ud800"',
    "@nul": r'"\u0000"',
    "@repeated": '{"a": 1, "a": 2}',
}
"""Values that are written as they are, in place of a text."""

VALUES: list[Any] = [
    *(None, True, False, 0, -1, 1.5, 1e20, 2**31, 2**63, 2**64),
    *("", "x", "x" * 5_000, [], {}, [[]], {"a": 1}, [1], ["x"]),
    *("9999-12-31T23:59:59-10:00", "0001-01-01T00:00:00+10:00", "2020-01-01T00:00:00"),
    *RAW,
]


def _example(name: str) -> Any:
    with zipfile.ZipFile(EXAMPLE) as archive:
        return json.loads(archive.read(name).partition(b"\n{")[0])


def _recording() -> dict[str, Any]:
    carried = {"conditions": {"a": [1, {"b": 2}]}, "parent": {"a": 1}, "notes": "Calm."}
    return {**_example(RANKED), **carried}


def _behaviour() -> dict[str, Any]:
    played = {"recording": _recording(), "player": "Ann", "played_at": "2024-01-01T00:00:00Z"}
    return {
        "format": "tril-behaviour",
        "version": 1,
        "game": "space_invaders",
        "slug": "column-1",
        "name": "Column 1",
        "description": "",
        "target": [[0, 0]],
        "ordered": False,
        "recordings": [
            {"number": 1, **played, "parent": None},
            {"number": 2, **played, "parent": {"number": 1, "frame": 3}},
        ],
        "rankings": [
            {
                "revision": 1,
                "tiers": [[1], [2]],
                "change": "edit",
                "player": None,
                "saved_at": "2024-01-01T00:00:00Z",
                "undo_to": 0,
                "redo_to": None,
            }
        ],
    }


def _parse_recordings(text: str) -> None:
    for line in read_lines(text):
        if line.refusal is not None:
            raise Invalid(line.refusal)
        parse_recording(line.content)


PARSERS: dict[str, tuple[Callable[[], Any], Callable[[str], object], int]] = {
    "recording": (_recording, _parse_recordings, 300),
    "behaviour": (_behaviour, lambda text: parse_behaviour(text.encode()), 300),
    "run": (lambda: _example(RUN_FILE), lambda text: parse_run(text.encode()), 30),
}


def _places(value: Any, place: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    yield place
    inner = value.items() if isinstance(value, dict) else ()
    for key, one in inner or (enumerate(value[:2]) if isinstance(value, list) else ()):
        yield from _places(one, (*place, key))


def _mutated(good: Any, rng: random.Random) -> tuple[str, object]:
    """Return a file that differs in one place, and how."""
    content = json.loads(json.dumps(good))
    *way, last = rng.choice([place for place in _places(content) if place])
    around = content
    for key in way:
        around = around[key]
    if isinstance(around, dict) and rng.random() < 0.1:
        del around[last]
        return json.dumps(content), (way, last)
    around[last] = value = rng.choice(VALUES)
    text = json.dumps(content)
    for name, raw in RAW.items():
        text = text.replace(json.dumps(name), raw)
    return text, (way, last, str(value)[:40])


@pytest.mark.parametrize("kind", PARSERS)
def test_a_file_that_is_wrong_in_one_place_is_refused_with_a_sentence(kind: str) -> None:
    make, parse, count = PARSERS[kind]
    good, rng = make(), random.Random(0)
    n_refused = 0
    for _ in range(count):
        text, how = _mutated(good, rng)
        began, sentence = time.process_time(), ""
        try:
            parse(text)
        except TrilError as refusal:
            n_refused += 1
            sentence = str(refusal)
        assert len(sentence) < MAX_SENTENCE, how
        assert time.process_time() - began < MAX_SECONDS, how
    assert n_refused > count / 3


@pytest.mark.parametrize(
    ("part", "name", "value"),
    [
        ("evaluation", "start_numbers", list(range(100_000))),
        ("evaluation", "start_numbers", ["x"] * 100_000),
        ("policy", "snapshot_steps", [0] * 100_000),
        ("policy", "n_steps", 10**300),
        ("policy", "n_envs", "9" * 5_000),
        ("policy", "gamma", float("nan")),
        (None, "policy", []),
        (None, "policy", "x"),
        (None, "policy", 3),
        (None, "name", ["x"]),
    ],
)
def test_a_recipe_that_is_wrong_in_one_place_is_refused_with_a_sentence(
    part: str | None, name: str, value: object
) -> None:
    recipe = FAST.to_dict()
    (recipe if part is None else recipe[part])[name] = value
    began = time.process_time()
    with pytest.raises(Invalid) as refusal:
        checked(recipe_from_dict(recipe))
    assert time.process_time() - began < MAX_SECONDS
    assert len(str(refusal.value)) < MAX_SENTENCE

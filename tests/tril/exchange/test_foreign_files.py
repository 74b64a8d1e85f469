"""Files that are not what an import takes: one sentence says what they are."""

from __future__ import annotations

import codecs
import gzip
import io
import json
import zipfile

import pytest

from testsupport.workplace import Workplace
from tril.exchange.formats.jsonl import read_lines
from tril.exchange.formats.recording_file import load_recording
from tril.exchange.recording_transfer import MAX_EXAMPLES, import_recordings
from tril.games.space_invaders import SPACE_INVADERS
from tril.play.consoles import Consoles

RECORDING = (
    '{"format": "tril-recording", "version": 1, "game": "space_invaders",'
    ' "rom_md5": "72ffbef6504b75e69ee1045af9075f66", "start": {"idle_frames": 3},'
    ' "actions": "AQ=="}'
)


def _zip() -> bytes:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w") as archive:
        archive.writestr("run.json", "{}")
    return target.getvalue()


FOREIGN = {
    "zip": (_zip(), "a zip file; a run that Tril exported is imported with `tril runs import`"),
    "gzip": (gzip.compress(RECORDING.encode()), "compressed with gzip; unpack it first"),
    "database": (b"SQLite format 3\0" + bytes(200), "an SQLite database"),
    "picture": (b"\x89PNG\r\n\x1a\n" + bytes(200), "a PNG picture"),
    "web page": (b"<!DOCTYPE html>\n<html>\n" * 500, "a web page or XML"),
    "list": (f"[{RECORDING}]".encode(), "a JSON list"),
    # The Atari Grand Challenge Dataset and Atari-HEAD.
    "agc": (
        b"db_id\nframe,reward,score,terminal,action\n" + b"0, 0, 0, False, 0\n" * 15_000,
        "a table (CSV)",
    ),
    "atari head": (
        b"frame_id,episode_id,score,duration(ms),unclipped_reward,action,gaze_positions\n"
        + b"XX_1_1,0,0,50,0,0,80.1,100.2\n" * 15_000,
        "a table (CSV)",
    ),
    "behaviour": (
        json.dumps(
            {"format": "tril-behaviour", "recordings": [{"format": "tril-recording"}] * 9000},
            indent=1,
        ).encode(),
        "a whole behaviour; import it with `tril behaviours import`",
    ),
    "run": (b'{\n "format": "tril-run",\n "version": 1\n}', "with `tril runs import`"),
    "bytes": (bytes(range(256)) * 4, "not text"),
    "text": (b"Dear Ann,\n" * 200, "not JSON"),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_one_sentence_says_what_a_foreign_file_is_and_what_is_taken(name: str) -> None:
    content, description = FOREIGN[name]
    (line,) = read_lines(content)
    assert line.refusal is not None
    assert line.refusal.startswith("The file is ")
    assert description in line.refusal
    assert "one object or one per line" in line.refusal


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"])
@pytest.mark.parametrize("n_lines", [1, 3, 400])
def test_a_file_is_read_in_whatever_unicode_it_is_written(encoding: str, n_lines: int) -> None:
    # PowerShell's > writes UTF-16.
    text = f"{RECORDING}\r\n" * n_lines
    lines = list(read_lines(text.encode(encoding)))
    assert [line.content for line in lines] == [json.loads(RECORDING)] * n_lines


def test_damaged_utf_16_is_one_refusal() -> None:
    *_, line = read_lines(codecs.BOM_UTF16_LE + RECORDING.encode("utf-16-le") + b"\0\xd8\n\0")
    assert line.refusal is not None
    assert line.refusal.startswith("The file is damaged: ")


def test_a_repeated_member_is_refused() -> None:
    twice = RECORDING.replace('"actions"', '"start": {"idle_frames": 99}, "actions"')
    (line,) = read_lines(twice)
    assert line.refusal == "The recording can't be read: the member 'start' is repeated."


def test_a_game_that_is_in_a_file_twice_is_imported_once(workplace: Workplace) -> None:
    same = RECORDING.replace('}, "actions"', ', "mode": 0}, "actions"')
    given = f"{RECORDING}\n{same}\n"
    outcome = import_recordings(workplace.database, workplace.behaviour_id, given, rank=True)
    assert len(outcome.recording_ids) == 1
    (notice,) = (one for one in outcome.notices if one.line == 2)
    assert notice.reason == "It is the same game as in line 1, so it was not imported again."
    again = import_recordings(workplace.database, workplace.behaviour_id, given)
    assert (again.recording_ids, again.already_there) == ([], outcome.recording_ids)


def test_of_many_refusals_some_are_shown_and_all_are_counted(workplace: Workplace) -> None:
    given = f"{RECORDING}\n" + '{"action": 3}\n' * 5_000
    console = SPACE_INVADERS.make_console()
    outcome = import_recordings(
        workplace.database,
        workplace.behaviour_id,
        given,
        load=lambda content: load_recording(content, Consoles(console)),
    )
    assert len(outcome.recording_ids) == 1
    assert outcome.n_refused == 5_000
    assert len(outcome.refusals) == MAX_EXAMPLES

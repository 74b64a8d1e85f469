"""Whole behaviours: out of one data folder, into another."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from testsupport.workplace import Workplace, make_workplace
from tril.errors import NameTaken
from tril.exchange.behaviour_transfer import export_behaviour, import_behaviour
from tril.exchange.formats.behaviour_file import BehaviourRefused, behaviour_schema
from tril.exchange.recording_transfer import export_recordings
from tril.games.measures import measures_from_json
from tril.recording import verify
from tril.store import answers, behaviours, borrowed, players, rankings, recordings
from tril.store.models import RecordingRow, Source, Verification
from tril.store.training import runs

SCHEMA_FILE = Path(__file__).parents[3] / "docs" / "behaviour-format.schema.json"
File = dict[str, Any]


@pytest.fixture
def origin(tmp_path: Path) -> Iterator[Workplace]:
    """Column 1 with a history: ties, an undo, a deletion, a branch, notes, two people."""
    made = make_workplace(tmp_path / "origin")
    best, second, third, fourth = made.ranked
    with made.database.writing() as session:
        owner = players.owner(session)
        players.rename(session, owner, "Ada")
        rankings.save(session, made.behaviour_id, 1, [[best, second], [third], [fourth]], owner.id)
        rankings.undo(session, made.behaviour_id, 2, owner.id)
        recordings.delete(session, [recordings.get(session, third)], owner.id)
        row = recordings.get(session, second)
        recordings.update(session, row, perfect=True, notes="Went on from the best.")
        row.parent_id, row.parent_frame = best, 60
        row.player_id = players.named(session, "Grace").id
        row.conditions = {"screen": {"width": 1920}}
    yield made
    made.database.close()


@pytest.fixture
def other(tmp_path: Path) -> Iterator[Workplace]:
    made = make_workplace(tmp_path / "other")
    yield made
    made.database.close()


def exported(workplace: Workplace, slug: str = "column-1") -> File:
    with workplace.database.reading() as session:
        content, notices = export_behaviour(session, behaviours.by_slug(session, slug))
    assert notices == []
    read: File = json.loads(json.dumps(content))
    return read


def renumbered(file: File) -> File:
    """The file with its recordings counted from 1, in their order."""
    changed = copy.deepcopy(file)
    numbers = {one["number"]: index for index, one in enumerate(changed["recordings"], start=1)}
    for one in changed["recordings"]:
        one["number"] = numbers[one["number"]]
        if one["parent"]:
            one["parent"]["number"] = numbers[one["parent"]["number"]]
    for revision in changed["rankings"]:
        revision["tiers"] = [[numbers[key] for key in tier] for tier in revision["tiers"]]
    return changed


def test_an_imported_behaviour_exports_to_the_same_file(
    origin: Workplace, other: Workplace
) -> None:
    file = exported(origin)
    assert [row["change"] for row in file["rankings"]] == ["edit", "edit", "undo", "deletion"]
    outcome = import_behaviour(other.database, json.dumps(file).encode())
    # Column 1 has recordings there, so it isn't touched.
    assert (outcome.slug, outcome.was_there) == ("column-1-2", False)
    assert (outcome.n_recordings, outcome.n_revisions, outcome.notices) == (4, 4, [])
    again = exported(other, "column-1-2")
    assert renumbered(again) == renumbered(file) | {
        "slug": "column-1-2",
        "name": "Column 1 (2)",
    }
    assert sum(one["deleted"] for one in again["recordings"]) == 1
    with other.database.reading() as session:
        assert {"Player", "Ada", "Grace"} <= set(players.names(session).values())
        assert len(recordings.listing(session, other.behaviour_id)) == 4


def test_borrowed_games_travel_as_the_behaviours_own_and_as_no_examples_of_it(
    origin: Workplace, other: Workplace
) -> None:
    best, second, _, fourth = origin.ranked
    with origin.database.writing() as session:
        recordings.get(session, best).conditions = {"demonstration": 0, "tier": 1}
        column_2 = behaviours.by_slug(session, "column-2").id
        borrowed.borrow(session, column_2, [best, second, fourth])
        rankings.save(session, column_2, 0, [[best], [second]])
        rankings.save(session, column_2, 1, [[best]])
        borrowed.give_back(session, column_2, second)
    file = exported(origin, "column-2")
    assert [one["number"] for one in file["recordings"]] == [best, second], "only ranked ones"
    assert [one["deleted"] for one in file["recordings"]] == [False, True]
    assert [revision["tiers"] for revision in file["rankings"]] == [[[best], [second]], [[best]]]
    assert {one["recording"]["notes"] for one in file["recordings"]} == {"Borrowed from Column 1."}
    slug = import_behaviour(other.database, json.dumps(file).encode(), "Again").slug
    with other.database.reading() as session:
        behaviour = behaviours.by_slug(session, slug)
        (row,) = recordings.listing(session, behaviour.id)
        assert rankings.current(session, behaviour.id).tiers == [[row.id]]
        assert (row.perfect, row.conditions) == (False, {})
        assert borrowed.listing(session, behaviour.id) == []
    assert renumbered(exported(other, slug)) == renumbered(file) | {
        "slug": "again",
        "name": "Again",
    }


def test_a_policys_ranked_game_travels_as_the_behaviours_own(
    origin: Workplace, other: Workplace
) -> None:
    best, second, *_ = origin.ranked
    run_id = origin.make_run()
    with origin.database.writing() as session:
        by_policy = []
        for key in (best, second):
            game = recordings.as_recording(recordings.get(session, key))
            row = recordings.add(
                session,
                origin.behaviour_id,
                game,
                verify(game).replay,
                Source.POLICY,
                run_id=run_id,
                conditions={"policy": "imitator", "action_selection": "sticky"},
            )
            by_policy.append(row.id)
        borrowed.borrow(session, origin.behaviour_id, by_policy)
        newest = rankings.current(session, origin.behaviour_id)
        tiers = [by_policy[:1], *newest.tiers]
        rankings.save(session, origin.behaviour_id, newest.revision, tiers)
        runs.request_cancel(session, run_id)
        runs.delete(session, run_id)
    file = exported(origin)
    travels = {one["number"]: one for one in file["recordings"]}
    assert by_policy[1] not in travels, "nobody has ranked it"
    game = travels[by_policy[0]]
    assert (game["deleted"], game["recording"]["source"]) == (False, "policy")
    assert game["recording"]["notes"] == "Borrowed from a training of Column 1."
    slug = import_behaviour(other.database, json.dumps(file).encode()).slug
    with other.database.reading() as session:
        behaviour = behaviours.by_slug(session, slug)
        first = rankings.current(session, behaviour.id).tiers[0][0]
        row = recordings.get(session, first)
        assert (row.source, row.run_id, row.behaviour_id) == (Source.POLICY, None, behaviour.id)
        assert borrowed.listing(session, behaviour.id) == []
        exported_tiers = [line.get("tier") for line in export_recordings(session, behaviour.id)]
    assert exported_tiers[0] == 1
    assert renumbered(exported(other, slug)) == renumbered(file) | {
        "slug": slug,
        "name": "Column 1 (2)",
    }


def test_exported_recordings_keep_their_tiers_beside_borrowed_ones(origin: Workplace) -> None:
    best, second, _, fourth = origin.ranked
    with origin.database.writing() as session:
        column_2 = behaviours.by_slug(session, "column-2").id
        row = recordings.get(session, fourth)
        own = recordings.add(
            session,
            column_2,
            recordings.as_recording(row),
            verify(recordings.as_recording(row)).replay,
            Source.VARIED,
        ).id
        borrowed.borrow(session, column_2, [best, second])
        rankings.save(session, column_2, 0, [[best], [own], [second]])
        (line,) = export_recordings(session, column_2)
    assert (line["tier"], line["source"]) == (2, "varied")


def test_the_undo_history_is_preserved(origin: Workplace, other: Workplace) -> None:
    slug = import_behaviour(other.database, json.dumps(exported(origin)).encode()).slug
    with other.database.writing() as session:
        behaviour = behaviours.by_slug(session, slug)
        newest = rankings.current(session, behaviour.id)
        redone = rankings.redo(session, behaviour.id, newest.revision)
        sizes = [len(tier) for tier in redone.tiers]
    assert sizes == [2, 1], "the tie is back, without the deleted recording"


def test_an_empty_built_in_behaviour_is_filled(origin: Workplace, other: Workplace) -> None:
    file = exported(origin) | {
        "slug": "column-2",
        "name": "Column 2",
        "target": [[row, 1] for row in range(6)],
    }
    content = json.dumps(file).encode()
    first = import_behaviour(other.database, content)
    assert (first.slug, first.was_there) == ("column-2", True)
    second = import_behaviour(other.database, content)
    assert (second.slug, second.was_there) == ("column-2-2", False)
    with other.database.reading() as session:
        assert behaviours.by_slug(session, "column-2-2").name == "Column 2 (2)"
    third = import_behaviour(other.database, content, name="Of a colleague")
    assert (third.slug, third.was_there) == ("of-a-colleague", False)
    with pytest.raises(NameTaken):
        import_behaviour(other.database, content, name="Of a colleague")


def test_measures_travel_with_a_behaviour(origin: Workplace, other: Workplace) -> None:
    measures = [{"kind": "counter", "counter": "shots", "at_most": 12}, {"kind": "alive"}]
    with origin.database.writing() as session:
        row = behaviours.by_slug(session, "column-1")
        behaviours.update(
            session,
            row,
            row.name,
            row.description,
            behaviours.as_behaviour(row).target,
            row.ordered,
            measures=measures_from_json(measures),
        )
    file = exported(origin)
    assert sorted(one["kind"] for one in file["measures"]) == ["alive", "counter"]
    result = import_behaviour(other.database, json.dumps(file).encode(), "Again")
    assert exported(other, result.slug)["measures"] == file["measures"]
    unknown = file | {"measures": [{"kind": "counter", "counter": "divers"}]}
    assert "no counter 'divers'" in _refused(other, json.dumps(unknown).encode())


def test_answers_to_statements_travel_with_a_behaviour(origin: Workplace, other: Workplace) -> None:
    with origin.database.writing() as session:
        ada = players.owner(session).id
        said = (["memory 28 value"], "The cannon further to the left"), (["button 0 held"], "Fire")
        for subjects, sentence in said:
            answers.give(session, origin.behaviour_id, subjects, sentence, True, ada)
        answers.give(session, origin.behaviour_id, *said[1], None, ada)
    file = exported(origin)
    assert [(one["sentence"], one["meant"], one["player"]) for one in file["answers"]] == [
        ("The cannon further to the left", True, "Ada")
    ]
    result = import_behaviour(other.database, json.dumps(file).encode(), "Again")
    assert exported(other, result.slug)["answers"] == file["answers"]
    with other.database.reading() as session:
        row = behaviours.by_slug(session, result.slug)
        assert [one.subjects for one in answers.current(session, row.id)] == [["memory 28 value"]]
    nothing = file | {"answers": [file["answers"][0] | {"subjects": []}]}
    assert "subjects" in _refused(other, json.dumps(nothing).encode())


def test_unverified_recordings_are_left_out_with_a_notice(origin: Workplace) -> None:
    best = origin.ranked[0]
    with origin.database.writing() as session:
        session.get_one(RecordingRow, best).verification = Verification.FAILED
    with origin.database.reading() as session:
        content, notices = export_behaviour(session, behaviours.by_slug(session, "column-1"))
    assert notices == [f"Recording {best} was left out because it is not verified."]
    assert best not in [one["number"] for one in content["recordings"]]
    assert best not in [key for row in content["rankings"] for tier in row["tiers"] for key in tier]
    assert all(one["parent"] is None for one in content["recordings"])
    import_behaviour(origin.database, json.dumps(content).encode())


def test_the_published_schema_is_current_and_accepts_exports(origin: Workplace) -> None:
    assert json.loads(SCHEMA_FILE.read_text()) == behaviour_schema(), (
        "Regenerate it: python -m scripts.schemas behaviour > docs/behaviour-format.schema.json"
    )
    Draft202012Validator.check_schema(behaviour_schema())
    Draft202012Validator(behaviour_schema()).validate(exported(origin))


def _refused(other: Workplace, content: bytes) -> str:
    with other.database.reading() as session:
        before = len(behaviours.listing(session)), len(players.names(session))
    with pytest.raises(BehaviourRefused) as refusal:
        import_behaviour(other.database, content)
    with other.database.reading() as session:
        after = len(behaviours.listing(session)), len(players.names(session))
    assert before == after, "nothing of it is stored"
    return str(refusal.value)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "is not JSON"),
        (b"\x89PNG\r\n", "The file is a PNG picture."),
        (b"PK\x03\x04", "tril runs import"),
        (b"[1]", "a JSON list"),
        (b'{"format": "zip"}', "got 'zip'"),
        (b'{"format":"tril-recording","version":1}\n{}', "tril recordings import"),
        (b'{"format":"tril-behaviour","version":3}', "newer version"),
        (b'{"format":"tril-behaviour","version":1}', "recordings is missing"),
        (b"[" * 100_000, "a JSON list"),
        (b'{"a":' * 100_000, "nested too deeply"),
        (b'{"format":"tril-behaviour","version":1,"version":1}', "'version' is repeated"),
        (b'{"format":"tril-behaviour","version":' + b"9" * 5000 + b"}", "too large"),
        (b'{"format":"tril-behaviour","recordings":[' + b"[]," * 2_000_000, "values"),
    ],
)
def test_foreign_files_are_refused_with_what_they_are(
    other: Workplace, content: bytes, reason: str
) -> None:
    assert reason in _refused(other, content)


def _with(path: str, value: object) -> Callable[[File], None]:
    def change(file: File) -> None:
        *way, last = (int(part) if part.isdigit() else part for part in path.split("."))
        place: Any = file
        for part in way:
            place = place[part]
        place[last] = value

    return change


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (_with("recordings.0.recording.taken", [[5, 5]]), "Recording 1 was refused"),
        (_with("recordings.0.recording.game_version", "0" * 32), "another version"),
        (_with("recordings.1.number", 1), "2 recordings have the number"),
        (_with("recordings.1.parent.number", 77), "goes on from 77, which is not in the file"),
        (_with("recordings.1.parent.number", 2), "goes on from 2, which is itself"),
        (_with("recordings.0.recording.actions", ""), "recordings.0.recording.actions"),
        (_with("recordings.0.played_at", "yesterday"), "played_at"),
        (_with("recordings.0.played_at", "2026-01-01T00:00:00"), "played_at"),
        (_with("recordings.0.secret", 1), "recordings.0.secret"),
        (_with("rankings.0.tiers", [[1], [99]]), "not in the file: 99"),
        (_with("rankings.0.tiers", [[1], [1]]), "ranks a recording twice: 1"),
        (_with("rankings.1.revision", 7), "Expected revision 2"),
        (_with("rankings.1.undo_to", 2), "undo_to of revision 2"),
        (_with("rankings.3.tiers", [[3]]), "ranks recording 3, which is deleted"),
        (_with("rankings.0.change", "magic"), "rankings.0.change"),
        (_with("target", [[6, 0]]), "target aliens in rows 0..5"),
        (_with("game", "pong"), "Recording 1 is of space_invaders, the behaviour of pong"),
        (_with("recordings.0.recording.game", "no_such"), "Recording 1 is of no_such"),
        (_with("settings", {"max_steps": 1}), "25 to 6000 steps"),
    ],
)
def test_files_that_contradict_themselves_are_refused_whole(
    origin: Workplace, other: Workplace, change: Callable[[File], None], reason: str
) -> None:
    file = renumbered(exported(origin))
    change(file)
    assert reason in _refused(other, json.dumps(file).encode())

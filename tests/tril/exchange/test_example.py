"""The finished run that ships with Tril."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from testsupport.libraries import replay_of
from trainer.archive.run_archive import check_networks
from tril.exchange.example import BEHAVIOUR_NAME, EXAMPLE, open_example
from tril.exchange.run_archive import read_archive
from tril.exchange.run_transfer import import_run, recorded
from tril.files.artifact_store import ArtifactStore
from tril.recipes import RECIPES, recipe_from_dict
from tril.store import behaviours, recordings
from tril.store.database import create_database
from tril.store.models import Source
from tril.store.schema import upgrade
from tril.store.training import evaluations, runs
from tril.store.training.verdicts import verdict_of

MAX_BYTES = 3_000_000


def test_it_is_small_and_its_networks_load() -> None:
    assert EXAMPLE.stat().st_size < MAX_BYTES
    check_networks(read_archive(EXAMPLE))


@pytest.mark.lengthy
@pytest.mark.timeout(600)
def test_its_recordings_replay_and_it_shows_what_it_was_made_to_show(tmp_path: Path) -> None:
    database = create_database(f"sqlite:///{tmp_path / 'tril.sqlite'}")
    upgrade(database)
    store = ArtifactStore(str(tmp_path / "artifacts"))
    archive = read_archive(EXAMPLE)
    # Each of its recordings is replayed; open_example trusts the file that is tested here.
    found = import_run(database, store, archive, name=BEHAVIOUR_NAME)
    assert open_example(database, store).was_there
    with database.reading() as session:
        run = runs.get(session, found.run_id)
        assert run.example
        assert recipe_from_dict(run.recipe).name in RECIPES
        verdict = verdict_of(session, run, None)
        assert verdict is not None
        assert verdict.tone == "good", verdict.sentence
        # Two neighbours at the top are ranked the wrong way round.
        assert "the best demonstration 6." in verdict.sentence
        behaviour = behaviours.get(session, found.behaviour_id)
        assert (behaviour.name, behaviour.built_in) == (BEHAVIOUR_NAME, False)
        library = recordings.listing(session, behaviour.id)
        assert {row.source for row in library} == {Source.SCRIPTED}
        games = evaluations.listing(session, run.id)
        assert len(games) == len(evaluations.POLICIES) * 3 * len(
            {game.start_number for game in games}
        )
        # What the file says of each game is what its replay yields.
        replays = {game.recording.actions: replay_of(game.recording) for game in games}
        told = recorded(archive)
        for listed in archive.run.evaluation:
            recording, played = told[listed.number]
            # Version 1 of the format did not tell the game's own score.
            assert replace(replays[recording.actions], score=played.score) == played
    database.close()

"""``tril reproduce --score`` and ``tril demo --game``: varied games, ranked by their score."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cli.main import app
from cli.score_example import score_example
from cli.workspace import Workspace
from tests.cli.test_demo import tril
from testsupport.workplace import Workplace
from tril.errors import Invalid
from tril.games import game_named
from tril.recording import verify
from tril.settings import Settings
from tril.store import behaviours, rankings, recordings
from tril.store.database import create_database
from tril.store.training import runs

CART_POLE = "gym:CartPole-v1"
"""Pays for every frame until the pole falls, so random games are short and differ."""

SMALLEST_PAPER = (
    "reward.updates=8",
    "reward.folds=0",
    "cloning.epochs=1",
    "policy.n_envs=2",
    "policy.n_steps=16",
    "policy.n_minibatches=1",
    "policy.n_epochs=1",
    "policy.snapshot_episodes=1",
    "evaluation.start_numbers=0,",
    "evaluation.further_start_numbers=7,",
)
VALUES = [argument for value in SMALLEST_PAPER for argument in ("--set", value)]


def made(workplace: Workplace, game: str, n_games: int, seed: int = 0) -> str:
    workspace = Workspace(workplace.settings, workplace.database)
    return score_example(workspace, game_named(game), n_games, seed)


def test_games_are_ranked_by_their_score_and_equal_ones_are_tied(workplace: Workplace) -> None:
    slug = made(workplace, CART_POLE, 24)
    with workplace.database.reading() as session:
        row = behaviours.by_slug(session, slug)
        assert row.game == CART_POLE
        assert row.description.startswith("24 games of random actions in ")
        tiers = rankings.current(session, row.id).tiers
        played = recordings.by_ids(session, [key for tier in tiers for key in tier])
        assert len(played) == 24
        assert {one.source for one in played.values()} == {"varied"}
        scores = [{played[key].score for key in tier} for tier in tiers]
        assert all(len(equal) == 1 for equal in scores)
        worths = [equal.pop() or 0.0 for equal in scores]
        assert worths == sorted(worths, reverse=True)
        assert len(worths) < 24  # some are tied
        best = played[tiers[0][0]]
        assert verify(recordings.as_recording(best)).replay.score == best.score


def test_the_same_seed_gives_the_same_games_once(workplace: Workplace) -> None:
    slug = made(workplace, CART_POLE, 6)
    assert made(workplace, CART_POLE, 6) == slug
    others = [made(workplace, CART_POLE, 6, seed=1), made(workplace, CART_POLE, 8)]
    with workplace.database.reading() as session:
        games = []
        for name in (slug, *others):
            row = behaviours.by_slug(session, name)
            played = recordings.listing(session, row.id)
            games.append({(json.dumps(one.start), one.actions) for one in played})
    assert [len(one) for one in games] == [6, 6, 8]
    assert not games[0] & games[1]
    assert games[0] < games[2]


def test_space_invaders_is_played_by_its_scripted_player(workplace: Workplace) -> None:
    slug = made(workplace, "space_invaders", 4)
    with workplace.database.reading() as session:
        row = behaviours.by_slug(session, slug)
        assert row.description.startswith("4 games of a scripted player with errors in Space")
        assert any(one.score for one in recordings.listing(session, row.id))


def test_a_game_in_which_random_play_scores_nothing_is_refused(workplace: Workplace) -> None:
    with pytest.raises(
        Invalid, match="all have the score 0, so that none can be ranked"
    ) as refused:
        made(workplace, "montezuma_revenge", 4)
    assert "Play Montezuma's Revenge yourself or import games" in str(refused.value)
    with workplace.database.reading() as session:
        assert {row.game for row in behaviours.listing(session)} <= {"space_invaders", "breakout"}


@pytest.mark.usefixtures("data_folder")
@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("reproduce --score pong --own-starts", "--score has demonstrations of its own"),
        ("reproduce --score pong -b column-1", "--score has demonstrations of its own"),
        ("reproduce --score pang", "There is no game 'pang' here"),
        ("reproduce --score pong --recipe fast", "fast"),
        ("demo --game pong -b column-1", "There is no scripted player of Pong"),
        ("demo --game pong --demonstrations six", "There is no scripted player of Pong"),
        ("demo --game pang", "There is no game 'pang' here"),
    ],
)
def test_what_cannot_be_is_refused(command: str, message: str) -> None:
    done = CliRunner().invoke(app, command.split())
    assert done.exit_code == 1
    assert message in " ".join(done.output.split())


@pytest.mark.lengthy
@pytest.mark.timeout(1200)
def test_the_score_of_the_imitator_is_set_beside_the_demonstrations(
    data_folder: Path, tmp_path: Path
) -> None:
    command = (
        "reproduce", "--score", CART_POLE, "--games", "8", "--seed", "3", "--steps", "64",
        "--output", str(tmp_path), *VALUES,
    )  # fmt: skip
    output = tril(*command)
    assert "demonstrations" in output
    assert "imitator greedy" in output

    (file,) = tmp_path.rglob("scores.json")
    result = json.loads(file.read_text())
    page = (file.parent / "README.md").read_text()
    assert "Sources of the demonstrations: varied." in page
    assert "alien" not in page
    assert "| imitator greedy |" in page
    database = create_database(Settings().application_url)
    with database.reading() as session:
        (run,) = runs.listing(session)
        assert (run.id, run.steps, run.training_seed) == (result["run_id"], 64, 3)
        played = recordings.listing(session, run.behaviour_id)
        scores = [row.score for row in played if row.score is not None]
        assert len(scores) == len(played) == 8
    database.close()
    assert sorted(result["demonstrations"]) == sorted(scores)
    assert result["best_demonstration"] == result["demonstrations"][0] == max(scores)
    assert result["means"]["demonstrations"]["mean"] == pytest.approx(sum(scores) / len(scores))
    for policy in ("imitator", "clone"):
        for how in ("greedy", "sampled", "sticky"):
            games = result["policies"][f"{policy} {how}"]
            # Two starts, unless a demonstration began from one.
            assert len(games) in (1, 2)
            assert min(games) >= 1

    file.unlink()
    again = CliRunner().invoke(app, command)
    assert again.exit_code == 0, again.output
    assert json.loads(file.read_text()) == result


@pytest.mark.lengthy
@pytest.mark.timeout(1200)
def test_a_demo_of_another_game_says_what_its_example_is(data_folder: Path, tmp_path: Path) -> None:
    output = tril(
        "demo",
        "--game",
        CART_POLE,
        "--steps",
        "64",
        "--output",
        str(tmp_path),
        *VALUES,
        errors=True,
    )
    assert "12 games of random actions in" in " ".join(output.split())
    assert "nobody played them" in " ".join(output.split())
    assert "imitator greedy" in output
    assert (tmp_path / "README.md").exists()

"""Every kind of recording that is accepted goes through every stage of a run."""

from __future__ import annotations

import threading
from collections.abc import Callable

import pytest

from server.clips.render import render
from server.clips.request import ClipKind
from server.play.replays.products import frames_file
from server.play.replays.strip import strip_webp
from server.play.session.rewind import Checkpoints
from testsupport.space_invaders import evaluation_start
from testsupport.workplace import TINY, Workplace
from trainer.policy.imitator import _truncated_actions
from trainer.runtime.pipeline import Pipeline
from tril.exchange import recording_transfer
from tril.games.atari.starts import AtariStart
from tril.games.base import Start
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import Ending, EndReason
from tril.play.episode import Episode
from tril.recipes import with_values
from tril.recording import Recorder, Recording, verify
from tril.store import rankings, recordings
from tril.store.models import RunStatus, Source

WAITS: Callable[[int], int] = lambda _frame: 0  # noqa: E731
SHOOTS: Callable[[int], int] = lambda frame: 1 + frame // 40 % 5  # noqa: E731


def played(start: Start, ending: Ending, frames: int, play: Callable[[int], int]) -> Recording:
    recorder = Recorder(Episode(SPACE_INVADERS.make_console(), start, ending))
    while recorder.episode.end is None and recorder.episode.frame < frames:
        recorder.advance(play(recorder.episode.frame))
    return recorder.recording()


@pytest.fixture(scope="module")
def kinds() -> dict[str, Recording]:
    """Return recordings by what is special about them; those that wait are hit."""
    start = AtariStart(4)
    lives = played(start, Ending.LIFE_COUNTER, 1200, WAITS)
    return {
        "hit": played(start, Ending.HIT, 1200, WAITS),
        "lives": lives,
        "dying": lives.until(lives.n_frames - 20),
        "whole": played(start, Ending.HIT, 1200, SHOOTS),
        "one frame": played(start, Ending.HIT, 1, SHOOTS),
        "one step and a half": played(start, Ending.LIFE_COUNTER, 6, SHOOTS),
        "difficult": played(AtariStart(9, difficulty=1), Ending.LIFE_COUNTER, 600, SHOOTS),
        "evaluation start": played(evaluation_start(0), Ending.LIFE_COUNTER, 600, SHOOTS),
    }


def test_the_kinds_end_as_they_are_meant_to(kinds: dict[str, Recording]) -> None:
    ends = {name: verify(one).replay.end for name, one in kinds.items()}
    assert (ends["hit"], ends["lives"]) == (EndReason.HIT, EndReason.LIVES)
    assert (ends["dying"], ends["one frame"]) == (None, None)


def test_a_demonstration_is_cut_where_the_training_games_would_end(
    kinds: dict[str, Recording],
) -> None:
    assert _truncated_actions(Ending.HIT, kinds["lives"]) == kinds["hit"].actions
    assert _truncated_actions(Ending.LIFE_COUNTER, kinds["lives"]) == kinds["lives"].actions
    assert _truncated_actions(Ending.LIFE_COUNTER, kinds["hit"]) == kinds["hit"].actions


def test_every_kind_is_shown_and_rewound(kinds: dict[str, Recording]) -> None:
    console = SPACE_INVADERS.make_console()
    for recording in kinds.values():
        assert frames_file(recording, console)
        assert strip_webp(recording, console)
        scenes = Checkpoints().scenes(recording, recording.n_frames, console)
        assert recording.n_frames in scenes
    assert render(kinds["dying"], ClipKind.GIF)


@pytest.mark.parametrize(("ending", "method"), [("hit", "ppo"), ("life_counter", "gail")])
def test_every_kind_is_learned_from(
    workplace: Workplace, kinds: dict[str, Recording], ending: str, method: str
) -> None:
    with workplace.database.writing() as session:
        tiers = []
        for recording in kinds.values():
            verified = verify(recording)
            row = recordings.add(
                session,
                workplace.behaviour_id,
                verified.recording,
                verified.replay,
                Source.PERSON,
                perfect=True,
            )
            tiers.append([row.id])
        tiers += [[number] for number in workplace.ranked]
        rankings.save(session, workplace.behaviour_id, 1, tiers)
        exported = recording_transfer.export_recordings(session, workplace.behaviour_id)
        assert sum("life_counter" in str(one) for one in exported) == 5
    values = {
        "ending": ending,
        "method": method,
        "policy.demonstration_share": 1.0,
        "policy.best_share": 1.0,
        "reward.folds": 2,
        "reward.fold_updates": 2,
    }
    run_id = workplace.make_run(with_values(TINY, values), steps=128)
    pipeline = Pipeline(workplace.database, workplace.settings, "worker-0", threading.Event())
    assert pipeline.train(run_id, pipeline.run_stage) == RunStatus.DONE, workplace.run(run_id)

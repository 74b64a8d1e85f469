"""DAgger: the expert's labels, the mixture that plays, and the training as a whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.trainer.samples import (
    STEPS,
    FinishedTraining,
    RecordingProgress,
    random_model,
    same,
    tiny_recipe,
    weights,
)
from testsupport.space_invaders import idle_frames
from trainer.nn.checkpoints import CheckpointDamaged
from trainer.policy import dagger
from trainer.policy.cloning import train_clone
from trainer.policy.dagger import LabelledGame, play_labelled, train_by_dagger
from trainer.policy.imitation import ImitationTask, evaluate_snapshot
from trainer.policy.networks import Policy, load_policy, new_policy
from trainer.policy.reward_shaping import RewardShaping
from trainer.progress import NullProgress, RunCancelled
from tril.demonstrators import EXPERT_STYLE, Expert
from tril.demonstrators.space_invaders.player import Planner
from tril.errors import Invalid
from tril.games.atari.starts import TRAINING_IDLE_FRAMES
from tril.games.base import Console
from tril.games.behaviours import Behaviour
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.memory import FRAMES_PER_STEP
from tril.play.agent import AgentGame
from tril.play.episode import Episode
from tril.recipes import CloningRecipe, DaggerRecipe
from tril.recording import Recording, step_actions, trajectory

COLUMN_2 = BUILT_IN[1]


class Firing:
    """A policy that fires all the time, which hits what it should not."""

    def probabilities(self, observations: np.ndarray) -> np.ndarray:
        chances = np.zeros((len(observations), 6), np.float32)
        chances[:, 1] = 1.0
        return chances


class Erratic:
    """A policy that goes its own way."""

    def __init__(self) -> None:
        self._rng = np.random.default_rng(2)

    def probabilities(self, observations: np.ndarray) -> np.ndarray:
        return self._rng.dirichlet(np.full(6, 0.1), len(observations)).astype(np.float32)


@pytest.fixture(scope="module")
def played() -> Callable[..., LabelledGame]:
    game, expert = (
        AgentGame(SPACE_INVADERS.make_console()),
        Expert(COLUMN_2, SPACE_INVADERS.make_console()),
    )

    def play(policy: object, expert_share: float, seed: int = 3) -> LabelledGame:
        rng = np.random.default_rng(seed)
        return play_labelled(game, expert, policy, expert_share, rng, lambda: None)  # type: ignore[arg-type]

    return play


def test_the_labels_are_what_the_demonstrator_does_from_each_state(
    played: Callable[..., LabelledGame],
) -> None:
    one = played(Erratic(), 0.0)
    labels, done = one.trajectory.actions.tolist(), step_actions(one.executed, 4).tolist()
    assert len(set(labels)) > 2
    # Wherever the label was not what was done, the expert was taken somewhere new, and plans for
    # the targets that are left as the demonstrator would.
    console = SPACE_INVADERS.make_console()
    episode = Episode(console, one.start)
    checked = 0
    for step, label in enumerate(labels):
        if step and labels[step - 1] != done[step - 1]:
            hit = [h.cell for h in episode.taken]
            assert COLUMN_2.target is not None
            wanted = [*hit, *(cell for cell in COLUMN_2.target if cell not in hit)]
            state = episode.save()
            said = {
                Planner(episode, wanted, EXPERT_STYLE, np.random.default_rng(n)).next_actions()[0]
                for n in range(4)
            }
            assert episode.save() == state
            # Which of two equally good ways it dodges is drawn.
            assert label in said
            checked += 1
        for frame in range(step * FRAMES_PER_STEP, (step + 1) * FRAMES_PER_STEP):
            if frame < len(one.executed):
                episode.advance(one.executed[frame])
    assert checked > 10


def test_the_expert_alone_shows_the_behaviour_and_agrees_with_itself(
    played: Callable[..., LabelledGame],
) -> None:
    one = played(None, 1.0)
    assert [hit.cell for hit in one.trajectory.taken] == list(COLUMN_2.target or ())
    assert one.trajectory.end == EndReason.STEPS
    assert one.agreed is None
    np.testing.assert_array_equal(step_actions(one.executed, 4), one.trajectory.actions)
    assert idle_frames(one.start) in TRAINING_IDLE_FRAMES


def test_the_share_of_the_experts_steps_is_what_was_asked_for(
    played: Callable[..., LabelledGame],
) -> None:
    half = played(Firing(), 0.5)
    done, labels = step_actions(half.executed, 4), half.trajectory.actions
    differs = labels != 1
    assert 0.3 < (done[differs] == labels[differs]).mean() < 0.7
    assert half.agreed == pytest.approx((labels == 1).mean())


def test_a_games_observations_come_back_from_its_actions(
    played: Callable[..., LabelledGame],
) -> None:
    one = played(Firing(), 0.2)
    again = trajectory(Recording(SPACE_INVADERS, one.start, one.executed))
    np.testing.assert_array_equal(again.observations, one.trajectory.observations)
    assert (again.taken, again.end) == (one.trajectory.taken, one.trajectory.end)


@pytest.fixture(scope="module")
def task() -> ImitationTask:
    recipe = replace(
        tiny_recipe(warm_start=False),
        method="dagger",
        cloning=CloningRecipe(network="small", epochs=1),
        dagger=DaggerRecipe(steps_per_iteration=30, expert_decay=0.0),
    )
    return ImitationTask(
        game=SPACE_INVADERS,
        model=random_model(),
        recordings=[],
        tiers=[],
        recipe=recipe,
        steps=STEPS,
        training_seed=5,
        behaviour=COLUMN_2,
    )


@pytest.fixture(scope="module")
def short_games(task: ImitationTask) -> object:
    """Games of 50 steps, so that a training of a few iterations takes seconds."""
    with pytest.MonkeyPatch.context() as patch:
        whole = AgentGame.__init__

        def shorter(self: AgentGame, console: Console, max_frames: int = 200) -> None:
            whole(self, console, max_frames=max_frames)

        patch.setattr(dagger, "AgentGame", type("Short", (AgentGame,), {"__init__": shorter}))
        yield None


@pytest.fixture(scope="module")
def finished(
    task: ImitationTask, short_games: object, tmp_path_factory: pytest.TempPathFactory
) -> FinishedTraining:
    return FinishedTraining(train_by_dagger, task, tmp_path_factory.mktemp("dagger") / "whole")


def test_every_iteration_is_judged_and_the_best_policy_is_saved(
    task: ImitationTask, finished: FinishedTraining
) -> None:
    snapshots = finished.result.snapshots
    assert len(snapshots) >= 3
    assert snapshots[-1].steps >= STEPS
    assert all(0 < b.steps - a.steps <= 50 for a, b in pairwise(snapshots))
    best = max(snapshots, key=lambda snapshot: (snapshot.predicted_return, snapshot.steps))
    assert finished.result.best_steps == best.steps
    shaping = RewardShaping.of(task.model, task.recipe.policy)
    found, _ = evaluate_snapshot(
        SPACE_INVADERS, load_policy(finished.path), shaping, task.recipe, lambda: None
    )
    assert found == pytest.approx(best.predicted_return, rel=1e-3, abs=1e-2)


def test_every_iteration_has_a_point_on_the_curves(finished: FinishedTraining) -> None:
    points = finished.progress.points
    steps = [min(snapshot.steps, STEPS) for snapshot in finished.result.snapshots]
    assert [done for done, _ in points] == steps
    assert finished.progress.done[0] == 0
    shares = [values["expert_share"] for _, values in points]
    assert shares[:2] == [1.0, 0.0]
    assert "agreement" not in points[0][1]
    always = {"hits", "strays", "episode_steps", "death_rate", "predicted_return", "accuracy"}
    assert all(always | {"agreement"} <= set(values) for _, values in points[1:])


@pytest.mark.parametrize("stop_at_step", [20, 115])
@pytest.mark.usefixtures("short_games")
def test_an_interrupted_training_ends_with_the_same_weights(
    finished: FinishedTraining, tmp_path: Path, stop_at_step: int
) -> None:
    done = finished.progress.done
    cancel_at = next(i for i, steps in enumerate(done, 1) if steps >= stop_at_step)
    finished.check_interrupted(tmp_path, cancel_at)


def test_a_training_killed_while_it_learned_learns_again(
    task: ImitationTask,
    finished: FinishedTraining,
    short_games: object,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / "imitator.zip"
    calls = []

    def killed(*arguments: object) -> None:
        calls.append(arguments)
        raise RunCancelled

    with monkeypatch.context() as patch:
        patch.setattr(dagger, "evaluate_snapshot", killed)
        with pytest.raises(RunCancelled):
            train_by_dagger(task, path, tmp_path, RecordingProgress())
    assert len(calls) == 1
    assert train_by_dagger(task, path, tmp_path, RecordingProgress()) == finished.result
    assert same(weights(path), finished.weights)


def test_only_the_best_and_the_latest_policy_are_kept(finished: FinishedTraining) -> None:
    kept = {path.name for path in finished.folder.glob("policy-*.zip")}
    wanted = {finished.result.best_steps, finished.result.snapshots[-1].steps}
    assert kept == {f"policy-{steps}.zip" for steps in wanted}


def test_a_finished_training_is_not_trained_again(
    task: ImitationTask, finished: FinishedTraining, tmp_path: Path
) -> None:
    progress = RecordingProgress()
    again = train_by_dagger(task, tmp_path / "again.zip", finished.folder, progress)
    assert again == finished.result
    assert not progress.points
    assert same(weights(tmp_path / "again.zip"), finished.weights)


def test_a_broken_checkpoint_is_named_by_its_path(task: ImitationTask, tmp_path: Path) -> None:
    checkpoint = tmp_path / "checkpoint.json"
    checkpoint.write_text("{")
    with pytest.raises(CheckpointDamaged, match="can't be read: Expecting property") as damaged:
        train_by_dagger(task, tmp_path / "a.zip", tmp_path, RecordingProgress())
    # The pipeline removes it and begins the stage anew.
    assert damaged.value.path == checkpoint


def test_what_the_demonstrator_does_not_know_is_refused_before_anything_is_played(
    task: ImitationTask, tmp_path: Path
) -> None:
    progress = RecordingProgress()
    for behaviour, reason in (
        (Behaviour("free", "Play nicely", "", "space_invaders"), "has no target aliens"),
        (None, "needs to know the behaviour"),
    ):
        other = replace(task, behaviour=behaviour)
        with pytest.raises(Invalid, match=reason):
            train_by_dagger(other, tmp_path / "a.zip", tmp_path, progress)
    assert not progress.done
    assert not list(tmp_path.iterdir())


def test_corrections_make_a_policy_agree_with_the_expert(
    played: Callable[..., LabelledGame],
) -> None:
    beginner = Policy(new_policy("small", 6, 1e-3, np.random.default_rng(0)))
    games = [played(None, 1.0, seed) for seed in range(4)] + [played(beginner, 0.3, 4)]
    learned, _ = train_clone(
        [game.trajectory for game in games],
        6,
        CloningRecipe(network="small", learning_rate=1e-3, epochs=3, validation_share=0.0),
        0,
        NullProgress(),
    )
    learned.set_training_mode(False)
    before, after = played(beginner, 1.0, 9).agreed, played(Policy(learned), 1.0, 9).agreed
    assert before is not None
    assert after is not None
    assert after > max(0.5, before)

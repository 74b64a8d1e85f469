"""The demonstrations and models of a run, loaded when a stage first needs them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, closing
from pathlib import Path
from typing import TypeVar

from trainer.policy.networks import Policy, load_policy
from trainer.progress import NullProgress, Progress
from trainer.reward.model import RewardModel
from trainer.reward.preference_dataset import (
    Facts,
    GameFacts,
    ObservedTrajectory,
    PerfectDemonstrations,
    PreferenceDataset,
)
from trainer.runtime.context import RunContext
from tril.analysis.outcome import RunSnapshot
from tril.errors import Invalid
from tril.games.base import Console
from tril.recording import Recording, RecordingRefused, Trajectory, trajectory
from tril.store import recordings, thing_names
from tril.store.training import artifacts
from tril.store.training.artifacts import ArtifactDamaged
from tril.vocabulary.answers import Answer
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.making import varied_games, vocabulary_of
from tril.vocabulary.trace import trace

_Network = TypeVar("_Network")

REWARD_MODEL = "reward-model.safetensors"
NETWORK = "application/octet-stream"

N_VARIED = 16
"""Games of varied play from which a network learns to see the facts of a statement."""


class RunData:
    """The demonstrations and models of one lease of a run.

    What an earlier stage made is kept in memory for as long as the lease lasts, and loaded or
    derived again under the next one.

    Args:
        context: The run.
    """

    def __init__(self, context: RunContext) -> None:
        self.context = context
        self._trajectories: dict[int, Trajectory] = {}
        self._recordings: dict[int, Recording] = {}
        self._reward_model: RewardModel | None = None
        self._words: Vocabulary | None = None
        self._facts: dict[int, Facts] = {}
        self._varied: list[ObservedTrajectory] = []

    @property
    def snapshot(self) -> RunSnapshot:
        """The frozen ranking; of an example only once its demonstrations exist."""
        assert self.context.run.snapshot is not None
        return self.context.run.snapshot

    @property
    def index_tiers(self) -> list[list[int]]:
        """The tiers as indices into ``ranked_trajectories``."""
        place = {number: index for index, number in enumerate(self.snapshot.ranked)}
        return [[place[number] for number in tier] for tier in self.snapshot.tiers]

    @property
    def ranked_trajectories(self) -> list[Trajectory]:
        """What an agent would have seen and done in the ranked recordings, in that order."""
        return self.trajectories(self.snapshot.ranked)

    @property
    def perfect_trajectories(self) -> list[Trajectory]:
        """What an agent would have seen and done in the perfect recordings, in that order."""
        return self.trajectories(self.snapshot.perfect)

    @property
    def preference_dataset(self) -> PreferenceDataset:
        """The dataset that the reward is learned from, as the recipe says."""
        recipe = self.context.recipe.reward
        place = {number: index for index, number in enumerate(self.snapshot.ranked)}
        ranked_as = [place.get(number) for number in self.best_efforts]
        perfect = PerfectDemonstrations(self.trajectories(self.best_efforts), ranked_as)
        return PreferenceDataset.from_demonstrations(
            self.ranked_trajectories,
            self.index_tiers,
            recipe,
            perfect,
            self._game_facts() if recipe.method == "statement" else None,
        )

    @property
    def best_efforts(self) -> list[int]:
        """Ids of the perfect demonstrations that the reward is learned from.

        Best ranked games that stand in for them say nothing beside the order, as on the rank page:
        counted as best efforts they made statements worse (docs/decisions/26-statements.md).
        """
        stand_in = self.snapshot.none_marked and self.context.recipe.reward.method == "statement"
        return [] if stand_in else self.snapshot.perfect

    @property
    def words(self) -> Vocabulary:
        """The game's vocabulary, with the names that people gave to things; made on first use."""
        if self._words is None:
            words = vocabulary_of(
                self.context.settings.data,
                self.context.game,
                lambda *_: self.context.check_cancelled(),
            )
            with self.context.database.reading() as session:
                names = thing_names.current(session, self.context.game.name)
            self._words = words.with_names(names)
        return self._words

    def facts(self, ids: Sequence[int]) -> list[Facts]:
        """Return the facts of recordings' steps, float32 (n_steps, n_facts) each.

        Raises:
            Invalid: A recording is no longer in the database.
            RunCancelled: The run was cancelled.
        """
        words = self.words
        missing = {
            number: recording
            for number, recording in self.recordings(ids).items()
            if number not in self._facts
        }
        if missing:
            with closing(self.context.game.make_console()) as console:
                for number, recording in missing.items():
                    self._facts[number] = words.facts(trace(recording, console, words.scene))
                    self.context.check_cancelled()
        return [self._facts[number] for number in ids]

    def _game_facts(self) -> GameFacts:
        """Return the facts of the run's games, and of varied ones, in the game's own vocabulary."""
        game, words = self.context.game, self.words
        ranked = self.facts(self.snapshot.ranked)
        best = self.facts(self.best_efforts)
        if not self._varied:
            with closing(game.make_console()) as console:
                for recording in varied_games(game, N_VARIED):
                    observed = trajectory(recording, console)
                    facts = words.facts(trace(recording, console, words.scene))
                    self._varied.append(ObservedTrajectory(observed.observations, facts=facts))
                    self.context.check_cancelled()
        return GameFacts(
            words,
            ranked,
            best,
            self._varied,
            [Answer(frozenset(answer.subjects), answer.meant) for answer in self.snapshot.answers],
        )

    def recordings(self, ids: Sequence[int]) -> dict[int, Recording]:
        """Return recordings by id; deleted ones too, since the run was made with them."""
        missing = [number for number in ids if number not in self._recordings]
        with self.context.database.reading() as session:
            rows = recordings.by_ids(session, missing)
            self._recordings |= {
                number: recordings.as_recording(row).with_hidden_areas_of(self.context.game)
                for number, row in rows.items()
            }
        deleted = [number for number in ids if number not in self._recordings]
        if deleted:
            raise Invalid(f"Recordings {deleted} of this training are no longer in the database.")
        return {number: self._recordings[number] for number in ids}

    def trajectories(
        self, ids: Sequence[int], progress: Progress | None = None
    ) -> list[Trajectory]:
        """Replay recordings through an agent's eyes.

        Args:
            ids: Ids of the recordings.
            progress: Told after each.

        Raises:
            Invalid: A recording no longer replays to what was recorded.
        """
        progress = progress or NullProgress()
        console: Console | None = None
        recordings_by_id = self.recordings(ids)
        for count, (number, recording) in enumerate(recordings_by_id.items(), start=1):
            if number not in self._trajectories:
                console = console or recording.game.make_console()
                try:
                    self._trajectories[number] = trajectory(recording, console)
                except RecordingRefused as refusal:
                    with self.context.database.reading() as session:
                        title = recordings.get(session, number).title
                    raise Invalid(f"{title} can't be learned from: {refusal}") from refusal
                self.context.check_cancelled()
            progress.advance(count, len(recordings_by_id))
        return [self._trajectories[number] for number in ids]

    def keep_reward_model(self, model: RewardModel) -> None:
        """Put the reward model into the artifact store."""
        path = self.context.stage_folder("reward") / REWARD_MODEL
        model.save(path)
        self.context.save_artifact("reward_model", path.name, NETWORK, path.read_bytes())
        self._reward_model = model

    def keep_policy(self, kind: str, path: Path, steps: int | None = None) -> None:
        """Put the file of the "imitator" or the "clone" into the artifact store.

        Args:
            kind: Kind of the policy.
            path: File of the policy.
            steps: Training steps behind an imitator that still learns; None for one that is ready.
        """
        details = {} if steps is None else {"steps": steps}
        self.context.save_artifact(kind, path.name, NETWORK, path.read_bytes(), details)

    @property
    def reward_model(self) -> RewardModel:
        """The run's reward model, from the artifact store."""
        if self._reward_model is None:
            self._reward_model = self._load("reward_model", RewardModel.load)
        return self._reward_model

    def actor(self, kind: str) -> Policy:
        """Return the "imitator" or the "clone", from the artifact store."""
        return self._load(kind, load_policy)

    def _load(self, kind: str, load: Callable[[Path], _Network]) -> _Network:
        """Load a network; raises ArtifactDamaged if its file can't be read.

        That is how damage shows in files of earlier versions, which have no digest.
        """
        with self.artifact_file(kind) as path:
            try:
                return load(path)
            except Invalid as error:
                raise ArtifactDamaged(self.context.run_id, kind) from error

    def artifact_file(self, kind: str) -> AbstractContextManager[Path]:
        """Give the run's artifact of a kind as a file on this machine."""
        return self._file_of(self.context.run_id, kind)

    def start_policy_file(self) -> AbstractContextManager[Path]:
        """Give the policy that a warm start begins with: the parent's imitator, or the clone."""
        parent = self.context.run.parent_run_id
        return self.artifact_file("clone") if parent is None else self._file_of(parent, "imitator")

    def _file_of(self, run_id: str, kind: str) -> AbstractContextManager[Path]:
        return artifacts.local_file(self.context.database, self.context.artifacts, run_id, kind)

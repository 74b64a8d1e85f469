"""What policies score in their game, beside the demonstrations that were ranked by the score.

T-REX (Brown et al. 2019, table 1) compares the imitator with the best and the mean demonstration.
Learning does not see the score: it only made the ranking, and judges here.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from sqlalchemy.orm import Session

from tril.analysis.summary import Interval, interval
from tril.errors import Invalid
from tril.store import recordings
from tril.store.database import Database
from tril.store.models import RunRow, RunStatus
from tril.store.training import evaluations, runs


@dataclass(frozen=True)
class ScoreResult:
    """Scores of a run's games.

    Attributes:
        run_id: The run.
        recipe: Name of its recipe.
        steps: Steps of the imitator's training games.
        training_seed: Feeds every random choice.
        demonstrations: Scores of the ranked games, the best ranked first.
        policies: Scores from held-out evaluation starts by policy and action selection, such as
            "imitator greedy".
    """

    run_id: str
    recipe: str
    steps: int
    training_seed: int
    demonstrations: tuple[float, ...]
    policies: Mapping[str, tuple[float, ...]]

    @property
    def means(self) -> dict[str, Interval]:
        """Mean scores with their intervals: of the demonstrations, then of each policy."""
        groups = {"demonstrations": self.demonstrations} | dict(self.policies)
        return {name: interval(scores) for name, scores in groups.items() if scores}

    @property
    def best_demonstration(self) -> float:
        """The highest score that was demonstrated."""
        return max(self.demonstrations)

    def to_json(self) -> dict[str, Any]:
        """Return everything as JSON data."""
        means = {name: asdict(mean) for name, mean in self.means.items()}
        return asdict(self) | {"best_demonstration": self.best_demonstration, "means": means}


def read_scores(database: Database, run_id: str) -> ScoreResult:
    """Read the scores of a finished run's games.

    Raises:
        NotFound: No such run.
        Invalid: The run is not done.
    """
    with database.reading() as session:
        run = runs.get(session, run_id)
        if run.status != RunStatus.DONE:
            raise Invalid(f"Run {run_id} is {run.status}; only a finished one is a result.")
        return scores_of(session, run)


def scores_of(session: Session, run: RunRow) -> ScoreResult:
    """Return the scores of a run's games, as far as they were played."""
    ranked = run.snapshot.ranked if run.snapshot else []
    rows = recordings.by_ids(session, ranked)
    scores = [rows[key].score for key in ranked if key in rows]
    games = defaultdict(list)
    for row in evaluations.listing(session, run.id):
        if row.held_out and row.recording.score is not None:
            games[row.policy, row.action_selection].append(row.recording.score)
    order = [
        (policy, how) for policy in evaluations.POLICIES for how in evaluations.ACTION_SELECTIONS
    ]
    return ScoreResult(
        run.id,
        run.recipe_name,
        run.steps,
        run.training_seed,
        # Recordings of earlier versions have none.
        tuple(score for score in scores if score is not None),
        {" ".join(key): tuple(games[key]) for key in order if key in games},
    )

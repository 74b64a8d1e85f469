"""The games that the trained policies play, each one a verified recording."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from trainer.policy.evaluation import (
    EvaluatedGame,
    beginnings,
    opening_steps,
    play,
    stickiness,
)
from trainer.progress import Progress, ScaledProgress
from trainer.reward.check import final_level
from trainer.reward.preference_dataset import Facts
from trainer.reward.statements import levels_of_facts, understanding_of
from trainer.runtime.policy_games import add_game, verify_games
from trainer.runtime.run_data import RunData
from tril.analysis.outcome import ElsewhereShares, Headline, RunOutcome, UnderstoodShares
from tril.analysis.summary import Interval, interval
from tril.games.base import Console
from tril.games.behaviours import score
from tril.recipes import recipe_from_dict
from tril.store.models import EvaluationRow
from tril.store.training import evaluations, leases, runs
from tril.store.training.evaluations import (
    ACTION_SELECTIONS,
    POLICIES,
    ActionSelection,
    EvaluationKey,
)
from tril.vocabulary.moments import Seconds, seconds_of
from tril.vocabulary.whereabouts import place_columns, share_elsewhere

_GAMES_PLACED = 8
"""Games of each policy that are compared in where things are: each takes about a second."""


def evaluate(data: RunData, progress: Progress) -> RunOutcome:
    """Play the missing evaluation games of both policies, with each action selection."""
    context = data.context
    recipe = context.recipe.evaluation
    numbers = [*recipe.start_numbers, *recipe.further_start_numbers]
    with context.database.reading() as session:
        played = evaluations.played(session, context.run_id)
    console = context.game.make_console()
    rounds = [(policy, how) for policy in POLICIES for how in ACTION_SELECTIONS]
    for index, (policy, action_selection) in enumerate(rounds):
        missing = [n for n in numbers if EvaluationKey(policy, action_selection, n) not in played]
        part = ScaledProgress(progress, index / len(rounds), (index + 1) / len(rounds))
        if missing:
            games = play(
                context.game,
                data.actor(policy),
                beginnings(context.game, recipe, missing),
                action_selection,
                model=data.reward_model,
                end_rule=context.recipe.ending,
                sampling_seed=context.run.training_seed,
                n_processes=min(len(missing), context.threads),
                progress=part,
            )
            keep_games(data, policy, action_selection, missing, games, console)
        part.advance(1, 1)
    return RunOutcome(headline=headline(data))


def keep_games(
    data: RunData,
    policy: str,
    action_selection: ActionSelection,
    numbers: Sequence[int],
    games: Sequence[EvaluatedGame],
    console: Console,
) -> None:
    """Verify a policy's games by replaying them on a console and store them, all or none."""
    context = data.context
    training_starts = demonstrated_starts(data)
    verified = verify_games(context, games, console)
    model = data.reward_model
    sticky = stickiness(action_selection)
    with context.database.writing() as session:
        leases.owned(session, context.lease)
        for number, game, confirmed in zip(numbers, games, verified, strict=True):
            row = add_game(session, context, confirmed, policy, action_selection, sticky)
            outcome = score(context.behaviour, tuple(item.cell for item in confirmed.replay.taken))
            evaluations.add(
                session,
                context.run_id,
                EvaluationKey(policy, action_selection, number),
                row.id,
                held_out=number not in training_starts,
                predicted_return=game.predicted_return,
                final_level=None
                if game.rewards is None
                else final_level(model.level(game.rewards)),
                score=outcome,
            )


def demonstrated_starts(data: RunData) -> set[int]:
    """Return the evaluation starts of the run's demonstrations and training games.

    Those of the runs that it continues are included.
    """
    with data.context.database.reading() as session:
        lineage = runs.lineage(session, data.context.run)
    seen_recordings = data.recordings(
        [key for run in lineage if run.snapshot for key in run.snapshot.recordings]
    )
    numbers = {
        recording.game.starts.evaluation_number(recording.start)
        for recording in seen_recordings.values()
    }
    shown_from = {number for number in numbers if number is not None}
    own_starts = (recipe_from_dict(run.recipe).policy.own_starts for run in lineage)
    return shown_from.union(*own_starts)


def headline(data: RunData) -> Headline:
    """Return the run's figures for the lists."""
    context = data.context
    assert context.run.outcome.check is not None
    with context.database.reading() as session:
        games = evaluations.listing(session, context.run_id)
    target = context.behaviour.target
    summaries = evaluations.summaries(games, None if target is None else len(target))
    is_statement = context.recipe.reward.method == "statement"
    return Headline(
        **context.run.outcome.check.figures,
        imitator=summaries.get(("imitator", "greedy")),
        clone=summaries.get(("clone", "greedy")),
        understood=understood_shares(data, games) if is_statement else None,
        elsewhere=elsewhere_shares(data, games) if is_statement else None,
    )


def understood_shares(data: RunData, games: Sequence[EvaluationRow]) -> UnderstoodShares | None:
    """Return how much of what was understood games show.

    Args:
        data: The run.
        games: Its evaluation games, loaded with their recordings.

    Returns:
        None where the best demonstrations' states are worth no more than a game that is over.
    """
    model, max_steps = data.reward_model, data.context.game.clock.max_steps
    understanding = understanding_of(data.preference_dataset)

    def levels(facts: Facts) -> npt.NDArray[np.float32]:
        return levels_of_facts(model, understanding, facts)

    best = [levels(facts[:max_steps]) for facts in data.facts(data.snapshot.perfect)]
    unit = float(np.concatenate(best).mean())
    if unit <= 0:
        return None

    def share(policy: str) -> Interval | None:
        rows = evaluations.headline_games(games, policy)
        shares = []
        for row, facts in zip(rows, data.facts([one.recording_id for one in rows]), strict=True):
            opening = _opening_steps(data, row)
            total = float(levels(facts[opening:max_steps]).sum())
            shares.append(total / unit / (max_steps - opening))
        return interval(shares) if shares else None

    def share_read() -> Interval | None:
        seen = [
            model.level(model.score(one.observations[1 : max_steps + 1]))
            for one in data.perfect_trajectories
        ]
        # As it reads the best ones, so that only a difference between games counts.
        unit_read = float(np.concatenate(seen).mean())
        if unit_read <= 0:
            return None
        shares = []
        for row in evaluations.headline_games(games, "imitator"):
            if row.predicted_return is None:
                continue
            # R is of the steps that the policy has played.
            opening = _opening_steps(data, row)
            n_steps = evaluations.figures_of(row).steps - opening
            total = model.total_level(row.predicted_return, n_steps)
            shares.append(total / unit_read / (max_steps - opening))
        return interval(shares) if shares else None

    of_best = [float(of_game.sum()) / unit / max_steps for of_game in best]
    return UnderstoodShares(
        imitator=share("imitator"),
        clone=share("clone"),
        best=interval(of_best),
        read=share_read(),
    )


def elsewhere_shares(data: RunData, games: Sequence[EvaluationRow]) -> ElsewhereShares | None:
    """Return how much of the time games have things elsewhere than the best demonstrations.

    Evaluation games are compared from the policy's first step on, with the best ones from their
    beginning, for as long as both last.

    Args:
        data: The run.
        games: Its evaluation games, loaded with their recordings.

    Returns:
        None where nothing on the game's screen has a place.
    """
    columns, clock = place_columns(data.words), data.context.game.clock
    if not columns:
        return None
    best = [seconds_of(facts, clock) for facts in data.facts(data.snapshot.perfect)]

    def away(game: Seconds, others: Sequence[Seconds]) -> float:
        return float(np.mean([share_elsewhere(game, other, columns) for other in others]))

    def away_from_best(policy: str) -> Interval | None:
        rows = evaluations.headline_games(games, policy)[:_GAMES_PLACED]
        shares = []
        for row, facts in zip(rows, data.facts([one.recording_id for one in rows]), strict=True):
            played = facts[_opening_steps(data, row) :]
            shares.append(away(seconds_of(played, clock), best))
        return interval(shares) if shares else None

    among_best = [
        away(game, [*best[:index], *best[index + 1 :]])
        for index, game in enumerate(best)
        if len(best) > 1
    ]
    return ElsewhereShares(
        imitator=away_from_best("imitator"),
        clone=away_from_best("clone"),
        best=interval(among_best) if among_best else None,
    )


def _opening_steps(data: RunData, row: EvaluationRow) -> int:
    """Return the steps of an evaluation game that were played before the policy's first."""
    context = data.context
    (beginning,) = beginnings(context.game, context.recipe.evaluation, [row.start_number])
    (recording,) = data.recordings([row.recording_id]).values()
    return opening_steps(recording, beginning)

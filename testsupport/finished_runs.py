"""A finished run with everything that belongs to one, written instead of trained."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from testsupport.libraries import replay_of
from testsupport.watching import finished_run
from testsupport.workplace import Workplace
from trainer.reporting.figures import attention_picture, frame_picture
from trainer.reward.model import RewardModel, new_network
from tril.analysis.outcome import (
    AttentionDetails,
    AttentionState,
    CheckOutcome,
    Faithfulness,
    Headline,
    ImitatorOutcome,
    MeasuredOrder,
    RewardPercentiles,
    RewardState,
    RunOutcome,
)
from tril.analysis.summary import PolicySummary
from tril.exchange.run_archive import PICTURES, picture_name
from tril.files.artifact_store import ArtifactStore
from tril.games.behaviours import score
from tril.stages import stages_of
from tril.store import behaviours, recordings
from tril.store.models import EvaluationRow, Source
from tril.store.training import artifacts, evaluations, metrics, runs
from tril.store.training.evaluations import ACTION_SELECTIONS, POLICIES, EvaluationKey

CHECK = {"tau": 1.0, "pair_accuracy": 0.9, "held_out_accuracy": None}


def make_finished_run(workplace: Workplace) -> str:
    """Make a run of a data folder's behaviour, done, with untrained networks; return its id."""
    network = new_network(np.random.default_rng(0))
    model = RewardModel(network, 0.5, 2.0, zero=-1.0, one=2.0)
    run_id = finished_run(workplace, model=model)
    _keep_attention(workplace, run_id)
    _keep_games(workplace, run_id)
    with workplace.database.writing() as session:
        for step in (128, 256):
            metrics.add(session, run_id, "imitator", step, {"hits": step / 100, "strays": 0.5})
        row = runs.get(session, run_id)
        row.outcome = _outcome(workplace, evaluations.listing(session, run_id))
        row.versions = {"python": "3.11", "torch": "2"}
        row.finished_stages = {str(stage): 1.5 for stage in stages_of(example=False)}
    return run_id


def _keep_attention(workplace: Workplace, run_id: str) -> None:
    store = ArtifactStore(workplace.settings.artifact_root)
    seen = np.random.default_rng(0).random((84, 84)).astype(np.float32)
    pictures = {
        "attention_map": attention_picture(seen, "perceptual"),
        "attention_red_blue": attention_picture(seen, "red-blue"),
        "attention_frame": frame_picture(np.zeros((210, 160, 3), np.uint8)),
    }
    first = workplace.ranked[0]
    percentiles = RewardPercentiles(
        states=[RewardState(reward=p / 100, recording_id=first, step=p) for p in range(101)]
    )
    faithfulness = Faithfulness(
        map=MeasuredOrder(deletion=0.81, insertion=0.22, hidden_fifth=0.8),
        random=MeasuredOrder(deletion=0.45, insertion=0.47, hidden_fifth=0.12),
    )
    with workplace.database.writing() as session:
        for state in AttentionState:
            details = AttentionDetails(
                state=state, reward=0.25, recording_id=first, step=7, faithfulness=faithfulness
            )
            for kind in PICTURES:
                name = picture_name(state, kind)
                size = store.put(artifacts.path_of(run_id, name), pictures[kind])
                values = details.model_dump(mode="json")
                artifacts.save(session, run_id, kind, name, "image/png", size, values)
        content = percentiles.model_dump_json().encode()
        name = "reward-percentiles.json"
        store.put(artifacts.path_of(run_id, name), content)
        values = percentiles.model_dump(mode="json")
        artifacts.save(
            session, run_id, "reward_percentiles", name, "application/json", len(content), values
        )


def _keep_games(workplace: Workplace, run_id: str) -> None:
    """Store the demonstrations as evaluation games: each policy has one of each kind."""
    with workplace.database.writing() as session:
        taught = behaviours.as_behaviour(behaviours.get(session, workplace.behaviour_id))
        played = recordings.by_ids(session, workplace.ranked)
        for policy in POLICIES:
            for number, how in zip(workplace.ranked, ACTION_SELECTIONS, strict=False):
                shown = played[number]
                row = recordings.add(
                    session,
                    workplace.behaviour_id,
                    recordings.as_recording(shown),
                    replay_of(shown),
                    Source.POLICY,
                    run_id=run_id,
                    conditions={"policy": policy, "action_selection": how},
                )
                cells = tuple((hit.row, hit.column) for hit in recordings.taken_of(shown))
                key = EvaluationKey(policy, how, 0)
                found = score(taught, cells)
                level = number / 10
                evaluations.add(session, run_id, key, row.id, True, float(number), level, found)


def add_greedy_games(workplace: Workplace, run_id: str, starts: Sequence[int]) -> None:
    """Store demonstrations as both policies' greedy games from further held-out starts."""
    with workplace.database.writing() as session:
        played = recordings.by_ids(session, workplace.ranked)
        for start in starts:
            for place, policy in enumerate(POLICIES):
                shown = played[workplace.ranked[(start + place) % len(workplace.ranked)]]
                row = recordings.add(
                    session,
                    workplace.behaviour_id,
                    recordings.as_recording(shown),
                    replay_of(shown),
                    Source.POLICY,
                    run_id=run_id,
                )
                key = EvaluationKey(policy, "greedy", start)
                evaluations.add(session, run_id, key, row.id, True, None, None, None)


def _outcome(workplace: Workplace, games: list[EvaluationRow]) -> RunOutcome:
    found = evaluations.summaries(games, 6)

    def summary(policy: str) -> PolicySummary:
        return found[policy, "greedy"]

    levels = dict(zip(workplace.ranked, (4.0, 3.0, 2.0, 1.0), strict=True))
    headline = {name: asdict(summary(name)) for name in POLICIES}
    return RunOutcome(
        check=CheckOutcome.model_validate(
            CHECK
            | {
                "passed": True,
                "advice": "",
                "confused": [],
                "predicted_returns": levels,
                "final_levels": levels,
            }
        ),
        imitator=ImitatorOutcome(best_steps=256, precision="float32", device="cpu"),
        headline=Headline.model_validate(CHECK | headline),
    )

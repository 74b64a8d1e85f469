"""The model of ``run.json`` in a run's archive: all of a run but its recordings and networks.

Recordings are numbered as they were where the run was trained; the archive's files of recordings
hold them in the order in which they are listed here.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Annotated, Any, Final, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from tril.analysis.blind import MAX_PAIRS, MAX_ROUND, BlindAnswer
from tril.analysis.outcome import AttentionDetails, RewardState, RunOutcome
from tril.analysis.summary import Policy
from tril.errors import Invalid
from tril.exchange.formats.json_text import decode_json, parse_json
from tril.exchange.formats.recording_object import (
    MAX_ITEMS,
    CellArray,
    GameName,
    MeasuresObject,
    Moment,
    SettingsObject,
    describe_errors,
    normalise_json,
    truncated,
)
from tril.games.base import MAX_EVALUATION_STARTS, MAX_FRAMES
from tril.recording import RecordingRefused
from tril.stages import Stage
from tril.store.training.evaluations import ActionSelection
from tril.store.training.runs import MAX_NAME_LENGTH, MAX_NOTES_LENGTH
from tril.text import Line

RUN_FORMAT: Final = "tril-run"
RUN_VERSION: Final = 2

MAX_DEMONSTRATIONS = 2_000
MAX_GAMES = 2 * len(get_args(ActionSelection)) * MAX_EVALUATION_STARTS
MAX_POINTS = 20_000
MAX_BLIND_ANSWERS = 20_000

_Number = Annotated[int, Field(ge=1, le=2**31 - 1)]
_Count = Annotated[int, Field(ge=0, le=MAX_FRAMES)]
_Text = Annotated[Line, Field(max_length=200)]


class RunRefused(Invalid):
    """A file that is not a run's archive, or a hostile one."""


class _ClosedModel(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


class TaughtBehaviour(_ClosedModel):
    """What the run teaches."""

    slug: str = Field(min_length=1, max_length=80, pattern="^[a-z0-9-]+$")
    name: Line = Field(min_length=1, max_length=120)
    description: str = Field(max_length=2000)
    target: list[CellArray] | None = Field(min_length=1, max_length=MAX_ITEMS)
    ordered: bool
    settings: SettingsObject = {}
    measures: MeasuresObject = []


class PlayedGame(_ClosedModel):
    """What the exchange format does not say of a recording.

    ``taken_frames`` has the frame in which each of its items was taken. Version 1 called them
    ``hit_frames``, and counted ``shots`` alone.
    """

    number: _Number
    counters: dict[Annotated[str, Field(max_length=32)], _Count] = Field(max_length=16)
    score: float = 0.0
    taken_frames: list[_Count] = Field(max_length=MAX_ITEMS)
    played_at: Moment


class EvaluationGame(PlayedGame):
    """An evaluation game."""

    policy: Policy
    action_selection: ActionSelection
    start_number: int = Field(ge=0, lt=MAX_EVALUATION_STARTS)
    held_out: bool
    predicted_return: float | None
    final_level: float | None = None


class BlindAnswerObject(_ClosedModel):
    """What a person did in a blind comparison, see tril.store.models.BlindAnswerRow."""

    player: Annotated[Line, Field(min_length=1, max_length=80)] | None
    round: int = Field(ge=1, le=MAX_ROUND)
    pair: int = Field(ge=1, le=MAX_PAIRS)
    imitator: _Number
    other: _Number
    imitator_left: bool
    answer: BlindAnswer
    answered_at: Moment


class CurvePoint(_ClosedModel):
    """A point of a stage's curves, by name."""

    stage: Stage
    step: int = Field(ge=0, le=2**31 - 1)
    values: dict[Annotated[str, Field(max_length=64)], float] = Field(max_length=64)


class RunObject(_ClosedModel):
    """One finished run of Tril, see run-archive.md."""

    format: Literal["tril-run"]
    version: Literal[2]
    game: GameName
    tril: _Text
    id: str = Field(pattern="^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$")
    name: Line = Field(default="", max_length=MAX_NAME_LENGTH)
    notes: str = Field(default="", max_length=MAX_NOTES_LENGTH)
    behaviour: TaughtBehaviour
    recipe: dict[str, Any]
    steps: int = Field(ge=1, le=100_000_000)
    training_seed: int = Field(ge=0, le=2**31 - 1)
    go_on_anyway: bool
    example: bool
    example_kind: Line = Field(max_length=24)
    versions: dict[_Text, _Text] = Field(max_length=64)
    finished_stages: dict[Stage, Annotated[float, Field(ge=0)]]
    created_at: Moment
    started_at: Moment | None
    finished_at: Moment
    tiers: list[Annotated[list[_Number], Field(min_length=1)]] = Field(min_length=2)
    perfect: list[_Number] = Field(min_length=1)
    outcome: RunOutcome
    curves: list[CurvePoint] = Field(max_length=MAX_POINTS)
    percentiles: list[RewardState] = Field(max_length=101)
    attention: list[AttentionDetails] = Field(max_length=4)
    ranked: list[PlayedGame] = Field(max_length=MAX_DEMONSTRATIONS)
    unranked: list[PlayedGame] = Field(max_length=MAX_DEMONSTRATIONS)
    evaluation: list[EvaluationGame] = Field(max_length=MAX_GAMES)
    blind: list[BlindAnswerObject] = Field(default=[], max_length=MAX_BLIND_ANSWERS)


def parse_run(content: bytes) -> RunObject:
    """Parse and validate ``run.json``.

    Raises:
        RunRefused: It is invalid, contradicts itself, or is of a newer version.
    """
    try:
        text = decode_json(content)
        data = parse_json(text)
        if not isinstance(data, dict) or data.get("format") != RUN_FORMAT:
            raise RunRefused("This is not a run that Tril exported.")
        if isinstance(version := data.get("version"), int) and version > RUN_VERSION:
            raise RunRefused("The run was exported by a newer version of Tril. Update Tril.")
        data = _upgraded(data)
        # In the mode of JSON, in which times and tuples may be texts and lists.
        run = RunObject.model_validate_json(json.dumps(normalise_json(data, keep_numbers=True)))
    except ValidationError as error:
        raise RunRefused(" ".join(describe_errors(error))) from None
    except (RecordingRefused, ValueError, RecursionError) as error:
        raise RunRefused(f"run.json can't be read: {truncated(str(error), 200)}") from None
    if contradictions := list(_contradictions(run)):
        raise RunRefused(" ".join(contradictions[:4]))
    return run


def _upgraded(data: dict[str, Any]) -> dict[str, Any]:
    """Rename the members of version 1, which had one game."""
    if data.get("version") != 1:
        return data
    upgraded = dict(data)
    for name in ("ranked", "unranked", "evaluation"):
        games = data.get(name)
        if isinstance(games, list):
            upgraded[name] = [_upgraded_game(game) for game in games]
    return upgraded | {"version": RUN_VERSION}


def _upgraded_game(game: object) -> object:
    if not isinstance(game, dict) or "shots" not in game:
        return game
    upgraded = {key: value for key, value in game.items() if key not in ("shots", "hit_frames")}
    return upgraded | {"counters": {"shots": game["shots"]}, "taken_frames": game.get("hit_frames")}


def _contradictions(run: RunObject) -> Iterator[str]:
    ranked = [game.number for game in run.ranked]
    demonstrations = {*ranked, *(game.number for game in run.unranked)}
    all_numbers = [game.number for game in (*run.ranked, *run.unranked, *run.evaluation)]
    if twice := _repeated(all_numbers):
        yield f"Several recordings have the number {twice[0]}."
    if sorted(number for tier in run.tiers for number in tier) != sorted(ranked):
        yield "The tiers are not of the ranked recordings."
    if _repeated(run.perfect) or not set(run.perfect) <= demonstrations:
        yield "The perfect recordings are not among the demonstrations."
    if not {game.number for game in run.unranked} <= set(run.perfect):
        yield "A demonstration is neither ranked nor perfect."
    for field, numbers in _references(run):
        if not set(numbers) <= set(ranked):
            yield f"{field} names recordings that are not ranked."
    by_policy = {game.number: game.policy for game in run.evaluation}
    others = demonstrations | {n for n, policy in by_policy.items() if policy == "clone"}
    for answer in run.blind:
        if by_policy.get(answer.imitator) != "imitator" or answer.other not in others:
            yield "A blind comparison is of other games."
    check = run.outcome.check
    for pair in check.confused if check else ():
        if not {pair.better, pair.worse} <= set(range(1, len(run.tiers) + 1)):
            yield "The check confuses tiers that there are not."
    if _repeated(
        (game.policy, game.action_selection, game.start_number) for game in run.evaluation
    ):
        yield "An evaluation game is there twice."
    if _repeated((point.stage, point.step) for point in run.curves):
        yield "A point of the curves is there twice."
    if _repeated(attention_map.state for attention_map in run.attention):
        yield "An attention map is there twice."


def _references(run: RunObject) -> Iterator[tuple[str, Iterable[int]]]:
    if check := run.outcome.check:
        yield "The check", (*check.predicted_returns, *check.final_levels)
        moments = (m for told in check.statements for m in (told.shown, told.contrast))
        yield "A statement", (moment.recording_id for moment in moments if moment)
    if example := run.outcome.example:
        tiers = (*example.true_tiers, *example.given_tiers, *example.mistakes)
        yield "The example", (number for tier in tiers for number in tier)
    states = (*run.percentiles, *run.attention)
    yield "An attention map", (state.recording_id for state in states)


def _repeated(values: Iterable[Any]) -> list[Any]:
    return [value for value, times in Counter(values).items() if times > 1]

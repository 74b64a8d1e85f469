"""Messages between a page that watches and the server, see docs/protocol.md. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from server.play.wire.codec import palette_json
from server.play.wire.messages import all_hits, hits_after, overlay_layout
from server.play.wire.protocol import (
    MAX_MESSAGE_BYTES,
    AckMessage,
    BadMessage,
    HitAt,
    Message,
    OverlayLayout,
    PageMessage,
    SetSpeed,
    parse_client,
)
from tril.analysis.summary import Policy
from tril.errors import Invalid
from tril.games.base import MAX_EVALUATION_STARTS
from tril.games.behaviours import Behaviour, score
from tril.play.episode import Episode
from tril.store.training.evaluations import ACTION_SELECTIONS, POLICIES, ActionSelection

MAX_LANES = 4
"""Games that are watched side by side."""
LARGEST_DRAW = 2**31 - 1


class Actor(BaseModel):
    """Who plays a watched game: a run's policy, and how its actions are selected."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    policy: Policy
    action_selection: ActionSelection


@dataclass(frozen=True)
class WatchRequest:
    """What a page wants to watch.

    Attributes:
        run_id: The run whose policies play.
        actors: Actors of the games, one each, side by side.
        start_number: The evaluation start; None for one that is drawn.
        draw: Seeds the start and its opening if they are drawn.
        take: 0 plays the games of the run's evaluation; others draw sampled and repeated actions
            anew.
    """

    run_id: str
    actors: tuple[Actor, ...]
    start_number: int | None
    draw: int
    take: int


def parse_request(
    run_id: str, players: list[str], start: str | None, draw: str | None, take: str | None
) -> WatchRequest:
    """Parse the query of a page that wants to watch.

    Args:
        run_id: The run.
        players: "imitator.greedy" and the like, 1 to 4.
        start: The number of an evaluation start, if any.
        draw: Seeds a drawn start.
        take: See WatchRequest.

    Raises:
        Invalid: The query is malformed; says how.
    """
    if not 1 <= len(players) <= MAX_LANES:
        raise Invalid(f"Expected 1 to {MAX_LANES} players, got {len(players)}.")
    return WatchRequest(
        run_id,
        tuple(map(_actor_named, players)),
        None if start is None else _number("start", start, MAX_EVALUATION_STARTS - 1),
        _number("draw", draw or "0", LARGEST_DRAW),
        _number("take", take or "0", LARGEST_DRAW),
    )


def _actor_named(name: str) -> Actor:
    for policy in POLICIES:
        for action_selection in ACTION_SELECTIONS:
            if name == f"{policy}.{action_selection}":
                return Actor(policy=policy, action_selection=action_selection)
    raise Invalid(f"There is no player {name[:40]!r}; choose one such as 'imitator.greedy'.")


def _number(name: str, text: str, largest: int) -> int:
    if not text.isascii() or not text.isdigit() or len(text) > len(str(largest)):
        raise Invalid(f"Expected a {name} from 0 to {largest}, got {text[:40]!r}.")
    if int(text) > largest:
        raise Invalid(f"Expected a {name} from 0 to {largest}, got {text}.")
    return int(text)


CommandType = Literal["play", "pause", "step"]


class WatchCommand(PageMessage):
    """Page to server: play, pause, or play one step and pause."""

    type: CommandType


class TakeOver(PageMessage):
    """Page to server: the person goes on with the game of a lane."""

    type: Literal["take_over"]
    lane: int = Field(ge=0, lt=MAX_LANES)


Watched = Literal["reward", "policy"]
"""Whose attention a page is shown: the reward model's, or each game's policy's."""


class ShowAttention(PageMessage):
    """Page to server: show what a network looks at in the games; with None nothing any more."""

    type: Literal["attention"]
    network: Watched | None


@dataclass(frozen=True)
class LaneAck:
    """Page to server: an acknowledgement of a lane's frame."""

    lane: int
    ack: AckMessage


_TEXT = WatchCommand | SetSpeed | TakeOver | ShowAttention
WatcherMessage = _TEXT | LaneAck
_TEXTS: TypeAdapter[_TEXT] = TypeAdapter(Annotated[_TEXT, Field(discriminator="type")])


def parse_watcher(data: bytes | str, n_lanes: int) -> WatcherMessage:
    """Parse a page's message.

    Args:
        data: The message.
        n_lanes: Number of games that the page watches.

    Raises:
        BadMessage: It violates the protocol; says how.
    """
    if len(data) > MAX_MESSAGE_BYTES:
        raise BadMessage(f"A message may have {MAX_MESSAGE_BYTES} bytes, got {len(data)}.")
    if isinstance(data, bytes):
        ack = parse_client(data[1:])
        if not isinstance(ack, AckMessage) or data[0] >= n_lanes:
            raise BadMessage(f"Expected an acknowledgement of lane 0 to {n_lanes - 1}.")
        return LaneAck(data[0], ack)
    try:
        message = _TEXTS.validate_json(data)
    except ValidationError as error:
        names = ", ".join((*get_args(CommandType), "speed", "take_over", "attention"))
        raise BadMessage(f"Expected one of {names}, got {data[:80]!r}.") from error
    if isinstance(message, TakeOver) and message.lane >= n_lanes:
        raise BadMessage(f"Expected lane 0 to {n_lanes - 1}, got {message.lane}.")
    return message


class WatchHello(Message):
    """First message: how to draw the frames, and what is watched.

    ``frame`` is the one that the policies begin at, after an opening.
    """

    type: Literal["hello"] = "hello"
    game: str
    palette: list[list[int]] | None
    width: int
    height: int
    frame_rate_hz: int
    max_frames: int
    frame: int
    speed_percent: int
    overlay: OverlayLayout | None
    start: dict[str, int]
    start_number: int | None
    actors: list[Actor]


class Playing(Message):
    """The games go on."""

    type: Literal["playing"] = "playing"


class Waiting(Message):
    """The games wait for the policies' decisions; ``playing`` follows."""

    type: Literal["waiting"] = "waiting"


class WatchPaused(Message):
    """The games are paused; ``why`` is empty if the person or a single step paused them."""

    type: Literal["paused"] = "paused"
    why: str


class Decision(Message):
    """The action of a lane's next step, and the probability of each action."""

    type: Literal["decision"] = "decision"
    lane: int
    frame: int
    action: int
    probabilities: list[float]


class LaneReward(Message):
    """The level of R of a lane's state at a frame, by the run's reward model.

    0 is how demonstrations begin, 1 how the best ones end. ``deviation`` is its standard
    deviation, None if the model does not know it.
    """

    type: Literal["reward"] = "reward"
    lane: int
    frame: int
    level: float
    deviation: float | None


class LaneAttention(Message):
    """What a network looks at in a lane's state at a frame, by the gradient.

    ``shares`` are the 84x84 values of the map, bytes, 255 for ``most``, base64. ``most`` is in
    levels of R for the reward model; for a policy in the log odds of ``action``, which it would
    choose.
    """

    type: Literal["attention"] = "attention"
    lane: int
    frame: int
    most: float
    action: int | None
    shares: str


class LaneHit(HitAt):
    """An item was taken; ``targets`` and ``strays`` so far, None without a target."""

    type: Literal["hit"] = "hit"
    lane: int
    targets: int | None
    strays: int | None


class LaneEnded(Message):
    """The game of a lane is over."""

    type: Literal["ended"] = "ended"
    lane: int
    reason: str
    frame: int
    hits: list[HitAt]
    targets: int | None
    strays: int | None
    order_errors: int | None


class Finished(Message):
    """The games of all lanes are over."""

    type: Literal["finished"] = "finished"


class Taken(Message):
    """The person goes on with a lane's game, which is theirs now; the stream closes."""

    type: Literal["taken"] = "taken"
    lane: int
    game_id: str
    behaviour_id: int


class Refused(Message):
    """Nothing can be watched; ``why`` says what to do, and the stream closes."""

    type: Literal["refused"] = "refused"
    why: str


def watch_hello(
    episode: Episode, actors: list[Actor], start_number: int | None, speed_percent: int
) -> WatchHello:
    """Return the first message; ``episode`` is any of the games, which begin alike."""
    game = episode.game
    return WatchHello(
        game=game.name,
        palette=palette_json(game.screen),
        width=game.screen.width,
        height=game.screen.height,
        frame_rate_hz=game.clock.frame_rate_hz,
        max_frames=episode.max_frames,
        frame=episode.frame,
        speed_percent=speed_percent,
        overlay=overlay_layout(game),
        start=episode.start.to_json(),
        start_number=start_number,
        actors=actors,
    )


def lane_hits_after(
    lane: int, behaviour: Behaviour, episode: Episode, n_known: int
) -> list[LaneHit]:
    """Return a message for each hit after the first ``n_known``."""
    return [
        LaneHit(lane=lane, **hit.model_dump(exclude={"type"}))
        for hit in hits_after(behaviour, episode, n_known)
    ]


def lane_ended(lane: int, behaviour: Behaviour, episode: Episode) -> LaneEnded:
    """Return the last message of a lane's game, which is over."""
    result = score(behaviour, tuple(item.cell for item in episode.taken))
    return LaneEnded(
        lane=lane,
        reason=str(episode.end),
        frame=episode.frame,
        hits=all_hits(behaviour, episode),
        targets=None if result is None else result.targets,
        strays=None if result is None else result.strays,
        order_errors=None if result is None else result.order_errors,
    )

"""The tables. Times are UTC; large arrays are files in the artifact store that rows name."""

from __future__ import annotations

from datetime import UTC, datetime
from enum import StrEnum
from typing import Any, Generic, TypeVar

from pydantic import BaseModel
from sqlalchemy import (
    JSON,
    Boolean,
    DateTime,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Text,
    UniqueConstraint,
    event,
    text,
)
from sqlalchemy.orm import (
    DeclarativeBase,
    InstrumentedAttribute,
    Mapped,
    mapped_column,
    relationship,
)
from sqlalchemy.types import TypeDecorator

from tril.analysis.outcome import RunOutcome, RunSnapshot
from tril.text import TextRefused, clean_line, clean_lines, shown_line, shown_lines

Model = TypeVar("Model", bound=BaseModel)

UNNAMED = "\ufffd"
"""Name of what has one that can't be seen; earlier versions accepted such names."""


class ModelJSON(TypeDecorator[Model], Generic[Model]):
    """A Pydantic model as JSON: validated where it is read, without members that were not set."""

    impl = JSON(none_as_null=True)
    cache_ok = True

    def __init__(self, model: type[Model]) -> None:
        """Store models of this class."""
        super().__init__()
        self.model = model

    def process_bind_param(self, value: Model | None, dialect: Any) -> dict[str, Any] | None:
        """Return a model as plain data."""
        return None if value is None else value.model_dump(mode="json", exclude_unset=True)

    def process_result_value(self, value: Any, dialect: Any) -> Model | None:
        """Return stored data as a model."""
        return None if value is None else self.model.model_validate(value)


class UTCDateTime(TypeDecorator[datetime]):
    """A timezone-aware UTC time, also on databases that do not store the zone."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Any) -> datetime | None:
        """Return a time as it is stored; raises ValueError for one without a zone."""
        if value is None:
            return None
        if value.tzinfo is None:
            raise ValueError("Expected a timezone-aware time.")
        return value.astimezone(UTC)

    def process_result_value(self, value: datetime | None, dialect: Any) -> datetime | None:
        """Return a stored time in UTC."""
        if value is None:
            return None
        return value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)


class LineText(TypeDecorator[str]):
    """What people write on one line, such as a name: cleaned where it is set, see tril.text.

    What earlier versions stored is read such that it would be accepted today.

    Args:
        max_length: Most characters accepted.
        default: What is read where nothing of a stored text could be seen.
    """

    impl = String
    cache_ok = True

    def __init__(self, max_length: int, default: str = "") -> None:
        super().__init__(max_length)
        self.max_length = max_length
        self.default = default

    def clean(self, value: str) -> str:
        """Return a text as it is stored; raises TextRefused."""
        return clean_line(value, self.max_length)

    def process_result_value(self, value: str | None, dialect: Any) -> str | None:
        """Return a stored text such that it would be accepted."""
        return None if value is None else shown_line(value, self.max_length) or self.default


class LinesText(TypeDecorator[str]):
    """What people write on any number of lines, such as notes; otherwise as LineText."""

    impl = Text
    cache_ok = True

    def __init__(self, max_length: int) -> None:
        super().__init__()
        self.max_length = max_length

    def clean(self, value: str) -> str:
        """Return a text as it is stored; raises TextRefused."""
        return clean_lines(value, self.max_length)

    def process_result_value(self, value: str | None, dialect: Any) -> str | None:
        """Return a stored text such that it would be accepted."""
        return None if value is None else shown_lines(value, self.max_length)


def now() -> datetime:
    """The present moment, in UTC."""
    return datetime.now(UTC)


class Base(DeclarativeBase):
    """Base of all tables; names constraints so that migrations can refer to them."""

    metadata = MetaData(
        naming_convention={
            "ix": "ix_%(table_name)s_%(column_0_N_name)s",
            "uq": "uq_%(table_name)s_%(column_0_N_name)s",
            "ck": "ck_%(table_name)s_%(constraint_name)s",
            "fk": "fk_%(table_name)s_%(column_0_N_name)s_%(referred_table_name)s",
            "pk": "pk_%(table_name)s",
        }
    )


@event.listens_for(Base, "attribute_instrument", propagate=True)
def _clean_what_is_set(
    _class: type[Base], name: str, attribute: InstrumentedAttribute[Any]
) -> None:
    """Have a column's text cleaned when it is set, whoever sets it."""
    column = getattr(attribute.property, "columns", (None,))[0]
    if column is None or not isinstance(column.type, LineText | LinesText):
        return
    kind = column.type

    def clean(_row: Base, value: str | None, _before: object, _initiator: object) -> str | None:
        try:
            return None if value is None else kind.clean(value)
        except TextRefused as refusal:
            refusal.field = name
            raise

    event.listen(attribute, "set", clean, retval=True)


class Role(StrEnum):
    """What a person may do, see server/web/permissions.py.

    OWNER: everything. RESEARCHER: everything but who gets in. PARTICIPANT: play the behaviours of
    their memberships, and see their own games of them. WORKER: no person's, but that of a key with
    which a worker of another machine asks where the data is, and nothing else.
    """

    OWNER = "owner"
    RESEARCHER = "researcher"
    PARTICIPANT = "participant"
    WORKER = "worker"


class Source(StrEnum):
    """Who played a recording.

    VARIED: a game made for a ranking that lacks variety.
    """

    PERSON = "person"
    SCRIPTED = "scripted"
    POLICY = "policy"
    VARIED = "varied"


class RecordingState(StrEnum):
    """State of a recording.

    PLAYING: being played; UNFINISHED: its game was abandoned; FINISHED: ended, but neither kept
    nor discarded yet; KEPT: in the library.
    """

    PLAYING = "playing"
    UNFINISHED = "unfinished"
    FINISHED = "finished"
    KEPT = "kept"


class Verification(StrEnum):
    """Whether a replay of the recording gave what was recorded."""

    PENDING = "pending"
    VERIFIED = "verified"
    FAILED = "failed"


class RunStatus(StrEnum):
    """State of a run. STOPPED: it ended because the check of the ranking failed."""

    QUEUED = "queued"
    RUNNING = "running"
    CANCELLING = "cancelling"
    CANCELLED = "cancelled"
    STOPPED = "stopped"
    FAILED = "failed"
    DONE = "done"

    @property
    def is_over(self) -> bool:
        """Whether nothing more happens unless the run is resumed."""
        return self not in NOT_OVER

    @property
    def is_leased(self) -> bool:
        """Whether the run is a worker's."""
        return self in {RunStatus.RUNNING, RunStatus.CANCELLING}


NOT_OVER = frozenset({RunStatus.QUEUED, RunStatus.RUNNING, RunStatus.CANCELLING})


class PlayerRow(Base):
    """A person who plays or ranks."""

    __tablename__ = "players"

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    name: Mapped[str] = mapped_column(LineText(80, UNNAMED))
    role: Mapped[str] = mapped_column(String(16))
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)


class BehaviourRow(Base):
    """A behaviour (see tril.games.behaviours.Behaviour).

    ``target`` is a list of [row, column]; ``settings`` are those of its game and ``measures`` what
    tells how well a game shows it, as JSON.
    """

    __tablename__ = "behaviours"

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    slug: Mapped[str] = mapped_column(String(80), unique=True)
    name: Mapped[str] = mapped_column(LineText(120, UNNAMED))
    description: Mapped[str] = mapped_column(LinesText(2000), default="")
    target: Mapped[list[list[int]] | None] = mapped_column(JSON(none_as_null=True))
    ordered: Mapped[bool] = mapped_column(Boolean, default=False)
    built_in: Mapped[bool] = mapped_column(Boolean, default=False)
    game: Mapped[str] = mapped_column(String(160), server_default="space_invaders")
    settings: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict, server_default="{}")
    measures: Mapped[list[dict[str, Any]]] = mapped_column(JSON, default=list, server_default="[]")
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)
    deleted_at: Mapped[datetime | None] = mapped_column(UTCDateTime)


class RecordingRow(Base):
    """One played episode: its game, start, end rule and the action executed at every frame.

    ``taken`` is a list of [row, column, frame] in order of time; ``hashes`` one digest after every
    second; ``n_frames`` the number of actions. ``max_steps`` is the longest that it could become,
    None for the game's own length. ``measured`` are values by the keys of measures (see
    tril.store.measured). Deletion only sets ``deleted_at``. ``number`` names the recording, from 1
    on among those of its behaviour that no run made, or of its run; None until its game has ended.
    """

    __tablename__ = "recordings"
    __table_args__ = (
        Index("ix_recordings_behaviour_id_state", "behaviour_id", "state"),
        Index("ix_recordings_behaviour_id_run_id_number", "behaviour_id", "run_id", "number"),
    )

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    behaviour_id: Mapped[int] = mapped_column(ForeignKey("behaviours.id"))
    player_id: Mapped[int | None] = mapped_column(ForeignKey("players.id"))
    run_id: Mapped[str | None] = mapped_column(ForeignKey("runs.id"), index=True)
    parent_id: Mapped[int | None] = mapped_column(ForeignKey("recordings.id"))
    parent_frame: Mapped[int | None] = mapped_column(Integer)
    number: Mapped[int | None] = mapped_column(Integer)
    source: Mapped[str] = mapped_column(String(16))
    state: Mapped[str] = mapped_column(String(16))
    game: Mapped[str] = mapped_column(String(160), server_default="space_invaders")
    game_version: Mapped[str] = mapped_column(String(32))
    start: Mapped[dict[str, Any]] = mapped_column(JSON, server_default="{}")
    end_rule: Mapped[str] = mapped_column(String(16), default="hit", server_default="hit")
    max_steps: Mapped[int | None] = mapped_column(Integer)
    actions: Mapped[bytes] = mapped_column(LargeBinary, default=b"")
    n_frames: Mapped[int] = mapped_column(Integer, default=0)
    hashes: Mapped[list[str]] = mapped_column(JSON, default=list)
    taken: Mapped[list[list[int]]] = mapped_column(JSON, default=list)
    counters: Mapped[dict[str, int]] = mapped_column(JSON, default=dict, server_default="{}")
    score: Mapped[float | None] = mapped_column(Float)
    measured: Mapped[dict[str, float | None]] = mapped_column(
        JSON, default=dict, server_default="{}"
    )
    end: Mapped[str | None] = mapped_column(String(16))
    verification: Mapped[str] = mapped_column(String(16), default=Verification.PENDING)
    verification_note: Mapped[str] = mapped_column(Text, default="")
    perfect: Mapped[bool] = mapped_column(Boolean, default=False)
    notes: Mapped[str] = mapped_column(LinesText(4000), default="")
    conditions: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)
    finished_at: Mapped[datetime | None] = mapped_column(UTCDateTime)
    deleted_at: Mapped[datetime | None] = mapped_column(UTCDateTime)

    @property
    def title(self) -> str:
        """What a person reads of it: "Recording 3"."""
        return "This recording" if self.number is None else f"Recording {self.number}"


class GameRow(Base):
    """A game being played: which process and tab own it, by lease.

    ``epoch`` grows with every change of owner; a commit that carries an older epoch is refused.
    """

    __tablename__ = "games"

    id: Mapped[str] = mapped_column(String(36), primary_key=True)
    recording_id: Mapped[int] = mapped_column(ForeignKey("recordings.id"), unique=True)
    epoch: Mapped[int] = mapped_column(Integer, default=0)
    owner: Mapped[str] = mapped_column(String(80), default="")
    tab: Mapped[str] = mapped_column(String(36), default="")
    lease_expires_at: Mapped[datetime | None] = mapped_column(UTCDateTime)
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)
    ended_at: Mapped[datetime | None] = mapped_column(UTCDateTime)

    recording: Mapped[RecordingRow] = relationship(lazy="raise")


class RankingRow(Base):
    """One revision of a behaviour's ranking.

    ``tiers`` is a list of lists of recording ids, best tier first. ``undo_to`` and ``redo_to``
    name the revisions whose tiers an undo or redo from here brings back.
    """

    __tablename__ = "rankings"
    __table_args__ = (UniqueConstraint("behaviour_id", "revision"),)

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    behaviour_id: Mapped[int] = mapped_column(ForeignKey("behaviours.id"))
    player_id: Mapped[int | None] = mapped_column(ForeignKey("players.id"))
    revision: Mapped[int] = mapped_column(Integer)
    tiers: Mapped[list[list[int]]] = mapped_column(JSON)
    change: Mapped[str] = mapped_column(String(16))
    undo_to: Mapped[int | None] = mapped_column(Integer)
    redo_to: Mapped[int | None] = mapped_column(Integer)
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)


class BorrowedGameRow(Base):
    """A recording of another behaviour, or of a policy, that a behaviour's ranking may hold."""

    __tablename__ = "borrowed_games"

    behaviour_id: Mapped[int] = mapped_column(ForeignKey("behaviours.id"), primary_key=True)
    recording_id: Mapped[int] = mapped_column(
        ForeignKey("recordings.id"), primary_key=True, index=True
    )
    added_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)


class StatementAnswerRow(Base):
    """What a person said of a statement that Tril made about a ranking; rows are only ever added.

    ``subjects`` is what the statement is about (see tril.vocabulary.answers), ``sentence`` what
    they read, ``meant`` whether it is what they mean. None takes back what was said of it before.
    """

    __tablename__ = "statement_answers"

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    behaviour_id: Mapped[int] = mapped_column(ForeignKey("behaviours.id"), index=True)
    player_id: Mapped[int | None] = mapped_column(ForeignKey("players.id"))
    subjects: Mapped[list[str]] = mapped_column(JSON)
    sentence: Mapped[str] = mapped_column(LineText(400))
    meant: Mapped[bool | None] = mapped_column(Boolean)
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)


class ThingNameRow(Base):
    """A name that somebody gave to a kind of things of a game; rows are only ever added.

    ``thing`` is its key (see tril.vocabulary.names.thing_key). An empty name removes the former
    one.
    """

    __tablename__ = "thing_names"

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    game: Mapped[str] = mapped_column(String(160), index=True)
    thing: Mapped[str] = mapped_column(String(80))
    name: Mapped[str] = mapped_column(LineText(40))
    player_id: Mapped[int | None] = mapped_column(ForeignKey("players.id"))
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)


class RunDevice(StrEnum):
    """Which workers may take a run. ANY: all. GPU: those that learn on a GPU."""

    ANY = "any"
    GPU = "gpu"


class RunRow(Base):
    """One training of a behaviour. The id is also the job's id.

    ``snapshot`` is frozen when the run is made (with ``example``, once its demonstrations exist).
    ``example_kind`` names which demonstrations those are (tril.demonstrators.KINDS). ``recipe``
    is the full recipe as data. ``parent_run_id`` names the run whose imitator PPO begins with in
    place of the run's own clone. ``finished_stages`` maps each finished stage to the seconds of
    work it took. ``name`` and ``notes`` are a person's. ``device`` says which workers may take it.
    ``epoch`` grows with every lease of the run to a worker; what a worker with an older epoch
    writes is refused.
    """

    __tablename__ = "runs"

    id: Mapped[str] = mapped_column(String(36), primary_key=True)
    behaviour_id: Mapped[int] = mapped_column(ForeignKey("behaviours.id"), index=True)
    player_id: Mapped[int | None] = mapped_column(ForeignKey("players.id"))
    parent_run_id: Mapped[str | None] = mapped_column(ForeignKey("runs.id"))
    name: Mapped[str] = mapped_column(LineText(80), default="", server_default=text("''"))
    notes: Mapped[str] = mapped_column(LinesText(4000), default="", server_default=text("''"))
    example: Mapped[bool] = mapped_column(Boolean, default=False)
    example_kind: Mapped[str] = mapped_column(
        String(24), default="scripted", server_default="scripted"
    )
    recipe_name: Mapped[str] = mapped_column(String(40))
    recipe: Mapped[dict[str, Any]] = mapped_column(JSON)
    training_seed: Mapped[int] = mapped_column(Integer)
    steps: Mapped[int] = mapped_column(Integer)
    go_on_anyway: Mapped[bool] = mapped_column(Boolean, default=False)
    snapshot: Mapped[RunSnapshot | None] = mapped_column(ModelJSON(RunSnapshot))
    versions: Mapped[dict[str, str]] = mapped_column(JSON, default=dict)
    device: Mapped[str] = mapped_column(
        String(8), default=RunDevice.ANY, server_default=RunDevice.ANY
    )
    status: Mapped[str] = mapped_column(String(16), index=True)
    stage: Mapped[str] = mapped_column(String(24), default="")
    stage_done: Mapped[float] = mapped_column(Float, default=0.0)
    remaining_s: Mapped[float | None] = mapped_column(Float)
    message: Mapped[str] = mapped_column(Text, default="")
    finished_stages: Mapped[dict[str, float]] = mapped_column(JSON, default=dict)
    epoch: Mapped[int] = mapped_column(Integer, default=0)
    worker: Mapped[str] = mapped_column(String(80), default="")
    heartbeat_at: Mapped[datetime | None] = mapped_column(UTCDateTime)
    outcome: Mapped[RunOutcome] = mapped_column(ModelJSON(RunOutcome), default=RunOutcome)
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)
    started_at: Mapped[datetime | None] = mapped_column(UTCDateTime)
    finished_at: Mapped[datetime | None] = mapped_column(UTCDateTime)
    deleted_at: Mapped[datetime | None] = mapped_column(UTCDateTime)

    @property
    def is_imported(self) -> bool:
        """Whether it was trained elsewhere: it is done, and no worker here has ever had it."""
        return self.status == RunStatus.DONE and self.epoch == 0


class MetricRow(Base):
    """One point of a run's curves: ``values`` by series name at ``step`` of ``stage``.

    Ids are never reused, so that a page which asks for points after an id also gets those that
    replace the ones dropped when a run went on from its checkpoint.
    """

    __tablename__ = "metrics"
    __table_args__ = (
        UniqueConstraint("run_id", "stage", "step"),
        {"sqlite_autoincrement": True},
    )

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id"))
    stage: Mapped[str] = mapped_column(String(24))
    step: Mapped[int] = mapped_column(Integer)
    values: Mapped[dict[str, float]] = mapped_column(JSON)
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)


class EvaluationRow(Base):
    """One evaluation game of a run: policy, start and recording."""

    __tablename__ = "evaluations"
    __table_args__ = (UniqueConstraint("run_id", "policy", "start_number", "action_selection"),)

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id"))
    policy: Mapped[str] = mapped_column(String(24))
    action_selection: Mapped[str] = mapped_column(String(16))
    start_number: Mapped[int] = mapped_column(Integer)
    held_out: Mapped[bool] = mapped_column(Boolean, default=True)
    recording_id: Mapped[int] = mapped_column(ForeignKey("recordings.id"))
    predicted_return: Mapped[float | None] = mapped_column(Float)
    final_level: Mapped[float | None] = mapped_column(Float)
    targets: Mapped[int | None] = mapped_column(Integer)
    strays: Mapped[int | None] = mapped_column(Integer)
    order_errors: Mapped[int | None] = mapped_column(Integer)

    recording: Mapped[RecordingRow] = relationship(lazy="raise")


class BlindAnswerRow(Base):
    """What a person did in a blind comparison of a run's games; rows are only ever added.

    ``answer`` is a tril.analysis.blind.BlindAnswer about a pair of a person's round, both counted
    from 1. ``imitator_left`` says on which side the imitator's game was shown.
    """

    __tablename__ = "blind_answers"

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id"), index=True)
    player_id: Mapped[int | None] = mapped_column(ForeignKey("players.id"))
    round: Mapped[int] = mapped_column(Integer)
    pair: Mapped[int] = mapped_column(Integer)
    imitator_id: Mapped[int] = mapped_column(ForeignKey("recordings.id"))
    other_id: Mapped[int] = mapped_column(ForeignKey("recordings.id"))
    imitator_left: Mapped[bool] = mapped_column(Boolean)
    answer: Mapped[str] = mapped_column(String(16))
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)


class ArtifactRow(Base):
    """A file of a run in the artifact store; ``details`` describes it."""

    __tablename__ = "artifacts"
    __table_args__ = (UniqueConstraint("run_id", "name"),)

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id"))
    kind: Mapped[str] = mapped_column(String(32))
    name: Mapped[str] = mapped_column(String(120))
    path: Mapped[str] = mapped_column(String(400))
    media_type: Mapped[str] = mapped_column(String(80))
    size_bytes: Mapped[int] = mapped_column(Integer)
    sha256: Mapped[str | None] = mapped_column(String(64))
    details: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)


class ChangeRow(Base):
    """A change, written in the transaction that made it and read by event streams.

    ``topic`` is the kind of thing ("run", "recording", "ranking", "behaviour", "system"), ``key``
    its id; of "library", many recordings of the behaviour of that id changed at once.
    """

    __tablename__ = "changes"

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    topic: Mapped[str] = mapped_column(String(24))
    key: Mapped[str] = mapped_column(String(40))
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)


class ProcessRow(Base):
    """A process (server, worker, inference) and its last heartbeat, by the database's clock.

    ``machine``, ``pid`` and ``started`` identify it, see tril.store.processes.
    """

    __tablename__ = "processes"

    name: Mapped[str] = mapped_column(String(80), primary_key=True)
    kind: Mapped[str] = mapped_column(String(16))
    details: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    heartbeat_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)
    machine: Mapped[str | None] = mapped_column(String(80))
    pid: Mapped[int | None] = mapped_column(Integer)
    started: Mapped[str | None] = mapped_column(String(32))


class InvitationRow(Base):
    """A link that lets people in. Only a hash of its secret is stored.

    ``behaviour_id`` is what participants may play; researchers are invited to all behaviours.
    ``max_uses`` and ``expires_at`` are null for links of earlier versions, which have no bounds.
    """

    __tablename__ = "invitations"

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    name: Mapped[str] = mapped_column(LineText(80, UNNAMED))
    role: Mapped[str] = mapped_column(String(16))
    behaviour_id: Mapped[int | None] = mapped_column(ForeignKey("behaviours.id"))
    secret_hash: Mapped[str] = mapped_column(String(64), unique=True)
    created_by: Mapped[int | None] = mapped_column(ForeignKey("players.id"))
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)
    n_used: Mapped[int] = mapped_column(Integer, default=0)
    max_uses: Mapped[int | None] = mapped_column(Integer)
    expires_at: Mapped[datetime | None] = mapped_column(UTCDateTime)
    revoked_at: Mapped[datetime | None] = mapped_column(UTCDateTime)


class MembershipRow(Base):
    """A behaviour that a participant may play, and the invitation by which."""

    __tablename__ = "memberships"

    behaviour_id: Mapped[int] = mapped_column(ForeignKey("behaviours.id"), primary_key=True)
    player_id: Mapped[int] = mapped_column(ForeignKey("players.id"), primary_key=True, index=True)
    invitation_id: Mapped[int | None] = mapped_column(ForeignKey("invitations.id"))
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)


class CredentialKind(StrEnum):
    """What shows a credential. BROWSER: a cookie. KEY: a script or worker."""

    BROWSER = "browser"
    KEY = "key"


class CredentialRow(Base):
    """A signed-in browser, or the key of a script. Only a hash of its secret is stored.

    ``name`` is the browser's, or what the key is for. ``role`` is what a key may do, at most what
    its person may; None for a browser, which may do what its person may. ``seen_at`` is at most
    about a minute behind.
    """

    __tablename__ = "credentials"

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    kind: Mapped[str] = mapped_column(String(16))
    player_id: Mapped[int] = mapped_column(ForeignKey("players.id"), index=True)
    invitation_id: Mapped[int | None] = mapped_column(ForeignKey("invitations.id"))
    role: Mapped[str | None] = mapped_column(String(16))
    name: Mapped[str] = mapped_column(LineText(80, UNNAMED))
    secret_hash: Mapped[str] = mapped_column(String(64), unique=True)
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)
    seen_at: Mapped[datetime | None] = mapped_column(UTCDateTime)
    ended_at: Mapped[datetime | None] = mapped_column(UTCDateTime)


class SubmissionRow(Base):
    """A request that changed something and carried a key, see tril.store.submissions.

    ``content`` is a digest of the request. ``status`` is None until its response is known;
    ``response`` is None if it is not kept.
    """

    __tablename__ = "submissions"
    __table_args__ = (UniqueConstraint("player_id", "key"),)

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    player_id: Mapped[int] = mapped_column(ForeignKey("players.id"))
    key: Mapped[str] = mapped_column(String(64))
    content: Mapped[str] = mapped_column(String(64))
    status: Mapped[int | None] = mapped_column(Integer)
    response: Mapped[bytes | None] = mapped_column(LargeBinary)
    created_at: Mapped[datetime] = mapped_column(UTCDateTime, default=now, index=True)


class AuditRow(Base):
    """Something that somebody did; rows are only ever added.

    ``player_id`` is None for what a command in the terminal did, ``player_name`` is what the person
    was called then, ``subject`` is what it was done to ("recording 12"), ``details`` says more.
    """

    __tablename__ = "audit"
    __table_args__ = {"sqlite_autoincrement": True}  # noqa: RUF012

    id: Mapped[int] = mapped_column(Integer, primary_key=True)
    at: Mapped[datetime] = mapped_column(UTCDateTime, default=now)
    player_id: Mapped[int | None] = mapped_column(ForeignKey("players.id"))
    player_name: Mapped[str | None] = mapped_column(LineText(80))
    action: Mapped[str] = mapped_column(String(32))
    subject: Mapped[str] = mapped_column(String(120))
    details: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)

"""Answers requests to trained networks (see tril.inference.messages), whoever asks."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from trainer.explain.attention import attention_map
from trainer.explain.gradient import gradient_map
from trainer.explain.patches import patch_map
from trainer.explain.subject import ActionOdds, Subject
from trainer.policy.networks import Policy, load_policy
from trainer.progress import Progress
from trainer.reward.model import RewardModel
from tril.errors import Invalid
from tril.files.artifact_store import ArtifactStore
from tril.inference.messages import OBSERVATION_BYTES
from tril.play.observation import OBSERVATION_SHAPE, Observation, Observations
from tril.store.database import Database
from tril.store.training import artifacts
from tril.store.training.evaluations import POLICIES

_Network = TypeVar("_Network")

MAX_MODELS = 16
"""Networks kept in memory; the least recently used one is dropped."""


class Models:
    """Trained reward models and policies, loaded from the artifact store at the first request.

    Args:
        database: The application's database.
        store: The artifact store.
        max_kept: Networks kept in memory.
    """

    def __init__(
        self, database: Database, store: ArtifactStore, max_kept: int = MAX_MODELS
    ) -> None:
        self._database = database
        self._store = store
        self._max_kept = max_kept
        self._kept: OrderedDict[Hashable, Any] = OrderedDict()
        self._lock = threading.Lock()

    def reward_model(self, run_id: str) -> RewardModel:
        """Return a run's reward model; raises NotFound if it has none."""
        return self._get(run_id, "reward_model", RewardModel.load)

    def policy(self, run_id: str, kind: str) -> Policy:
        """Return a run's "imitator" or "clone"; raises NotFound if it has none."""
        return self._get(run_id, kind, load_policy)

    def _get(self, run_id: str, kind: str, load: Callable[[Path], _Network]) -> _Network:
        with self._database.reading() as session:
            row = artifacts.of_kind(session, run_id, kind)
        # A resumed run may replace its file.
        key = (row.id, row.created_at)
        with self._lock:
            if key not in self._kept:
                with artifacts.local(self._store, row) as path:
                    self._kept[key] = load(path)
                while len(self._kept) > self._max_kept:
                    self._kept.popitem(last=False)
            self._kept.move_to_end(key)
            network: _Network = self._kept[key]
            return network


class Answers:
    """Answers the requests of one connection.

    Args:
        models: The networks.
    """

    def __init__(self, models: Models) -> None:
        self._models = models
        self._policies: dict[tuple[str, str], Policy] = {}

    def to(
        self, header: dict[str, Any], body: bytearray, progress: Progress
    ) -> tuple[dict[str, Any], bytes]:
        """Answer a request: return the header of the response, and its values.

        Args:
            header: The request's header.
            body: The request's bytes.
            progress: Reported to by what takes long, so that it can be stopped.

        Raises:
            Invalid: The request is malformed.
            NotFound: The run has no such network.
        """
        op, run_id = header.get("op"), header.get("run_id")
        if op == "ping":
            return {}, b""
        if op not in {"judge", "scale", "attention", "act"}:
            raise Invalid(
                f"There is no operation {op!r}; choose ping, judge, scale, attention or act."
            )
        if not isinstance(run_id, str):
            raise Invalid("The request lacks 'run_id'.")
        if op == "scale":
            model = self._models.reward_model(run_id)
            return {}, np.array([model.zero, model.one], np.float32).tobytes()
        if len(body) % OBSERVATION_BYTES:
            raise Invalid(
                f"Expected whole observations of {OBSERVATION_BYTES} bytes, got {len(body)} bytes."
            )
        observations = np.frombuffer(body, np.uint8).reshape(-1, *OBSERVATION_SHAPE)
        if op == "judge":
            judged = self._models.reward_model(run_id).judge(observations)
            deviations = judged.deviations
            if deviations is None:
                deviations = np.full(len(observations), np.nan, np.float32)
            return {}, np.stack([judged.rewards, deviations]).tobytes()
        if op == "attention":
            if len(observations) != 1:
                raise Invalid(f"Expected one observation, got {len(observations)}.")
            subject = self._subject(run_id, header.get("network"), observations[0])
            values = _attention(
                subject,
                header.get("method"),
                observations[0],
                _background(header.get("background", 0)),
                progress,
            )
            action = subject.action if isinstance(subject, ActionOdds) else None
            return {"action": action}, values.tobytes()
        probabilities = self._probabilities(run_id, header.get("policies"), observations)
        return {}, probabilities.tobytes()

    def _subject(self, run_id: str, network: object, observation: Observation) -> Subject:
        if network == "reward":
            return self._models.reward_model(run_id)
        if network not in POLICIES:
            raise Invalid(f"There is no network {network!r}; choose reward, imitator or clone.")
        return ActionOdds.of_choice(self._policy(run_id, str(network)), observation)

    def _probabilities(
        self, run_id: str, policies: object, observations: Observations
    ) -> npt.NDArray[np.float32]:
        if not isinstance(policies, list) or len(policies) != len(observations):
            raise Invalid(f"Expected 'policies' to name one for each of {len(observations)}.")
        result: npt.NDArray[np.float32] | None = None
        for kind in sorted(set(map(str, policies))):
            if kind not in POLICIES:
                raise Invalid(f"There is no policy {kind!r}; choose {' or '.join(POLICIES)}.")
            indices = [index for index, name in enumerate(policies) if name == kind]
            probabilities = self._policy(run_id, kind).probabilities(observations[indices])
            if result is None:
                result = np.empty((len(observations), probabilities.shape[1]), np.float32)
            result[indices] = probabilities
        return np.empty((0, 0), np.float32) if result is None else result

    def _policy(self, run_id: str, kind: str) -> Policy:
        if (run_id, kind) not in self._policies:
            self._policies[run_id, kind] = self._models.policy(run_id, kind)
        return self._policies[run_id, kind]


def _background(gray: object) -> int:
    if not isinstance(gray, int) or not 0 <= gray <= 255:
        raise Invalid(f"Expected 'background' as a gray from 0 to 255, got {gray!r}.")
    return gray


def _attention(
    subject: Subject,
    method: object,
    observation: Observation,
    background: int,
    progress: Progress,
) -> npt.NDArray[np.float32]:
    """Return a map, float32 (84, 84)."""
    match method:
        case "gradient":
            return np.asarray(gradient_map(subject, observation, background).sum(0))
        case "occlusion":
            return np.asarray(attention_map(subject, observation, progress, background).sum(0))
        case "patches":
            return patch_map(subject, observation, progress=progress, background=background)
    raise Invalid(f"There is no method {method!r}; choose gradient, occlusion or patches.")

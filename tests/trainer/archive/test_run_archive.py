"""A finished run as one zip, which opens where there is no Tril."""

from __future__ import annotations

import csv
import io
import json
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.trainer.samples import observations
from testsupport.finished_runs import make_finished_run
from testsupport.workplace import Workplace, make_workplace
from trainer.archive.run_archive import write_archive
from trainer.archive.standalone import reward_wrapper
from trainer.policy.networks import load_policy
from trainer.reward.model import RewardModel
from trainer.reward.pretraining import pretrained_network
from tril.errors import Conflict, NotFound
from tril.exchange.formats.recording_file import load_recording
from tril.files.artifact_store import ArtifactStore
from tril.recording import Recording
from tril.store.training import artifacts

WITHOUT_TRIL = """
import sys
sys.path.insert(0, sys.argv[1])
for name in ("tril", "trainer", "server", "cli"):
    try:
        __import__(name)
    except ModuleNotFoundError:
        continue
    raise SystemExit(name + " can be imported here, so that the test shows nothing")
import numpy as np
"""

POLICY = (
    WITHOUT_TRIL
    + """
from load_policy import load_policy
observations = np.load("observations.npy")
for kind in ("imitator", "clone"):
    policy = load_policy(f"policy/{kind}.safetensors")
    np.save(f"{kind}.npy", policy.probabilities(observations))
    np.save(f"{kind}-greedy.npy", policy.greedy(observations))
    assert policy.actions[1] == "FIRE", policy.actions
assert "stable_baselines3" not in sys.modules and "gymnasium" not in sys.modules
"""
)

REWARD = (
    WITHOUT_TRIL
    + """
import gymnasium
from reward_wrapper import LearnedReward

observations = np.load("observations.npy")

class Shown(gymnasium.Env):
    observation_space = gymnasium.spaces.Box(0, 255, (4, 84, 84), np.uint8)
    action_space = gymnasium.spaces.Discrete(6)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.step_number = 0
        return observations[0], {}

    def step(self, action):
        self.step_number += 1
        last = self.step_number == len(observations) - 1
        return observations[self.step_number], 10.0, last, False, {"own": True}

env = LearnedReward(Shown(), "reward/reward-model.safetensors", own_share=0.5)
env.reset(seed=0)
rewards, ended = [], False
while not ended:
    _, reward, ended, _, info = env.step(0)
    assert info["own"] and abs(reward - 5.0 - info["learned_reward"]) < 1e-6
    rewards.append(info["learned_reward"])
np.save("rewards.npy", np.array(rewards))
try:
    LearnedReward(gymnasium.make("CartPole-v1"), "reward/reward-model.safetensors")
except ValueError as refusal:
    assert "(4, 84, 84)" in str(refusal)
else:
    raise SystemExit("an environment with other observations was accepted")
"""
)


def tiny_clip(_recording: Recording) -> bytes:
    target = io.BytesIO()
    Image.new("RGB", (2, 2)).save(target, "WEBP")
    return target.getvalue()


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Workplace, str]]:
    folder = tmp_path_factory.mktemp("archive")
    made = make_workplace(folder / "data")
    yield made, make_finished_run(made)
    made.database.close()


def store_of(workplace: Workplace) -> ArtifactStore:
    return ArtifactStore(workplace.settings.artifact_root)


@pytest.fixture(scope="module")
def unpacked(finished: tuple[Workplace, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder that a run's archive was unpacked into."""
    workplace, run_id = finished
    folder = tmp_path_factory.mktemp("unpacked")
    path = folder / "run.zip"
    write_archive(workplace.database, store_of(workplace), run_id, path, tiny_clip)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    np.save(folder / "observations.npy", observations(6))
    return folder


def run_without_tril(folder: Path, program: str) -> None:
    # -I leaves out the current folder, PYTHONPATH and the user's packages.
    done = subprocess.run(
        [sys.executable, "-I", "-c", _without_editable(program), str(folder)],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def _without_editable(program: str) -> str:
    """Drop the path and the finder by which an editable installation of Tril is found."""
    root = str(Path(__file__).resolve().parents[3])
    drop = (
        "import sys\n"
        "from pathlib import Path\n"
        "sys.path[:] = [p for p in sys.path if not (Path(p) / 'tril').is_dir()]\n"
        "sys.meta_path[:] = [f for f in sys.meta_path if 'editable' not in repr(f).lower()]\n"
        f"assert {root!r} not in sys.path\n"
    )
    return drop + program


def test_the_policies_do_the_same_where_there_is_no_tril(
    unpacked: Path, finished: tuple[Workplace, str]
) -> None:
    run_without_tril(unpacked, POLICY)
    workplace, run_id = finished
    for kind in ("imitator", "clone"):
        with artifacts.local_file(workplace.database, store_of(workplace), run_id, kind) as file:
            expected = load_policy(file).probabilities(observations(6))
        found = np.load(unpacked / f"{kind}.npy")
        np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-6)
        assert (np.load(unpacked / f"{kind}-greedy.npy") == expected.argmax(1)).all()


def test_the_wrapper_adds_the_learned_reward_where_there_is_no_tril(
    unpacked: Path, finished: tuple[Workplace, str]
) -> None:
    run_without_tril(unpacked, REWARD)
    workplace, run_id = finished
    store = store_of(workplace)
    with artifacts.local_file(workplace.database, store, run_id, "reward_model") as file:
        expected = RewardModel.load(file).score(observations(6)[1:])
    np.testing.assert_allclose(np.load(unpacked / "rewards.npy"), expected, rtol=1e-4, atol=1e-5)


def test_the_wrapper_reads_a_pretrained_reward_as_tril_does(tmp_path: Path) -> None:
    model = RewardModel(pretrained_network(np.random.default_rng(5)), 0.2, 2.0)
    model.save(tmp_path / "reward-model.safetensors")
    read = reward_wrapper.RewardModel(tmp_path / "reward-model.safetensors")
    found = read.score(observations(6))
    np.testing.assert_allclose(found, model.score(observations(6)), rtol=1e-4, atol=1e-5)


def test_the_report_is_one_page_that_loads_nothing_and_says_everything(unpacked: Path) -> None:
    page = (unpacked / "report.html").read_text()
    # Names of namespaces are no addresses that are loaded.
    loaded = re.findall(r'(?:src|href)="(?!data:|#)([^"]*)"', page)
    assert loaded == []
    assert "<script" not in page
    assert page.count("<svg") >= 4
    assert "targets" in page.partition('class="verdict')[2][:400]
    assert "changes R by 80% of its range, hiding as many random ones by 12%" in page
    assert page.count("data:image/webp;base64,") == 2
    assert "tril train column-1 --recipe tiny --steps 256" in page
    for said in ("policy.learning_rate", "Kendall&#39;s tau", "python", "predicted return"):
        assert said in page or said.replace("&#39;", "'") in page


def test_the_tables_hold_every_game_and_point(unpacked: Path) -> None:
    games = list(csv.DictReader((unpacked / "evaluation.csv").read_text().splitlines()))
    assert len(games) == 6
    assert {game["policy"] for game in games} == {"imitator", "clone"}
    lines = (unpacked / "recordings/evaluation.jsonl").read_text().splitlines()
    assert [int(game["recording"]) for game in games] == list(range(1, len(lines) + 1))
    points = list(csv.DictReader((unpacked / "curves.csv").read_text().splitlines()))
    assert [(p["step"], float(p["value"])) for p in points if p["name"] == "hits"] == [
        ("128", 1.28),
        ("256", 2.56),
    ]
    assert json.loads((unpacked / "recipe.json").read_text())["name"] == "tiny"


def test_the_curves_are_there_for_tensorboard(unpacked: Path) -> None:
    (events,) = (unpacked / "tensorboard").iterdir()
    assert b"imitator/hits" in events.read_bytes()


def test_the_recordings_are_in_the_exchange_format(unpacked: Path) -> None:
    lines = (unpacked / "recordings/ranked.jsonl").read_text().splitlines()
    given = [load_recording(json.loads(line)) for line in lines]
    assert [one.tier for one in given] == [1, 2, 3, 4]
    assert [one.perfect for one in given] == [True, False, False, False]


def test_figures_are_there_for_the_screen_and_for_print(unpacked: Path) -> None:
    names = {path.stem for path in (unpacked / "figures").glob("*.svg")}
    assert {"aliens", "returns", "curves", "extrapolation"} <= names
    for name in names:
        assert (unpacked / f"figures/{name}.svg").read_text().rstrip().endswith("</svg>")
        with Image.open(unpacked / f"figures/{name}.png") as picture:
            assert round(picture.info["dpi"][0]) == 300


def test_the_model_card_names_what_is_in_the_archive(unpacked: Path) -> None:
    card = (unpacked / "model-card.md").read_text()
    assert "Shoot all six aliens of the leftmost column" in card
    assert "| imitator | greedy | 1 |" in card


def test_a_compact_archive_has_what_an_import_reads_and_half_as_long_weights(
    finished: tuple[Workplace, str], tmp_path: Path, unpacked: Path
) -> None:
    workplace, run_id = finished
    path = tmp_path / "run.zip"
    store = store_of(workplace)
    write_archive(workplace.database, store, run_id, path, tiny_clip, compact=True)
    with zipfile.ZipFile(path) as archive:
        names = set(archive.namelist())
        weights = archive.getinfo("policy/imitator.safetensors").file_size
    assert {"run.json", "policy/clone.safetensors", "attention/attention-maximum.png"} <= names
    assert not names & {"report.html", "policy/imitator.zip", "load_policy.py", "curves.csv"}
    full = (unpacked / "policy/imitator.safetensors").stat().st_size
    assert weights == pytest.approx(full / 2, rel=0.01)


def test_an_unfinished_run_and_one_that_is_not_there_are_refused(
    finished: tuple[Workplace, str], tmp_path: Path
) -> None:
    workplace, _ = finished
    path = tmp_path / "run.zip"
    for run_id, refusal, message in (
        (workplace.make_run(), Conflict, "This training is queued"),
        ("00000000-0000-0000-0000-000000000000", NotFound, "no such training"),
    ):
        with pytest.raises(refusal, match=message):
            write_archive(workplace.database, store_of(workplace), run_id, path, tiny_clip)
    assert not path.exists()

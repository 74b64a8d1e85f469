"""Where the reward model looks, as pictures, and the summary of the whole run."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from trainer.explain.attention import NamedState, attention_map, pick_states, states_at
from trainer.explain.faithfulness import measure_faithfulness
from trainer.progress import Progress, ScaledProgress
from trainer.reporting.figures import attention_picture, frame_picture
from trainer.reporting.run_report import write_report
from trainer.runtime.run_data import RunData
from tril.analysis.outcome import AttentionDetails, RewardPercentiles, RewardState
from tril.games.base import Console
from tril.play.episode import Episode
from tril.recording import Recording, replay

PNG = "image/png"
_ORDERS_STREAM = 1_000_037
"""Keeps the random orders apart from other draws of the same training seed."""
SUMMARY = "summary.md"
FIGURES = ("aliens.png", "returns.png", "extrapolation.png", "curves.png")


def draw_attention(data: RunData, progress: Progress) -> None:
    """Draw the attention maps of the states of minimum, high and maximum reward, and sum up."""
    rewards = []
    for trajectory in data.ranked_trajectories:
        rewards.append(data.reward_model.score(trajectory.observations))
        data.context.check_cancelled()
    _keep_percentiles(data, rewards)
    states = pick_states(rewards)
    rng = np.random.default_rng([data.context.run.training_seed, _ORDERS_STREAM])
    console = data.context.game.make_console()
    for index, state in enumerate(states):
        part = ScaledProgress(progress, index / len(states), (index + 1) / len(states))
        _draw_state(data, state, console, rng, part)
    _write_summary(data)


def _keep_percentiles(data: RunData, rewards: Sequence[npt.NDArray[np.float32]]) -> None:
    """Keep the states at all percentiles of R, so that the page can lead to any of them."""
    ranked = data.snapshot.ranked
    states = states_at(rewards, [percentile / 100 for percentile in range(101)])
    details = RewardPercentiles(
        states=[
            RewardState(reward=reward, recording_id=ranked[index], step=step)
            for index, step, reward in states
        ]
    )
    data.context.save_artifact(
        "reward_percentiles",
        "reward-percentiles.json",
        "application/json",
        details.model_dump_json().encode(),
        details.model_dump(mode="json"),
    )


def _draw_state(
    data: RunData,
    state: NamedState,
    console: Console,
    rng: np.random.Generator,
    progress: Progress,
) -> None:
    observation = data.ranked_trajectories[state.trajectory].observations[state.step]
    model = data.reward_model
    number = data.snapshot.ranked[state.trajectory]
    recording = data.recordings([number])[number]
    background = recording.game.screen.background
    maps = attention_map(model, observation, progress, background)
    screen = screen_at(recording, state.step, console)
    name = f"attention-{state.name.replace(' ', '-')}"
    details = AttentionDetails(
        state=state.name,
        reward=state.reward,
        recording_id=number,
        step=state.step,
        faithfulness=measure_faithfulness(
            model, observation, maps.sum(0), model.one - model.zero, rng, background
        ),
    ).model_dump(mode="json")
    files = {
        ("attention_map", f"{name}.png", PNG): attention_picture(maps.sum(0), "perceptual"),
        ("attention_red_blue", f"{name}-red-blue.png", PNG): attention_picture(
            maps.sum(0), "red-blue"
        ),
        ("attention_frame", f"{name}-frame.png", PNG): frame_picture(screen),
        ("attention", f"{name}.npy", "application/octet-stream"): _npy(maps),
    }
    for (kind, file_name, media_type), content in files.items():
        data.context.save_artifact(kind, file_name, media_type, content, details)


def screen_at(recording: Recording, step: int, console: Console) -> npt.NDArray[np.uint8]:
    """Return the screen, uint8 (height, width, 3) RGB, that a step of a recording ended on."""
    game = recording.game
    screens: list[npt.NDArray[np.uint8]] = []

    def look(episode: Episode) -> None:
        # A step that the episode's end cut short ends on the last frame.
        if episode.frame == min(step * game.clock.frames_per_step, recording.n_frames):
            screen, palette = console.screen(), game.screen.palette
            screens.append(screen if palette is None else palette[screen])

    replay(recording, console, look)
    return screens[0]


def _npy(values: npt.NDArray[np.float32]) -> bytes:
    target = io.BytesIO()
    np.save(target, values, allow_pickle=False)
    return target.getvalue()


def _write_summary(data: RunData) -> None:
    context = data.context
    folder = context.stage_folder("attention")
    page = write_report(context.database, context.artifacts, context.run_id, folder)
    context.save_artifact("summary", SUMMARY, "text/markdown", page.read_bytes())
    for name in FIGURES:
        if (folder / name).exists():
            context.save_artifact("figure", name, PNG, (folder / name).read_bytes())

import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3 import PPO

from tril.errors import Invalid
from tril.games.atari.starts import TRAINING_IDLE_FRAMES, AtariStart
from tril.games.base import Console
from tril.games.space_invaders import SPACE_INVADERS
from tril.play.agent import AgentGame
from tril.play.env import ENV_ID, TrilEnv

ROOT = Path(__file__).parents[3]


def test_the_registered_environment_passes_gymnasiums_checks() -> None:
    env = gymnasium.make(ENV_ID, render_mode="rgb_array")
    check_env(env.unwrapped)
    env.close()


def test_it_plays_the_game_that_agents_play(console: Console) -> None:
    env = TrilEnv(start=AtariStart(12), target=[(0, 0), (1, 0)])
    game = AgentGame(console)
    game.reset(AtariStart(12))
    observation, info = env.reset(seed=0)
    np.testing.assert_array_equal(observation, game.observation)
    terminated = truncated = False
    points = 0.0
    while not (terminated or truncated):
        game.step(1)
        observation, reward, terminated, truncated, info = env.step(1)
        np.testing.assert_array_equal(observation, game.observation)
        points += reward
    assert terminated
    hits = [hit.cell for hit in game.taken]
    assert info["taken"] == hits
    assert info["end"] == "hit"
    assert info["frame"] == game.episode.frame
    assert info["targets"] == len({(0, 0), (1, 0)} & set(hits))
    assert info["strays"] == len(hits) - info["targets"]
    assert points == sum(5 * (row + 1) for row, _ in hits) > 0


def test_the_reward_can_be_the_missiles_fired() -> None:
    env = TrilEnv(start=AtariStart(12), reward="shots")
    game = AgentGame(SPACE_INVADERS.make_console())
    game.reset(AtariStart(12))
    env.reset(seed=0)
    paid = 0.0
    while game.end is None:
        game.step(1)
        paid += float(env.step(1)[1])
    assert paid == game.episode.counters["shots"] > len(game.taken) > 0


def test_the_reward_can_be_turned_off() -> None:
    env = TrilEnv(start=AtariStart(12), reward="none")
    env.reset(seed=0)
    assert {env.step(1)[1] for _ in range(90)} == {0.0}


def test_starts_are_drawn_from_the_training_starts_by_the_seed() -> None:
    env = TrilEnv()
    starts = [env.reset(seed=seed)[1]["start"] for seed in range(20)]
    assert starts == [env.reset(seed=seed)[1]["start"] for seed in range(20)]
    idle = {start["idle_frames"] for start in starts}
    assert len(idle) > 10
    assert idle <= set(TRAINING_IDLE_FRAMES)


def test_options_hold_from_the_reset_on() -> None:
    env = TrilEnv()
    options = {"start": AtariStart(0), "end_rule": "life_counter", "target": [(0, 5)]}
    _, info = env.reset(seed=0, options=options)
    assert (info["start"]["idle_frames"], info["targets"]) == (0, 0)
    terminated = False
    while not terminated:
        *_, terminated, _, info = env.step(0)
    assert (info["end"], info["frame"]) == ("lives", 571)


def test_sticky_actions_show_in_what_was_executed() -> None:
    env = TrilEnv(sticky_action_probability=0.5)
    env.reset(seed=3)
    executed = [env.step(2 + step % 2)[4]["executed_actions"] for step in range(30)]
    assert any(len(set(frames)) > 1 for frames in executed)
    env.reset(seed=3)
    assert executed == [env.step(2 + step % 2)[4]["executed_actions"] for step in range(30)]


def test_the_screen_can_be_rendered() -> None:
    env = TrilEnv(render_mode="rgb_array")
    env.reset(seed=0)
    screen = env.render()
    assert screen is not None
    assert (screen.shape, screen.dtype) == ((210, 160, 3), np.dtype(np.uint8))
    assert screen.max() > 0
    assert TrilEnv().render() is None


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"target": [(6, 0)]}, "no item"),
        ({"reward": "points"}, "reward of score, shots, none"),
        ({"render_mode": "human"}, 'render_mode None or "rgb_array"'),
        ({"end_rule": "never"}, "never"),
    ],
)
def test_options_that_do_not_exist_are_refused(values: dict[str, object], message: str) -> None:
    with pytest.raises((ValueError, Invalid), match=message):
        TrilEnv(**values)  # type: ignore[arg-type]


def test_an_unknown_reset_option_is_refused() -> None:
    with pytest.raises(ValueError, match=r"target, start and end_rule, got \['mode'\]"):
        TrilEnv().reset(options={"mode": 1})


def test_plain_stable_baselines3_trains_on_it_as_the_example_shows(tmp_path: Path) -> None:
    output = tmp_path / "agent.zip"
    tiny = ["--steps", "32", "--rollout-steps", "16", "--games", "2", "--episodes", "1"]
    example = ROOT / "examples" / "train_with_stable_baselines3.py"
    done = subprocess.run(
        [sys.executable, example, *tiny, "--output", output],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "points per game" in done.stdout
    agent = PPO.load(output)
    observation, _ = TrilEnv().reset(seed=0)
    action, _ = agent.predict(observation)
    assert 0 <= int(action) < 6

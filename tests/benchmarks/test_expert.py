"""The expert that is asked what to do in any state of a game."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.learning.expert import EXPERT_STYLE, Expert
from tril.demonstrators.space_invaders.player import ScriptedPlayer
from tril.errors import Invalid
from tril.games.atari.starts import AtariStart
from tril.games.base import Cell, Console
from tril.games.behaviours import Behaviour
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.memory import FRAMES_PER_STEP
from tril.play.episode import Episode
from tril.recording import Recorder

BY_SLUG = {behaviour.slug: behaviour for behaviour in BUILT_IN}
START = AtariStart(50)


def step(episode: Episode, action: int) -> None:
    for _ in range(FRAMES_PER_STEP):
        if episode.end is None:
            episode.advance(action)


def follow(expert: Expert, episode: Episode) -> str:
    """Play a game to its end as the expert says; returns why it ended."""
    while episode.end is None:
        step(episode, expert.action(episode.save()))
    return episode.end


def cells(episode: Episode) -> list[Cell]:
    return [hit.cell for hit in episode.taken]


@pytest.fixture(scope="module")
def console() -> Console:
    return SPACE_INVADERS.make_console()


@pytest.fixture(scope="module")
def lookahead() -> Console:
    return SPACE_INVADERS.make_console()


@pytest.mark.parametrize("slug", ["column-2", "row-1"])
def test_following_the_expert_gives_the_demonstrators_game(
    slug: str, console: Console, lookahead: Console
) -> None:
    behaviour = BY_SLUG[slug]
    assert behaviour.target is not None
    recorder = Recorder(Episode(console, START))
    chances = np.random.default_rng(7)
    ScriptedPlayer(recorder, behaviour.target, EXPERT_STYLE, chances).play()
    expert = Expert(behaviour, lookahead)
    expert.begin(np.random.default_rng(7))
    episode = Episode(console, START)
    follow(expert, episode)
    assert episode.actions == recorder.recording().actions
    assert cells(episode) == list(behaviour.target)


@pytest.mark.parametrize("seed", [1, 4, 5])
def test_the_expert_hits_the_remaining_targets_from_any_state(
    seed: int, console: Console, lookahead: Console
) -> None:
    behaviour = BY_SLUG["column-3"]
    assert behaviour.target is not None
    expert = Expert(behaviour, lookahead)
    expert.begin(np.random.default_rng(0))
    rng = np.random.default_rng(seed)
    episode = Episode(console, START)
    # It is asked all along, as in DAgger, but not obeyed.
    for _ in range(40):
        said = expert.action(episode.save())
        step(episode, int(rng.integers(6)))
        assert 0 <= said < 6
    before = cells(episode)
    assert follow(expert, episode) == EndReason.STEPS
    after = cells(episode)[len(before) :]
    left = [cell for cell in behaviour.target if cell not in before]
    assert [cell for cell in after if cell in left] == left
    # One missile may have been in the air when it took over.
    assert len(after) - len(left) <= 1


def test_the_same_state_gives_the_same_action(console: Console, lookahead: Console) -> None:
    expert = Expert(BY_SLUG["column-1"], lookahead)
    expert.begin(np.random.default_rng(0))
    episode = Episode(console, START)
    for _ in range(20):
        state = episode.save()
        said = expert.action(state)
        assert expert.action(state) == said
        step(episode, said)
        assert state.actions == episode.actions[:-FRAMES_PER_STEP]


def test_begin_discards_the_plan_of_the_last_game(console: Console, lookahead: Console) -> None:
    expert = Expert(BY_SLUG["column-1"], lookahead)
    played = []
    for _ in range(2):
        expert.begin(np.random.default_rng(3))
        episode = Episode(console, START)
        for _ in range(30):
            step(episode, expert.action(episode.save()))
        played.append(episode.actions)
    assert played[0] == played[1]


def test_only_what_the_demonstrator_can_show_has_an_expert(lookahead: Console) -> None:
    with pytest.raises(Invalid, match="stands behind aliens"):
        Expert(Behaviour("top", "Top", "", "space_invaders", ((5, 0),)), lookahead)

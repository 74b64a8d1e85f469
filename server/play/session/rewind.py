"""Rewinding: a game's scenes in reverse, from states that were saved once a second."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from server.play.consoles import ConsolePool
from server.play.session.clock import JumpDetector
from server.play.wire.scene import Scene
from tril.games.base import Console
from tril.play.episode import Episode, EpisodeState
from tril.recording import Recording, hash_interval

SLOW_FRAMES = 2
FAST_FRAMES = 4
"""Frames rewound per frame shown: a whole game takes six seconds."""
FAST_AFTER_S = 1.0


class Checkpoints:
    """States of a game under way, so that every frame is at most a second's replay away.

    A state takes about 45 kB and 0.1 ms. A resumed game has none of its earlier frames; they are
    made when they are first needed.
    """

    def __init__(self) -> None:
        self._states: dict[int, EpisodeState] = {}

    def add_if_due(self, episode: Episode) -> None:
        """Save the episode's state once a second, if the game saves states."""
        if not episode.game.saves_states:
            return
        if episode.frame % hash_interval(episode.game) == 0 and episode.frame not in self._states:
            self._states[episode.frame] = episode.save()

    def discard_after(self, frame: int) -> None:
        """Discard the states after a frame."""
        self._states = {at: state for at, state in self._states.items() if at <= frame}

    def latest_until(self, frame: int) -> EpisodeState | None:
        """Return the last state saved at or before a frame; None means the start."""
        before = [at for at in self._states if at <= frame]
        return self._states[max(before)] if before else None

    def scenes(self, recording: Recording, last: int, console: Console) -> dict[int, Scene]:
        """Return the scenes of a frame and of those before it in its second, by frame.

        Blocks, so call it in a thread: it replays up to a second, or from the start if there is no
        nearer state.
        """
        episode = Episode(console, recording.start, recording.end_rule)
        state = self.latest_until(last)
        if state is not None:
            episode.restore(state)
        scenes: dict[int, Scene] = {}
        first = last - last % hash_interval(recording.game)
        while True:
            self.add_if_due(episode)
            if episode.frame >= first:
                scenes[episode.frame] = Scene.of(episode)
            if episode.frame >= last:
                return scenes
            episode.advance(recording.actions[episode.frame])


async def play_backwards(
    checkpoints: Checkpoints,
    recording: Recording,
    consoles: ConsolePool,
    show: Callable[[Scene], Awaitable[object]],
    is_over: Callable[[], bool],
) -> int:
    """Show a game in reverse until told to stop; at its start it waits for that.

    Args:
        checkpoints: The game's states.
        recording: Recording of the game so far.
        consoles: The pool to take a console from.
        show: Shows a scene.
        is_over: Whether to stop.

    Returns:
        The frame shown last.

    Raises:
        ProcessSuspended: Time jumped.
    """
    loop = asyncio.get_running_loop()
    console = await asyncio.to_thread(consoles.take, recording.game)
    frame_s = 1.0 / recording.game.clock.frame_rate_hz
    scenes: dict[int, Scene] = {}
    frame = recording.n_frames
    began = deadline = loop.time()
    try:
        with consoles.loading_suspended():
            while not is_over():
                step = SLOW_FRAMES if loop.time() - began < FAST_AFTER_S else FAST_FRAMES
                to = max(0, frame - step)
                if to < frame:
                    if to not in scenes:
                        scenes = await asyncio.to_thread(checkpoints.scenes, recording, to, console)
                    await show(scenes[to])
                    frame = to
                deadline = max(deadline + frame_s, loop.time())
                jumps = JumpDetector()
                await asyncio.sleep(deadline - loop.time())
                jumps.check(frame_s)
    finally:
        consoles.give_back(console)
    return frame

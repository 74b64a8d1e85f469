"""Running a game back: its scenes in reverse, from states that were saved once a second."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from server.play.consoles import ConsolePool
from server.play.wire.scene import Scene
from tril.game import space_invaders as game
from tril.game.console import Console
from tril.game.episode import Episode, EpisodeState
from tril.recording import Recording

STATE_EVERY_FRAMES = game.FRAME_RATE_HZ
SLOW_FRAMES = 2
FAST_FRAMES = 4
"""How many frames a run goes back in the time of one: the whole game takes six seconds."""
FAST_AFTER_S = 1.0


class Tape:
    """States of a game under way, so that every frame of it is at most a second's play away.

    A state takes about 45 kB and 0.1 ms. A game that was taken up again has none of the frames
    before; they are made when they are needed first.
    """

    def __init__(self) -> None:
        self._states: dict[int, EpisodeState] = {}

    def note(self, episode: Episode) -> None:
        """Save the episode's state if it is time to."""
        if episode.frame % STATE_EVERY_FRAMES == 0 and episode.frame not in self._states:
            self._states[episode.frame] = episode.save()

    def cut(self, frame: int) -> None:
        """Forget what came after a frame."""
        self._states = {at: state for at, state in self._states.items() if at <= frame}

    def state_before(self, frame: int) -> EpisodeState | None:
        """Return the last state saved at or before a frame; None means the start."""
        before = [at for at in self._states if at <= frame]
        return self._states[max(before)] if before else None

    def scenes(self, recording: Recording, last: int, console: Console) -> dict[int, Scene]:
        """Return the scenes of a frame and of those before it in its second, by frame.

        Call it in a thread: it plays up to a second on the console, or from the start if no state
        is nearer.
        """
        episode = Episode(console, recording.start)
        state = self.state_before(last)
        if state is not None:
            episode.restore(state)
        scenes: dict[int, Scene] = {}
        first = last - last % STATE_EVERY_FRAMES
        while True:
            self.note(episode)
            if episode.frame >= first:
                scenes[episode.frame] = Scene.of(episode)
            if episode.frame >= last:
                return scenes
            episode.advance(recording.actions[episode.frame])


async def run_back(
    tape: Tape,
    recording: Recording,
    consoles: ConsolePool,
    show: Callable[[Scene], Awaitable[object]],
    is_over: Callable[[], bool],
) -> int:
    """Show a game in reverse until the player lets go; at its start it waits there.

    Args:
        tape: The game's states.
        recording: What was played.
        consoles: Where a console to show it on comes from.
        show: Shows a scene.
        is_over: Whether to stop.

    Returns:
        The frame shown last.
    """
    loop = asyncio.get_running_loop()
    console = await asyncio.to_thread(consoles.take)
    scenes: dict[int, Scene] = {}
    frame = recording.n_frames
    began = deadline = loop.time()
    try:
        with consoles.undisturbed():
            while not is_over():
                pace = SLOW_FRAMES if loop.time() - began < FAST_AFTER_S else FAST_FRAMES
                to = max(0, frame - pace)
                if to < frame:
                    if to not in scenes:
                        scenes = await asyncio.to_thread(tape.scenes, recording, to, console)
                    await show(scenes[to])
                    frame = to
                deadline = max(deadline + 1 / game.FRAME_RATE_HZ, loop.time())
                await asyncio.sleep(deadline - loop.time())
    finally:
        consoles.give_back(console)
    return frame

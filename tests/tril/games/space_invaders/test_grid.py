import numpy as np
import pytest

from tests.tril.conftest import LONG_GAME_FRAMES, LongGame
from tests.tril.games.space_invaders.screen_reader import ALIEN_COLOUR, SKY, ScreenReader
from testsupport.space_invaders import new_console, ram
from tril.games.atari.console import AtariConsole
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders import memory as game
from tril.games.space_invaders.ends import Ending, EndReason
from tril.games.space_invaders.grid import AlienGrid, landed
from tril.games.space_invaders.readout import alien_grid
from tril.play.episode import Episode

CANNON_COLOUR = 196
EXPLOSION_FRAMES = 32
"""An alien that was hit stays on the screen, exploding, for up to this many frames."""


def test_the_long_game_clears_the_columns_from_the_left(long_game: LongGame) -> None:
    assert long_game.end == EndReason.CLEARED
    assert [hit.column for hit in long_game.hits] == [c for c in range(6) for _ in range(6)]
    assert {(hit.row, hit.column) for hit in long_game.hits} == {
        (row, column) for row in range(6) for column in range(6)
    }


def test_the_grid_equals_a_reading_of_the_screen_through_a_whole_game(
    console: AtariConsole, long_game: LongGame
) -> None:
    episode = Episode(console, long_game.start, max_frames=LONG_GAME_FRAMES)
    reader = ScreenReader()
    compared_exactly = 0
    for action in long_game.actions[:-1]:
        episode.advance(action)
        differs = reader.read(console.screen()) != alien_grid(episode.readout).alive
        exploding = np.zeros((6, 6), np.bool_)
        for hit in episode.taken:
            if episode.frame - hit.frame < EXPLOSION_FRAMES:
                exploding[hit.row, hit.column] = True
        assert not (differs & ~exploding).any(), f"frame {episode.frame}"
        compared_exactly += not exploding.any()
    assert compared_exactly > len(long_game.actions) / 2
    assert alien_grid(episode.readout).shifts == 5


def test_the_grid_agrees_with_the_games_own_count_at_every_frame(
    console: AtariConsole, long_game: LongGame
) -> None:
    episode = Episode(console, long_game.start, max_frames=LONG_GAME_FRAMES)
    for action in long_game.actions:
        episode.advance(action)
        left = int(ram(console)[game.RAM_ALIENS_LEFT])
        assert alien_grid(episode.readout).alive.sum() == left == 36 - len(episode.taken)
    assert episode.end == EndReason.CLEARED


@pytest.mark.parametrize("idle_frames", [4, 40, 76, 112])
def test_a_bomb_is_where_it_hits_the_player(console: AtariConsole, idle_frames: int) -> None:
    episode = Episode(console, AtariStart(idle_frames))
    falling: set[int] = set()
    while episode.end is None:
        episode.advance(game.Action.RIGHT if episode.frame < 60 else game.Action.NOOP)
        falling |= {ram(console)[y] for y, _ in game.RAM_BOMBS}
    assert episode.end == EndReason.HIT
    bombs = [(int(ram(console)[y]), int(ram(console)[x])) for y, x in game.RAM_BOMBS]
    player_x = int(ram(console)[game.RAM_PLAYER_X])
    assert any(84 <= y <= 98 and 0 <= x - player_x <= 8 for y, x in bombs)
    assert set(range(65, 85)) <= falling


def test_a_hit_pays_the_points_of_its_row(console: AtariConsole, long_game: LongGame) -> None:
    def score() -> int:
        high, low = (f"{ram(console)[a]:02x}" for a in (game.RAM_SCORE_HIGH, game.RAM_SCORE_LOW))
        return int(high + low)

    episode = Episode(console, long_game.start, max_frames=LONG_GAME_FRAMES)
    paid = []
    for action in long_game.actions:
        before, hits = score(), len(episode.taken)
        episode.advance(action)
        if len(episode.taken) > hits:
            paid.append((score() - before, game.POINTS[episode.taken[-1].row]))
    assert len(paid) == 36
    assert all(got == expected for got, expected in paid)


def test_a_restored_grid_goes_on_with_the_right_columns(
    console: AtariConsole, long_game: LongGame
) -> None:
    episode = Episode(console, long_game.start, max_frames=LONG_GAME_FRAMES)
    cut = long_game.hits[20].frame + 1
    for action in long_game.actions[:cut]:
        episode.advance(action)
    assert alien_grid(episode.readout).shifts == 3
    saved = episode.save()
    other = Episode(SPACE_INVADERS.make_console(), AtariStart(0), max_frames=LONG_GAME_FRAMES)
    other.restore(saved)
    for action in long_game.actions[cut:]:
        other.advance(action)
    assert other.taken == long_game.hits


def test_a_grid_cannot_begin_in_the_middle_of_a_game(
    console: AtariConsole, long_game: LongGame
) -> None:
    console.start(long_game.start)
    for action in long_game.actions[: long_game.hits[0].frame]:
        console.act(action)
    with pytest.raises(ValueError, match="followed from the start"):
        AlienGrid(console.ram_bytes())


def test_the_aliens_have_landed_when_the_emulator_says_that_the_game_is_over() -> None:
    console = new_console()
    console.start(AtariStart(0))
    # Only the top row is left, and it stands low.
    console._ale.setRAM(game.RAM_ALIEN_Y, 60)
    console._ale.setRAM(game.RAM_ALIENS_LEFT, 6)
    for row in range(5):
        console._ale.setRAM(game.RAM_ALIEN_ROWS + row, 0)
    frames = 0
    while not console._ale.game_over():
        assert not landed(ram(console))
        console.act(0)
        frames += 1
    assert landed(ram(console))
    assert frames > 100


def test_an_episode_ends_when_the_aliens_land() -> None:
    console = new_console()
    for ending in Ending:
        episode = Episode(console, AtariStart(0), ending)
        console._ale.setRAM(game.RAM_ALIEN_Y, 40)
        episode.advance(0)
        assert episode.end == EndReason.LANDED


def test_the_formation_is_where_the_screen_shows_the_aliens(
    console: AtariConsole, long_game: LongGame
) -> None:
    episode = Episode(console, long_game.start, max_frames=LONG_GAME_FRAMES)
    height, width = game.ALIEN_SIZE
    drawn = np.zeros((height, width), np.bool_)
    exact = 0
    for action in long_game.actions[:-1]:
        episode.advance(action)
        place = alien_grid(episode.readout).formation(episode.console.ram_bytes())
        assert -96 <= place.left < 160
        assert 0 <= place.top < 256
        if episode.taken and episode.frame - episode.taken[-1].frame < EXPLOSION_FRAMES:
            continue
        seen = console.screen() == ALIEN_COLOUR
        seen[: SKY.start] = seen[SKY.stop :] = False
        for row, column in np.argwhere(alien_grid(episode.readout).alive):
            left = place.left + game.COLUMN_WIDTH * column
            top = place.top + game.ROW_HEIGHT * (game.ROWS - 1 - row)
            box = seen[top : top + height, left : left + width]
            assert box.any(), f"frame {episode.frame}"
            drawn |= box
            box[:] = False
        assert not seen.any(), f"frame {episode.frame}"
        exact += 1
    assert exact > len(long_game.actions) / 2
    assert all(edge.any() for edge in (drawn[0], drawn[-1], drawn[:, 0], drawn[:, -1]))
    assert alien_grid(episode.readout).shifts == 5, "the left columns are gone"


@pytest.mark.parametrize("difficulty", [0, 1])
def test_the_cannon_is_where_it_was_a_frame_before(console: AtariConsole, difficulty: int) -> None:
    episode = Episode(console, AtariStart(5, difficulty=difficulty))
    offset, width = game.CANNON_EDGES[difficulty]
    moves = [game.Action.RIGHT] * 150 + [game.Action.LEFTFIRE] * 60
    for action in moves:
        before = int(ram(console)[game.RAM_PLAYER_X])
        episode.advance(action)
        if episode.end is not None:
            break
        bottom = console.screen()[game.CANNON_TOP + game.CANNON_HEIGHT - 1]
        # Bombs fall past it and have another colour.
        (xs,) = np.nonzero(bottom == CANNON_COLOUR)
        assert (xs.min(), xs.max()) == (before + offset, before + offset + width - 1)
    assert episode.frame > 150

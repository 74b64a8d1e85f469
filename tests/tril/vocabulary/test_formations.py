"""Formations that are drawn here: three rows of five things that walk, and a ship below them."""

from __future__ import annotations

import io
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.tril.vocabulary.test_facts import BUTTONS, HORIZON, played
from tril.demonstrators.random_play import play_randomly
from tril.games import game_named
from tril.games.base import Screen
from tril.vocabulary.answers import kinds_about, subject_of
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.formations import (
    FORMATION,
    Follower,
    Formation,
    alike_things,
    moving_formation,
    without_formation,
)
from tril.vocabulary.groups import Aspect
from tril.vocabulary.making import vocabulary_of
from tril.vocabulary.names import kind_name, one_name
from tril.vocabulary.pictures import pictures_of
from tril.vocabulary.pieces import gone_items
from tril.vocabulary.pointing import meanings_of
from tril.vocabulary.sentences import phrase, tell
from tril.vocabulary.trace import Scene, Trace, trace
from tril.vocabulary.understanding import understand
from tril.vocabulary.watched import things_of

N_ROWS, N_COLUMNS = 3, 5
N_ITEMS = N_ROWS * N_COLUMNS
LEFT, TOP = 20, 40
BODY, EYES = 0x14, 0x38
"""Colours."""
SHIP = (70, 180)
"""Left and top of what is as large as an item and stands still."""


def draw(
    shift: tuple[int, int] = (0, 0), gone: Collection[int] = (), *, raised: bool = False
) -> Screen:
    """Return a screen with the formation.

    Args:
        shift: How far it has walked.
        gone: Items that are gone, from 0, row by row.
        raised: Whether their arms are, as every other moment.
    """
    screen = np.zeros((210, 160), np.uint8)
    screen[SHIP[1] : SHIP[1] + 8, SHIP[0] : SHIP[0] + 8] = BODY
    for item in range(N_ITEMS):
        if item in gone:
            continue
        row, column = divmod(item, N_COLUMNS)
        left, top = LEFT + 16 * column + shift[0], TOP + 16 * row + shift[1]
        screen[top + 2 : top + 8, left + 1 : left + 7] = BODY
        screen[top + 4, left + 2 : left + 6 : 3] = EYES
        arms = top if raised else top + 6
        screen[arms : arms + 2, [left, left + 7]] = BODY
    return screen


def screens(order: Collection[int], n_steps: int = HORIZON) -> list[Screen]:
    """Return a game in which an item is hit every eight steps."""
    return [
        draw((step // 4, 0), list(order)[: (step + 4) // 8], raised=step % 8 >= 4)
        for step in range(n_steps)
    ]


def walking(seed: int, order: Collection[int], formation: Formation) -> Trace:
    """Return a game of the steered thing of `played` below the formation."""
    follower = Follower(formation)
    for screen in screens(order):
        follower.look(screen)
    return replace(played(seed), followed=follower.followed)


@pytest.fixture(scope="module")
def formation() -> Formation:
    candidate = alike_things(draw())
    assert candidate is not None
    games = []
    for seed in range(12):
        follower = Follower(candidate)
        for screen in screens(np.random.default_rng(seed).permutation(N_ITEMS)[:4].tolist()):
            follower.look(screen)
        games.append(follower.followed)
    found = moving_formation(candidate, games)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def words(formation: Formation) -> Vocabulary:
    rng = np.random.default_rng(0)
    games = [walking(seed, rng.permutation(N_ITEMS)[:5].tolist(), formation) for seed in range(20)]
    return Vocabulary.of_games(games, Scene(draw() * 0, draw(), formation), BUTTONS, HORIZON)


def test_what_stands_beside_the_formation_is_no_item(formation: Formation) -> None:
    candidate = alike_things(draw())
    assert candidate is not None
    assert candidate.n_items == N_ITEMS + 1
    assert formation.n_items == N_ITEMS
    columns, rows = formation.lines
    assert columns.tolist() == list(range(N_COLUMNS)) * N_ROWS
    assert rows.tolist() == [row for row in range(N_ROWS) for _ in range(N_COLUMNS)]


@pytest.mark.parametrize("screen", [np.zeros((210, 160), np.uint8), draw(gone=range(9))])
def test_few_things_are_no_formation(screen: Screen) -> None:
    assert alike_things(screen) is None


def test_a_texture_is_no_formation() -> None:
    tile = np.zeros((8, 8), np.uint8)
    tile[2:6, 2:6] = BODY
    assert alike_things(np.tile(tile, (40, 40))) is None


def test_things_that_stand_still_are_no_formation(formation: Formation) -> None:
    games = []
    for seed in range(5):
        follower = Follower(formation)
        for step in range(HORIZON):
            follower.look(draw(gone=range(min(seed, step // 8))))
        games.append(follower.followed)
    assert moving_formation(formation, games) is None


def test_things_that_are_never_gone_are_no_formation(formation: Formation) -> None:
    games = [walking(seed, [], formation).followed for seed in range(5)]
    assert moving_formation(formation, [game for game in games if game is not None]) is None


def test_items_are_followed_and_missed(formation: Formation) -> None:
    followed = walking(0, [7, 0, 5], formation).followed
    assert followed is not None
    assert followed.is_found.all()
    # A step of the animation may look like one of the walk.
    assert np.abs(followed.shifts[:, 0] - np.arange(HORIZON) // 4).max() <= 1
    gone = gone_items(followed).is_gone
    assert np.flatnonzero(gone[-1]).tolist() == [0, 5, 7]
    assert gone.argmax(0)[[7, 0, 5]].tolist() == [4, 12, 20]


def test_a_formation_that_comes_a_row_closer_is_followed(formation: Formation) -> None:
    follower = Follower(formation)
    for shift in ((0, 0), (2, 0), (4, 10), (2, 10)):
        follower.look(draw(shift, gone=[3]))
    followed = follower.followed
    assert followed.shifts.tolist() == [[0, 0], [2, 0], [4, 10], [2, 10]]
    assert np.flatnonzero(followed.missing[-1]).tolist() == [3]


def test_a_hidden_formation_is_not_gone(formation: Formation) -> None:
    follower = Follower(formation)
    for screen in (draw(), draw(gone=[2]), *([draw() * 0] * 12), draw((2, 0), gone=[2])):
        follower.look(screen)
    followed = follower.followed
    assert followed.is_found.tolist() == [True] * 2 + [False] * 12 + [True]
    assert all(np.flatnonzero(row).tolist() == [2] for row in followed.missing[1:])


def test_two_that_are_hidden_come_back(formation: Formation) -> None:
    follower = Follower(formation)
    gone = list(range(N_ITEMS - 2))
    for screen in (
        *([draw(gone=gone)] * 10),
        *([draw() * 0] * 12),
        *([draw((2, 0), gone=gone)] * 2),
    ):
        follower.look(screen)
    followed = follower.followed
    assert np.flatnonzero(~followed.missing[-1]).tolist() == [13, 14]
    assert not followed.are_there[15].any()
    assert np.isnan(followed.offset_to_nearest(*np.zeros((2, 24), np.float32))[0][15])


def test_what_walks_off_the_screen_is_not_hit(formation: Formation) -> None:
    follower = Follower(formation)
    # 20 px are left of it.
    for step in range(40):
        x = -step
        screen = draw((0, 0), gone=[7])
        follower.look(np.roll(np.pad(screen, ((0, 0), (0, 100))), x, axis=1)[:, :160])
    followed = follower.followed
    assert followed.shifts[-1, 0] == -39
    assert np.flatnonzero(gone_items(followed).is_gone[30]).tolist() == [7]


def test_an_item_that_dives_is_not_gone(formation: Formation) -> None:
    follower = Follower(formation)
    for step in range(100):
        diving = {4} if 10 <= step < 60 else set()
        hit = {7} if step >= 30 else set()
        follower.look(draw(gone=diving | hit))
    followed = follower.followed
    assert followed.missing[40].sum() == 2
    gone = gone_items(followed).is_gone
    assert np.flatnonzero(gone.any(0)).tolist() == [7]
    assert gone[:, 7].argmax() == 30


def test_items_hit_before_the_next_wave_stay_gone(formation: Formation) -> None:
    follower = Follower(formation)
    for step in range(90):
        follower.look(draw(gone=range(min(step // 4, N_ITEMS - 4))) if step < 70 else draw())
    gone = gone_items(follower.followed).is_gone
    # Those of the half of a second before are not told from what passed before them.
    assert gone[:63].sum(0).tolist() == [*range(59, 15, -4), *[0] * 4]
    assert not gone[70:].any()


def test_items_that_return_late_or_together_were_gone(formation: Formation) -> None:
    follower = Follower(formation)
    # Two that a missile hides for a while long after they were hit, and five of fifteen that come
    # back together before half are gone.
    for step in range(240):
        hit = {0, 1} if step >= 4 and not 200 <= step < 212 else set()
        follower.look(draw(gone=hit | ({5, 6, 7, 8} if 20 <= step < 60 else set())))
    gone = gone_items(follower.followed).is_gone
    assert gone[4:193, :2].all()
    assert gone[20:53, 5:9].all()
    assert not gone[60:, 5:9].any()


def test_things_at_the_edge_are_as_large_as_others() -> None:
    screen = np.zeros((210, 160), np.uint8)
    for left in range(0, 90, 10):
        screen[0:3, left : left + 3] = BODY
    found = alike_things(screen)
    assert found is not None
    assert found.n_items == 9
    assert found.boxes[0].tolist() == [0, 0, 3, 3]


@pytest.mark.parametrize("n_waiting", [0, 12])
def test_the_next_wave_begins_anew(formation: Formation, n_waiting: int) -> None:
    follower = Follower(formation)
    order = list(range(N_ITEMS))
    # As far as from one column to the next.
    for step in range(8 * N_ITEMS + n_waiting):
        follower.look(draw((16 * step // (8 * N_ITEMS), 0), order[: step // 8]))
    if n_waiting:
        assert follower.followed.missing[-1].all()
    for step in range(4):
        follower.look(draw((step, 0)))
    assert not follower.followed.missing[-1].any()
    assert follower.followed.shifts[-1].tolist() == [3, 0]


def test_a_screen_without_its_items_has_all_else(formation: Formation) -> None:
    follower = Follower(formation)
    screen = draw((3, 0), gone=[4], raised=True)
    # A shot beside an item has a colour of its own.
    screen[50:54, 34] = 0x0A
    follower.look(draw())
    follower.look(screen)
    shown = follower.without_items(screen, draw() * 0)
    assert set(np.unique(shown).tolist()) == {0, BODY, 0x0A}
    assert (shown == 0x0A).sum() == 4
    assert (shown == BODY).sum() == 64


def test_a_background_has_nothing_of_the_formation(formation: Formation) -> None:
    games = [walking(0, [], formation).followed]
    background = draw((4, 0))
    # A wall of the same colour stands still.
    background[20:30, 20:140] = BODY
    beginning = draw()
    beginning[20:30, 20:140] = BODY
    followed = [game for game in games if game is not None]
    cleared = without_formation(background, beginning, formation, followed)
    left = draw(gone=range(N_ITEMS))
    left[20:30, 20:140] = BODY
    assert np.array_equal(cleared, left)


def test_the_nearest_item_is_told_from_the_place(formation: Formation) -> None:
    followed = walking(0, [10], formation).followed
    assert followed is not None
    at = np.full(HORIZON, LEFT + 4, np.float32), np.full(HORIZON, 120, np.float32)
    dx, dy = followed.offset_to_nearest(*at)
    assert abs(dx[0]) <= 1
    assert abs(dy[0] + 120 - (TOP + 36)) <= 2
    # After the item is gone the next one of its row is the nearest.
    assert abs(dx[10] - 16 - 2) <= 2
    nowhere = followed.offset_to_nearest(at[0] * np.nan, at[1])
    assert np.isnan(nowhere).all()


@pytest.mark.parametrize("column", [0, 2])
def test_an_order_by_the_items_of_a_column_is_told(words: Vocabulary, column: int) -> None:
    formation = words.scene.formation
    assert formation is not None
    # From bottom to top, as all else, so that it is not the order in which they are cleared.
    own = [column + N_COLUMNS * row for row in reversed(range(N_ROWS))]
    rng = np.random.default_rng(column)
    others = [item for item in range(N_ITEMS) if item not in own]
    games: list[Trace] = []
    tiers: list[list[int]] = []
    for n_own in (3, 2, 1, 0):
        tiers.append([len(games) + place for place in range(3)])
        for _ in range(3):
            order = [*own[:n_own], *sorted(rng.permutation(others)[: 4 - n_own].tolist())[::-1]]
            games.append(walking(100 + len(games), order, formation))
    summaries = np.stack([words.summary(words.facts(game)) for game in games])
    understood = understand(words, summaries, tiers)
    told = tell(words, understood.posterior, game_named("space_invaders"))[0]
    # As many are cleared in all games: "more" here and "only" here say the same of them.
    where = f"in column {column + 1} of 5 from the left"
    assert told.sentence in (f"aliens cleared only {where}", f"more aliens cleared {where}")
    assert told.kinds == (FORMATION,)


@pytest.mark.parametrize(
    ("aspect", "weights", "where"),
    [
        ("gone x", [0, 0, 1, 0, 0], "in column 3 of 5 from the left"),
        ("gone x", [-0.1, 0.2, 1, 0, 0], "in column 3 of 5 from the left"),
        ("gone x", [0, 0, 0, 1, 1], "in columns 4 to 5 of 5 from the left"),
        ("gone x", [5, 4, 3, 2, 1], "towards the left"),
        ("gone y", [0, 0, 1], "in row 1 of 3 from the bottom"),
        ("gone y", [1, 1, 0], "in rows 2 to 3 of 3 from the bottom"),
        ("gone y", [1, 2, 3], "towards the bottom"),
    ],
)
def test_a_part_of_a_formation_is_told_by_its_lines(
    words: Vocabulary, aspect: Aspect, weights: list[float], where: str
) -> None:
    group = next(g for g in words.groups if (g.source, g.aspect) == ("formation", aspect))
    game = game_named("space_invaders")
    told = phrase(words, group, np.array(weights, np.float64), game)
    assert told.text == f"more aliens cleared {where}"
    assert kinds_about(words, [subject_of(words, group)]) == (FORMATION,)
    pong = game_named("pong")
    assert kind_name(words, FORMATION, pong) == "things in formation"
    named = words.with_names({"formation": "the ships"})
    assert one_name(named, FORMATION, pong) == "the nearest of the ships"


def test_what_is_cleared_only_in_a_part_is_told_so(words: Vocabulary) -> None:
    game = game_named("space_invaders")
    group = next(g for g in words.groups if (g.source, g.aspect) == ("formation", "gone x"))
    texts = [
        ([-1, 1, -1, -1, -1], "aliens cleared only in column 2 of 5 from the left"),
        ([-1, 1, 1, 1, 1], "aliens cleared only in columns 2 to 5 of 5 from the left"),
        ([3.2, -5.5, 2.0, 3.7, 4.0], "fewer aliens cleared in column 2 of 5 from the left"),
        ([0, 0, 0, -1, 0], "fewer aliens cleared in column 4 of 5 from the left"),
        ([-1, 1, -0.1, -0.1, 0], "more aliens cleared in column 2 of 5 from the left"),
    ]
    for weights, text in texts:
        assert phrase(words, group, np.array(weights, np.float64), game).text == text


@pytest.mark.parametrize(
    ("aspect", "weights", "way"),
    [
        ("order x", [1, 0], "from left to right"),
        ("order x", [-1, 0], "from right to left"),
        ("order y", [0.2, 1], "from bottom to top"),
        ("order y", [1, -0.5], "from top to bottom"),
    ],
)
def test_the_order_of_clearing_is_told(
    words: Vocabulary, aspect: Aspect, weights: list[float], way: str
) -> None:
    group = next(g for g in words.groups if (g.source, g.aspect) == ("formation", aspect))
    told = phrase(words, group, np.array(weights, np.float64), game_named("space_invaders"))
    assert told.text == f"aliens cleared {way}"


def test_the_items_of_a_formation_count_in_order_along_their_lines(words: Vocabulary) -> None:
    formation = words.scene.formation
    assert formation is not None
    # The four leftmost of the lowest row, of five, and two of the last column, from the top.
    order = [10, 11, 12, 13, 4, 9]
    facts = words.facts(walking(3, order, formation))
    for aspect, expected in (("order x", [2, 0]), ("order y", [1, 0])):
        index = next(
            i for i, g in enumerate(words.groups) if (g.source, g.aspect) == ("formation", aspect)
        )
        shares = facts[60, words.columns[index]]
        assert np.allclose(N_ITEMS * shares, expected)


def test_a_formation_can_be_pointed_at(words: Vocabulary) -> None:
    formation = words.scene.formation
    assert formation is not None
    things = things_of(walking(3, [4], formation), words)
    items = things[things["kind"] == FORMATION]
    assert (items["step"] == 0).sum() == N_ITEMS
    assert (items["step"] == 50).sum() == N_ITEMS - 1
    first = items[items["step"] == 0][0]
    assert (first["left"], first["top"], first["width"]) == (LEFT, TOP + 2, 8)
    sentences = [
        one.sentence
        for one in meanings_of(words, game_named("space_invaders"))
        if one.kind == FORMATION
    ]
    assert sentences[:5] == [
        "more or fewer aliens cleared",
        "aliens cleared further to the left or right",
        "aliens cleared from left to right or from right to left",
        "aliens cleared higher up or lower down",
        "aliens cleared from top to bottom or from bottom to top",
    ]
    assert "what you steer in line with the nearest of the aliens or not" in sentences


def test_a_vocabulary_with_a_formation_is_read_as_it_was_written(
    words: Vocabulary, tmp_path: Path
) -> None:
    path = tmp_path / "words.npz"
    words.save(path)
    again = Vocabulary.load(path)
    assert again.scene.formation is not None
    assert words.scene.formation is not None
    assert np.array_equal(again.scene.formation.items, words.scene.formation.items)
    game = walking(3, [1, 2], again.scene.formation)
    assert np.array_equal(again.facts(game), words.facts(game))


def test_a_picture_shows_the_formation(words: Vocabulary) -> None:
    pong = game_named("pong")
    console = pong.make_console()
    recording = play_randomly(np.random.default_rng(0), console).recording
    png = pictures_of(words, [recording], console)[FORMATION]
    console.close()
    with Image.open(io.BytesIO(png)) as picture:
        assert picture.size == (72, 38)


@pytest.mark.parametrize("n_steps", [0, 1, 5])
def test_a_game_that_ends_at_once_has_a_formation(formation: Formation, n_steps: int) -> None:
    follower = Follower(formation)
    for screen in screens([], n_steps):
        follower.look(screen)
    followed = follower.followed
    assert followed.missing.shape == (n_steps, N_ITEMS)
    assert gone_items(followed).is_gone.shape == (n_steps, N_ITEMS)
    assert followed.offset_to_nearest(*np.zeros((2, n_steps), np.float32))[0].shape == (n_steps,)


def test_aliens_that_are_hit_are_those_that_the_memory_tells(tmp_path: Path) -> None:
    game = game_named("space_invaders")
    scene = vocabulary_of(tmp_path, game).scene
    assert scene.formation is not None
    assert scene.formation.n_items == 36
    console = game.make_console()
    n_gone: list[int] = []
    n_hit: list[int] = []
    for seed in range(6):
        recording = play_randomly(np.random.default_rng(seed), console).recording
        seen = trace(recording, console, scene)
        if seen.n_steps < 40:
            continue
        assert seen.followed is not None
        # 17: aliens that are left; some steps before the end, since what is gone lasts.
        n_hit.append(36 - int(seen.memory[-9, 17]))
        n_gone.append(int(gone_items(seen.followed).is_gone[-9].sum()))
    console.close()
    assert sum(n_hit) > 5
    assert np.abs(np.subtract(n_gone, n_hit)).max() <= 1

"""Pieces of a still picture that is drawn here: dots, which games clear from the left or right."""

from __future__ import annotations

import io
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from tests.tril.vocabulary.test_facts import BUTTONS, HORIZON, played
from tril.demonstrators.random_play import play_randomly
from tril.games import game_named
from tril.vocabulary.answers import kinds_about, subject_of
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.groups import Aspect, Group
from tril.vocabulary.names import kind_name
from tril.vocabulary.pictures import SIZE_PX, pictures_of
from tril.vocabulary.pieces import PIECES, Areas, find_pieces, gone_pieces
from tril.vocabulary.pointing import meanings_of
from tril.vocabulary.sentences import phrase, tell
from tril.vocabulary.trace import Scene, Trace, sampled
from tril.vocabulary.understanding import understand
from tril.vocabulary.watched import things_of

DOT = 0x48
N_DOTS = 12
LEFTS = [10 + 12 * number for number in range(N_DOTS)]
TOP = 100


def beginning() -> npt.NDArray[np.uint8]:
    """Return a black screen with a row of dots, and a wall of their colour."""
    screen = np.zeros((210, 160), np.uint8)
    for left in LEFTS:
        screen[TOP : TOP + 2, left : left + 4] = DOT
    screen[150:154, 10:150] = DOT
    return screen


SCENE = Scene(beginning(), beginning())


def clearing(seed: int, order: list[int], *, passing: bool = False) -> Trace:
    """Return a game in which a dot is cleared every eight steps.

    Args:
        seed: Of what else happens in it.
        order: The dots that are cleared.
        passing: Whether something stands before the last dot for three steps now and then.
    """
    game = played(seed)
    screen = beginning()
    changed = []
    for step in range(HORIZON):
        if step % 8 == 4 and step // 8 < len(order):
            left = LEFTS[order[step // 8]]
            screen[TOP : TOP + 2, left : left + 4] = 0
        shown = screen.copy()
        if passing and step % 20 < 3:
            shown[TOP - 4 : TOP + 6, LEFTS[-1] : LEFTS[-1] + 4] = 0x20
        changed.append(np.packbits(sampled(shown) != sampled(SCENE.beginning)))
    return replace(game, packed_changed=np.stack(changed))


@pytest.fixture(scope="module")
def words() -> Vocabulary:
    rng = np.random.default_rng(0)
    # The last dot is never reached.
    games = [
        clearing(seed, rng.permutation(N_DOTS - 1)[:5].tolist(), passing=True) for seed in range(20)
    ]
    return Vocabulary.of_games(games, SCENE, BUTTONS, HORIZON)


def test_cleared_areas_and_those_alike_are_pieces(words: Vocabulary) -> None:
    assert words.pieces is not None
    expected = np.zeros((210, 160), np.bool_)
    for left in LEFTS:
        expected[TOP : TOP + 2, left : left + 4] = True
    assert np.array_equal(words.pieces, expected)


def test_a_passing_thing_clears_nothing(words: Vocabulary) -> None:
    assert words.pieces is not None
    gone = gone_pieces(clearing(3, [], passing=True), words.pieces)
    assert not gone.is_gone.any()


def test_games_without_pieces_have_no_groups_about_them() -> None:
    words = Vocabulary.of_games([played(seed) for seed in range(20)], SCENE, BUTTONS, HORIZON)
    assert words.pieces is None
    assert not [group for group in words.groups if group.source == "pieces"]


@pytest.mark.parametrize("side", ["left", "right"])
def test_an_order_by_where_dots_are_cleared_is_told(words: Vocabulary, side: str) -> None:
    # As many are cleared in each game; the better ones clear more of them on one side, but for
    # the outermost, so that it is not the order in which they are cleared.
    orders = [[*range(1, n + 1), *range(N_DOTS - 6 + n, N_DOTS - 1)] for n in range(6)]
    if side == "left":
        orders.reverse()
    games = [clearing(100 + place, order) for place, order in enumerate(orders)]
    games += [clearing(200 + place, order) for place, order in enumerate(orders)]
    tiers = [[place, place + 6] for place in range(6)]
    summaries = np.stack([words.summary(words.facts(game)) for game in games])
    understood = understand(words, summaries, tiers)
    told = tell(words, understood.posterior, game_named("pong"))[0]
    assert told.sentence.startswith("more ")
    assert " cleared " in told.sentence
    other = {"left": "right", "right": "left"}[side]
    ways = (f"on the {side}", f"towards the {side}", f"anywhere but on the {other}")
    assert any(f" cleared {way}" in told.sentence for way in ways)
    assert told.kinds == (PIECES,)


def test_pieces_count_as_cleared_in_order_after_the_first_quarter_of_a_line(
    words: Vocabulary,
) -> None:
    assert words.pieces is not None
    gone = gone_pieces(clearing(3, [0, 2, 4, 1, 3, 11]), words.pieces)
    of_rows = gone.facts(Group("pieces", (), "order x"))
    # Of twelve, after each dot; three of each side do not count.
    assert np.allclose(12 * of_rows[7:48:8, 0], [0, 0, 0, 0, 2, 2])
    assert not of_rows[:, 1].any()


@pytest.mark.parametrize(("sign", "way"), [(1, "from left to right"), (-1, "from right to left")])
def test_the_direction_of_clearing_dots_is_told(words: Vocabulary, sign: int, way: str) -> None:
    rng = np.random.default_rng(1)
    # Two games a tier, from strictly in order to nearly any.
    noise = np.repeat(np.arange(6) * 1.5, 2)
    games = [
        clearing(
            100 + place,
            np.argsort(sign * np.arange(N_DOTS) + rng.normal(0, 1, N_DOTS) * spread).tolist()[:7],
        )
        for place, spread in enumerate(noise)
    ]
    tiers = [[2 * place, 2 * place + 1] for place in range(6)]
    summaries = np.stack([words.summary(words.facts(game)) for game in games])
    understood = understand(words, summaries, tiers)
    told = tell(words, understood.posterior, game_named("pong"))
    name = kind_name(words, PIECES, game_named("pong"))
    assert f"{name} cleared {way}" in [one.sentence for one in told[:2]]


def test_a_vocabulary_with_pieces_is_read_as_it_was_written(
    words: Vocabulary, tmp_path: Path
) -> None:
    path = tmp_path / "words.npz"
    words.save(path)
    again = Vocabulary.load(path)
    game = clearing(3, [1, 2])
    assert np.array_equal(again.facts(game), words.facts(game))
    assert np.array_equal(again.scene.beginning, SCENE.beginning)


def test_pieces_are_told_in_every_way(words: Vocabulary) -> None:
    pong = game_named("pong")
    name = kind_name(words, PIECES, pong)
    aspects: dict[Aspect, tuple[list[float], str]] = {
        "gone": ([1, 0], f"more {name} cleared"),
        "gone x": ([1, 0, 0, 0, 0, 0], f"more {name} cleared on the left (within "),
        "order x": ([1, -0.5], f"{name} cleared from left to right"),
    }
    for aspect, (weights, text) in aspects.items():
        group = next(g for g in words.groups if (g.source, g.aspect) == ("pieces", aspect))
        assert phrase(words, group, np.array(weights), pong).text.startswith(text)
        assert kinds_about(words, [subject_of(words, group)]) == (PIECES,)
    sentences = [one.sentence for one in meanings_of(words, pong) if one.kind == PIECES]
    assert sentences == [
        f"more or fewer {name} cleared",
        f"{name} cleared further to the left or right",
        f"{name} cleared from left to right or from right to left",
    ]


@pytest.mark.parametrize(
    ("aspect", "edges", "weights", "where"),
    [
        ("gone x", (60.0, 120.0), [1, 0, 0], "on the left (within 60 px of the edge)"),
        ("gone x", (60.0, 120.0), [0, 0, 1], "on the right (within 40 px of the edge)"),
        (
            "gone x",
            (60.0, 120.0),
            [1, 1, 0],
            "anywhere but on the right (within 40 px of the edge)",
        ),
        ("gone x", (60.0, 120.0), [0, 1, 1], "anywhere but on the left (within 60 px of the edge)"),
        ("gone x", (60.0, 120.0), [0, 1, 0], "in the middle (60 to 120 px from the left)"),
        ("gone x", (10.0, 40.0), [0, 1, 0], "10 to 40 px from the left"),
        ("gone x", (60.0, 120.0), [0, 1, 2], "towards the right"),
        ("gone y", (60.0, 120.0), [1, 0, 0], "at the top (within 60 px of the edge)"),
        ("gone y", (60.0, 120.0), [0, 0, 1], "at the bottom (within 90 px of the edge)"),
        ("gone y", (60.0, 120.0), [0, 1, 0], "in the middle (60 to 120 px from the top)"),
        ("gone y", (60.0, 120.0), [2, 1, 0], "towards the top"),
    ],
)
def test_a_part_of_the_screen_is_told_by_its_side(
    words: Vocabulary, aspect: Aspect, edges: tuple[float, ...], weights: list[float], where: str
) -> None:
    pong = game_named("pong")
    group = Group("pieces", (), aspect, edges)
    told = phrase(words, group, np.array(weights, np.float64), pong)
    assert told.text == f"more {kind_name(words, PIECES, pong)} cleared {where}"


def test_pieces_have_the_name_that_the_game_gives_them(words: Vocabulary) -> None:
    assert kind_name(words, PIECES, game_named("pong")) == "orange pieces"
    assert kind_name(words, PIECES, game_named("ms_pacman")) == "dots"
    assert kind_name(words, PIECES, game_named("breakout")) == "bricks"


def test_a_counter_of_cleared_dots_is_told_by_them() -> None:
    games = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        game = clearing(seed, rng.permutation(N_DOTS)[: rng.integers(3, 9)].tolist())
        n_gone = (game.changed.sum(1) / 2).round().astype(np.uint8)
        game.memory[:, 6] = n_gone
        games.append(game)
    words = Vocabulary.of_games(games, SCENE, BUTTONS, HORIZON)
    about = ("memory", (6,), "changes")
    counter = next(g for g in words.groups if (g.source, g.subject, g.aspect) == about)
    told = phrase(words, counter, np.array([1.0, 0.0, 0.0]), game_named("pong"))
    assert told.text.endswith("cleared more often")
    assert told.kind == PIECES


def test_pieces_can_be_pointed_at_while_they_are_there(words: Vocabulary) -> None:
    things = things_of(clearing(3, [4]), words)
    pieces = things[things["kind"] == PIECES]
    assert np.array_equal(np.unique(pieces["left"]), LEFTS)
    after = pieces[pieces["step"] == 50]
    assert set(LEFTS) - set(after["left"].tolist()) == {LEFTS[4]}
    assert set(after["width"].tolist()) == {4}


def test_a_picture_shows_where_the_pieces_are(words: Vocabulary) -> None:
    pong = game_named("pong")
    console = pong.make_console()
    recording = play_randomly(np.random.default_rng(0), console).recording
    png = pictures_of(words, [recording], console)[PIECES]
    console.close()
    with Image.open(io.BytesIO(png)) as picture:
        # As high as a picture of a thing: the page would enlarge two lines to a single dot.
        assert picture.size == (LEFTS[-1] + 4 - LEFTS[0], SIZE_PX)


def test_a_large_screen_with_many_areas_takes_little_memory() -> None:
    # A texture of 3,750 areas, of which the upper ones are cleared.
    tiles = np.random.default_rng(0).integers(1, 200, (50, 75))
    screen = np.kron(tiles, np.ones((8, 8))).astype(np.uint8)
    small = sampled(screen)
    changed = np.zeros((40, *small.shape), np.bool_)
    changed[15:, :20] = True
    packed = np.packbits(changed.reshape(40, -1), axis=1)
    games = [replace(played(0, 40), packed_changed=packed, n_cells=small.size)] * 2
    tracemalloc.start()
    try:
        assert find_pieces(games, screen) is None
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 50_000_000


def test_an_area_is_there_until_all_of_it_is_gone() -> None:
    pieces = np.zeros((210, 160), np.bool_)
    # The third is one pixel that the sampled screen leaves out.
    pieces[10:14, 20:28] = pieces[10:14, 40:44] = pieces[31, 61] = True
    areas = Areas.of(pieces)
    is_gone = np.zeros((3, len(areas.of_cell)), np.bool_)
    first, second, _ = range(3)
    is_gone[1, np.flatnonzero(areas.of_cell == first)[0]] = True
    is_gone[2] = areas.of_cell == second
    assert areas.are_there(is_gone).tolist() == [[True, True, False]] * 2 + [[True, False, False]]
    assert areas.are_there(is_gone[:0]).shape == (0, 3)


@pytest.mark.parametrize("n_steps", [0, 1, 5, 14])
def test_a_game_that_ends_at_once_has_facts_and_pieces(words: Vocabulary, n_steps: int) -> None:
    whole = clearing(3, [0])
    short = replace(
        whole,
        memory=whole.memory[:n_steps],
        held=whole.held[:n_steps],
        blobs=whole.blobs[whole.blobs["step"] < n_steps],
        packed_changed=whole.packed_changed[:n_steps],
    )
    facts = words.facts(short)
    assert facts.shape == (n_steps, words.n_facts)
    assert np.isfinite(facts).all()
    pieces = things_of(short, words)
    assert (pieces["kind"] == PIECES).sum() == n_steps * N_DOTS - max(n_steps - 4, 0)
    assert find_pieces([short] * 3, SCENE.beginning) is None


def test_walls_missing_from_some_games_are_no_pieces() -> None:
    games = []
    for seed in range(20):
        # Walls that stand elsewhere in a third of the games, from their first step on.
        changed = (
            clearing(seed, []).changed.reshape(HORIZON, *sampled(SCENE.beginning).shape).copy()
        )
        if seed % 3 == 0:
            changed[:, 40:60, 20:40] = True
        packed = np.packbits(changed.reshape(HORIZON, -1), axis=1)
        games.append(replace(clearing(seed, []), packed_changed=packed))
    screen = SCENE.beginning.copy()
    screen[80:120, 40:80] = 0x20
    assert find_pieces(games, screen) is None

"""Vocabularies of games that are drawn here: a thing that is steered, one that is not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tril.errors import Invalid
from tril.games import game_named
from tril.games.things import Axis, Thing
from tril.vocabulary.blobs import BLOB_DTYPE, Background, Blobs, box_of, find_blobs
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.groups import Aspect, Group
from tril.vocabulary.names import colour_name, kind_name
from tril.vocabulary.sentences import phrase, tell
from tril.vocabulary.trace import Scene, Trace, sampled
from tril.vocabulary.understanding import shuffles_as_good, understand

HORIZON = 100
LEFT, RIGHT = 1, 2
BUTTONS = ("left", "right")
STEERED, FREE = 40, 80
"""Colours."""
SCENE = Scene(np.zeros((210, 160), np.uint8), np.zeros((210, 160), np.uint8))
N_CELLS = sampled(SCENE.beginning).size


def set_boxes(blobs: Blobs) -> None:
    """Put the boxes of blobs around their centres."""
    for edge, centre, size in (("left", "x", "width"), ("top", "y", "height")):
        blobs[edge] = np.rint(blobs[centre] - (blobs[size] - 1) / 2)


def played(seed: int, n_steps: int = HORIZON, centre: float | None = None) -> Trace:
    """Return a game of a steered thing, whose x is byte 3, and one that wanders by itself."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(30, 130) if centre is None else centre
    other = rng.uniform(30, 130)
    memory = np.zeros((n_steps, 8), np.uint8)
    held = np.zeros(n_steps, np.int64)
    blobs = np.zeros(2 * n_steps, BLOB_DTYPE)
    for step in range(n_steps):
        if centre is None:
            held[step] = rng.choice([0, LEFT, RIGHT])
        else:
            held[step] = LEFT if x > centre else RIGHT
        x = np.clip(x + (held[step] == RIGHT) * 4 - (held[step] == LEFT) * 4, 5, 155)
        other = np.clip(other + rng.normal() * 3, 5, 155)
        memory[step, 3] = int(x)
        memory[step, 5] = rng.integers(0, 4)
        blobs[2 * step] = (step, STEERED, x, 180, 0, 0, 8, 6, 48)
        blobs[2 * step + 1] = (step, FREE, other, 60, 0, 0, 4, 4, 16)
    set_boxes(blobs)
    unchanged = np.zeros((n_steps, N_CELLS // 8), np.uint8)
    return Trace(memory, held, blobs, unchanged, N_CELLS)


def test_the_thing_that_answers_the_buttons_is_the_players(words: Vocabulary) -> None:
    assert {kind.looks[0].colour for kind in words.kinds} == {STEERED, FREE}
    assert words.player is not None
    assert words.kinds[words.player].looks[0].colour == STEERED


def test_bytes_that_never_change_say_nothing_and_one_follows_the_thing(words: Vocabulary) -> None:
    values = {g.subject[0]: g for g in words.groups if (g.source, g.aspect) == ("memory", "value")}
    assert values.keys() == {3, 5}
    twin = values[3].twin
    assert twin is not None
    assert (twin.kind, twin.axis) == (words.player, "x")
    assert twin.places(np.array([100], np.uint8)) == pytest.approx(100, abs=2)
    assert twin.direction == 1
    assert values[5].twin is None


def test_facts_are_shares_of_a_whole_game_so_that_a_short_one_forfeits(words: Vocabulary) -> None:
    whole, half = played(50), played(50, HORIZON // 2)
    facts = words.facts(whole)
    assert facts.shape == (HORIZON, words.n_facts)
    assert facts.min() >= 0
    assert facts.max() <= 1
    for group, columns in zip(words.groups, words.columns, strict=True):
        if group.aspect in ("x", "y", "value") and group.source != "button":
            assert facts[:, columns].sum(1) == pytest.approx(1)
    assert words.summary(words.facts(half)).sum() < 0.6 * words.summary(facts).sum()


def test_an_order_by_place_is_understood_and_told(words: Vocabulary) -> None:
    games = [played(100 + place, centre=11.0 * place + 12) for place in range(12)]
    summaries = np.stack([words.summary(words.facts(one)) for one in games])
    understood = understand(words, summaries, [[place] for place in range(12)])
    assert shuffles_as_good(words, summaries, [[place] for place in range(12)]) == 0
    values = understood.value(summaries)
    assert np.corrcoef(values, -np.arange(12))[0, 1] > 0.8
    told = tell(words, understood.posterior, game_named("pong"))
    assert "left" in told[0].sentence
    assert "what you steer" in told[0].sentence
    assert sum(one.probability for one in told) <= 1.0001


def test_best_efforts_are_better_than_the_worse_half_of_an_order(words: Vocabulary) -> None:
    # The better half is further to the left and lasts longer; the best efforts last shortest.
    better = [played(100 + place, 90 - 5 * place, centre=30.0) for place in range(3)]
    worse = [played(110 + place, 60 - 5 * place, centre=120.0) for place in range(3)]
    best = [played(120 + place, 45, centre=30.0) for place in range(3)]
    summaries = np.stack([words.summary(words.facts(one)) for one in (*better, *worse, *best)])
    tiers = [[place] for place in range(6)]

    def share_left(rows: list[int]) -> float:
        """Return the probability of what the first sentence about the left has."""
        told = tell(words, understand(words, summaries, tiers, rows).posterior, game_named("pong"))
        return sum(one.probability for one in told if "left" in one.sentence)

    assert share_left([6, 7, 8]) > share_left([])
    # Of a ranked one the order says what it is better than, and equals may change places.
    plain = understand(words, summaries, [[0], [1, 2], [3]])
    for order in ([[0], [1, 2], [3]], [[0], [2, 1], [3]]):
        starred = understand(words, summaries, order, best=[0, 3])
        assert starred.value(summaries) == pytest.approx(plain.value(summaries))


def test_few_orders_that_are_drawn_blindly_surpass_chance(words: Vocabulary) -> None:
    games = [played(100 + place, centre=18.0 * place + 12) for place in range(8)]
    summaries = np.stack([words.summary(words.facts(one)) for one in games])
    rng = np.random.default_rng(1)
    orders = [[[int(row)] for row in rng.permutation(6)] for _ in range(24)]
    # Best efforts that show something lend no sense to an order of other games.
    assert sum(not shuffles_as_good(words, summaries, one, best=[6, 7]) for one in orders) <= 4


def test_an_order_of_three_games_is_never_sure(words: Vocabulary) -> None:
    games = [played(100 + place, centre=50.0 * place + 12) for place in range(3)]
    summaries = np.stack([words.summary(words.facts(one)) for one in games])
    assert shuffles_as_good(words, summaries, [[0], [1], [2]])


def test_the_same_order_turned_round_is_told_the_other_way(words: Vocabulary) -> None:
    games = [played(100 + place, centre=18.0 * place + 12) for place in range(8)]
    summaries = np.stack([words.summary(words.facts(one)) for one in games])
    understood = understand(words, summaries, [[place] for place in reversed(range(8))])
    assert "right" in tell(words, understood.posterior, game_named("pong"))[0].sentence


def test_an_order_of_one_tier_is_refused(words: Vocabulary) -> None:
    with pytest.raises(Invalid, match="two tiers"):
        understand(words, words.pool, [[0, 1, 2]])


def test_a_vocabulary_is_read_as_it_was_written(words: Vocabulary, tmp_path: Path) -> None:
    path = tmp_path / "words.npz"
    words.save(path)
    again = Vocabulary.load(path)
    assert (again.horizon, again.kinds, again.player, again.groups) == (
        words.horizon,
        words.kinds,
        words.player,
        words.groups,
    )
    assert np.array_equal(again.pool, words.pool)
    assert np.array_equal(again.facts(played(3)), words.facts(played(3)))


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 nothing", b"text"])
def test_a_file_that_is_no_vocabulary_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "words.npz"
    path.write_bytes(content)
    with pytest.raises(Invalid, match=r"words\.npz"):
        Vocabulary.load(path)


def test_a_file_with_flipped_bits_is_read_or_refused(words: Vocabulary, tmp_path: Path) -> None:
    path = tmp_path / "words.npz"
    words.save(path)
    whole = path.read_bytes()
    n_refused = 0
    for at in np.linspace(0, len(whole) - 1, 200).astype(int):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :])
        try:
            Vocabulary.load(path)
        except Invalid:
            n_refused += 1
    assert n_refused > 100


def test_every_group_has_a_phrase_either_way(words: Vocabulary) -> None:
    game = game_named("pong")
    for group in words.groups:
        weights = np.linspace(-1, 2, group.n_facts)
        phrases = {phrase(words, group, sign * weights, game).text for sign in (1, -1)}
        assert len(phrases) == 2 or group.aspect in ("bits", "moves")
        assert all(text and "None" not in text for text in phrases)


def test_a_button_that_is_held_longer_and_pressed_less_often_is_held_more(
    words: Vocabulary,
) -> None:
    index = words.groups.index(Group("button", (0,), "held"))
    held, pressed = words.pool[:, words.columns[index]].std(0)
    game = game_named("pong")

    def told(by_held: float, by_pressed: float) -> str:
        """Return what weights say that move a varied game by so much."""
        weights = np.array([by_held / held, by_pressed / pressed])
        return phrase(words, words.groups[index], weights, game).text

    # A press is rare, so that its weight is the larger one by far.
    assert told(0.5, -0.4) == "holding down more"
    assert told(-0.5, 0.4) == "holding down less"
    assert told(0.4, -0.5) == "pressing down less often"


@pytest.mark.parametrize(
    ("best", "aspect", "text"),
    [
        (0, "dx", "more than 20 px to the left of"),
        (1, "dx", "12 to 20 px to the left of"),
        (2, "dy", "between 12 px above and 8 px below"),
        (3, "dy", "8 to 30 px below"),
        (4, "dx", "more than 30 px to the right of"),
    ],
)
def test_where_a_thing_is_as_seen_from_the_players(
    words: Vocabulary, best: int, aspect: Aspect, text: str
) -> None:
    assert words.player is not None
    other = 1 - words.player
    group = Group("thing", (words.player, other), aspect, (-20.0, -12.0, 8.0, 30.0))
    # Neither rising nor falling: high in one bin, and low at both ends.
    weights = np.array([0.0, 0.1, 0.2, 0.1, 0.0])
    weights[best] = 2.0
    told = phrase(words, group, weights, game_named("pong")).text
    assert text in told
    assert told.endswith("what you steer")


def test_blobs_are_areas_of_one_colour_in_front_of_the_background() -> None:
    background = Background((50, 60))
    screen = np.full((50, 60), 7, np.uint8)
    for _ in range(5):
        background.add(screen)
    shown = screen.copy()
    shown[10:14, 20:26] = 100
    shown[30:38, 5:7] = 100
    shown[40, 40] = 50  # a pixel is no thing
    found = find_blobs(shown, background.mode())
    boxes = {(b["colour"], b["x"], b["y"], b["width"], b["height"], b["area"]) for b in found}
    assert boxes == {(100, 22.5, 11.5, 6, 4, 24), (100, 5.5, 33.5, 2, 8, 16)}


def test_the_box_of_a_thing_that_is_heavier_on_one_side_is_where_it_is() -> None:
    screen = np.zeros((210, 160), np.uint8)
    screen[20:100, 30:36] = 7
    screen[94:100, 30:70] = 7
    blobs = find_blobs(screen, np.zeros_like(screen))
    left, top = box_of(blobs)
    assert (left.tolist(), top.tolist()) == ([30], [20])
    assert (blobs["width"].tolist(), blobs["height"].tolist()) == ([40], [80])


def test_games_over_within_their_first_step_have_no_first_step() -> None:
    games = [*(played(seed) for seed in range(20)), played(20, n_steps=0)]
    assert Vocabulary.of_games(games, SCENE, BUTTONS, HORIZON).player is not None


def test_colours_have_names() -> None:
    assert colour_name(np.array([200.0, 60, 60])) == "red"
    assert colour_name(np.array([0.0, 0, 0])) == "black"


def test_a_byte_that_tells_a_place_by_a_table_is_that_place() -> None:
    # As a 2600 keeps places: steps of 15 px in the low nibble, single px in the high one.
    games = []
    for seed in range(20):
        game = played(seed)
        x = game.memory[:, 3].astype(int)
        game.memory[:, 3] = (x // 15) | (x % 15) << 4
        games.append(game)
    words = Vocabulary.of_games(games, SCENE, BUTTONS, HORIZON)
    group, *others = [g for g in words.groups if g.source == "memory" and g.subject == (3,)]
    # Its rises and falls and its bits mean nothing to anybody.
    assert others == []
    assert group.twin is not None
    assert (group.twin.kind, group.twin.axis, group.twin.direction) == (words.player, "x", 0)
    value = np.array([(100 // 15) | (100 % 15) << 4], np.uint8)
    assert group.twin.places(value) == pytest.approx(100, abs=2)
    weights = np.linspace(-1, 1, group.n_facts)
    told = phrase(words, group, weights, game_named("pong"))
    assert told.text == "what you steer further to the right"
    assert told.detail.startswith("memory 3")


def with_light(seed: int, *, sure: float) -> Trace:
    """Return a game in which a lamp is there while byte 6 is 9, or mostly; byte 7 flickers."""
    game = played(seed)
    rng = np.random.default_rng([seed, 1])
    is_on = np.repeat(rng.integers(0, 2, HORIZON // 10), 10).astype(bool)
    says = np.where(rng.random(HORIZON) < sure, is_on, rng.random(HORIZON) < 0.5)
    game.memory[:, 6] = np.where(says, 9, 2)
    game.memory[:, 7] = rng.integers(0, 2, HORIZON)
    lamps = np.zeros(int(is_on.sum()), BLOB_DTYPE)
    lamps["step"] = np.flatnonzero(is_on)
    lamps["colour"], lamps["x"], lamps["y"] = 120, 20, 20
    lamps["width"], lamps["height"], lamps["area"] = 6, 6, 36
    set_boxes(lamps)
    blobs = np.concatenate([game.blobs, lamps])
    blobs = blobs[np.argsort(blobs["step"], kind="stable")]
    return replace(game, blobs=blobs)


@pytest.mark.parametrize(
    ("sure", "text"),
    [
        (0.98, "the {} there more often"),
        (0.6, "something that happens more often, mostly while the {} is there"),
    ],
)
def test_a_byte_is_told_by_what_is_seen_with_it(sure: float, text: str) -> None:
    games = [with_light(seed, sure=sure) for seed in range(20)]
    words = Vocabulary.of_games(games, SCENE, BUTTONS, HORIZON)
    pong = game_named("pong")
    lamp = next(i for i, kind in enumerate(words.kinds) if kind.looks[0].colour == 120)
    group = next(
        g for g in words.groups if (g.source, g.subject, g.aspect) == ("memory", (6,), "value")
    )
    told = phrase(words, group, np.array([-1.0, 1.0]), pong)
    assert told.text == text.format(kind_name(words, lamp, pong).removeprefix("the "))
    assert told.kind == lamp
    assert told.detail == "memory 6 larger"
    # What nothing goes with does not begin with a number either.
    unseen = next(g for g in words.groups if g.source == "memory" and g.subject == (7,))
    told = phrase(words, unseen, np.linspace(-1, 1, unseen.n_facts), pong)
    assert told.text.startswith("something that the screen does not show")
    assert "memory" not in told.text
    assert "memory 7" in told.detail


def test_one_thing_at_several_sizes_and_in_several_colours_is_one_kind() -> None:
    games = []
    for seed in range(20):
        game = played(seed)
        steered = game.blobs["colour"] == STEERED
        # It is cut at the left, and another colour at the right.
        game.blobs["width"][steered & (game.blobs["x"] < 60)] = 3
        set_boxes(game.blobs)
        game.blobs["colour"][steered & (game.blobs["x"] > 100)] = STEERED + 1
        games.append(game)
    words = Vocabulary.of_games(games, SCENE, BUTTONS, HORIZON)
    assert len(words.kinds) == 2
    assert words.player is not None
    looks = words.kinds[words.player].looks
    assert {(look.colour, look.width[0]) for look in looks} == {
        (STEERED, 8),
        (STEERED, 3),
        (STEERED + 1, 8),
    }


def test_a_thing_that_is_drawn_in_two_parts_is_what_you_steer() -> None:
    games = []
    for seed in range(20):
        game = played(seed)
        feet = game.blobs[game.blobs["colour"] == STEERED].copy()
        feet["x"] += 12
        set_boxes(feet)
        blobs = np.concatenate([game.blobs, feet])
        blobs = blobs[np.argsort(blobs["step"], kind="stable")]
        games.append(replace(game, blobs=blobs))
    words = Vocabulary.of_games(games, SCENE, BUTTONS, HORIZON)
    assert words.player is not None
    assert words.kinds[words.player].looks[0].colour == STEERED


def test_scenery_that_moves_against_the_buttons_is_not_steered() -> None:
    games = [played(seed) for seed in range(20)]
    # Where the screen follows the player, all that stands still seems to move.
    assert Vocabulary.of_games(games, SCENE, ("right", "left"), HORIZON).player is None
    # Of a game that names its buttons otherwise nothing is known.
    words = Vocabulary.of_games(games, SCENE, ("turn", "shoot"), HORIZON)
    assert words.player is not None
    assert words.kinds[words.player].looks[0].colour == STEERED


def test_a_thing_has_the_name_that_the_game_gives_it() -> None:
    things = {
        "lamp": Thing("lamp", Axis(0, byte=3), Axis(60)),
        "far": Thing("far", Axis(9), Axis(9)),
    }
    games = [played(seed) for seed in range(20)]
    for game in games:
        game.memory[:, 3] = game.blobs["x"][game.blobs["colour"] == FREE].astype(int)
    words = Vocabulary.of_games(games, SCENE, BUTTONS, HORIZON, things)
    names = {kind.looks[0].colour: kind.name for kind in words.kinds}
    assert names == {STEERED: None, FREE: "lamp"}


def test_a_thing_with_another_colour_in_each_line_is_one() -> None:
    background = np.full((50, 60), 7, np.uint8)
    screen = background.copy()
    for row, colour in enumerate((30, 31, 32, 32, 33)):
        screen[20 + row, 10:18] = colour
    # A wave of one line is none.
    screen[40, 5:30] = 90
    found = find_blobs(screen, background)
    # Two lines of one colour are an area of their own, as before.
    boxes = {(b["colour"], b["y"], b["width"], b["height"]) for b in found}
    assert boxes == {(32, 22.5, 8, 2)}
    screen[23, 10:18] = 34
    found = find_blobs(screen, background)
    assert [(b["x"], b["y"], b["width"], b["height"]) for b in found] == [(13.5, 22, 8, 5)]

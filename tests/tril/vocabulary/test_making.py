"""Vocabularies that ship with Tril, and those that are kept in the data folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from tril.errors import Invalid
from tril.games import DEFAULT_GAME, game_named
from tril.vocabulary import facts, making
from tril.vocabulary.facts import Vocabulary

SHIPPED_FOR = (DEFAULT_GAME,)


def test_what_ships_is_of_the_games_and_the_format_of_today(tmp_path: Path) -> None:
    names = {f"{making.vocabulary_key(game_named(name))}.npz" for name in SHIPPED_FOR}
    assert {path.name for path in making.SHIPPED.glob("*.npz")} == names
    for name in SHIPPED_FOR:
        words = making.vocabulary_of(tmp_path, game_named(name))
        assert len(words.pool) == making.N_GAMES
        assert words.player is not None
    assert not list(tmp_path.iterdir())


def test_a_vocabulary_is_made_once_and_made_anew_if_it_is_damaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(making, "N_GAMES", 2)
    game = game_named("pong")
    seen: list[tuple[int, int]] = []
    made = making.vocabulary_of(tmp_path, game, lambda done, total: seen.append((done, total)))
    # Of the eight steps two are for a formation, if a game might have one.
    assert seen == [(done, 8) for done in (1, 2, 3, 4, 7, 8)]
    again = making.vocabulary_of(tmp_path, game, lambda done, total: seen.append((done, total)))
    assert again.groups == made.groups
    assert len(seen) == 6
    (path,) = (tmp_path / making.FOLDER).glob("*.npz")
    path.write_bytes(path.read_bytes()[:1000])
    assert making.vocabulary_of(tmp_path, game).groups == made.groups
    assert Vocabulary.load(path).groups == made.groups


def test_a_vocabulary_of_an_earlier_format_is_made_anew(
    words: Vocabulary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    game = game_named("pong")
    path = making.vocabulary_path(tmp_path, game)
    path.parent.mkdir()
    with monkeypatch.context() as earlier:
        earlier.setattr(facts, "FORMAT_VERSION", 3)
        words.save(path)
    with pytest.raises(Invalid, match="format 3"):
        Vocabulary.load(path)
    monkeypatch.setattr(making, "make_vocabulary", lambda *_: words)
    assert making.vocabulary_of(tmp_path, game) is words
    assert Vocabulary.load(path).groups == words.groups

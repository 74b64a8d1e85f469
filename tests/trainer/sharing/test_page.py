"""A run as one page: complete, escaped, small and alone."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import re
from html.parser import HTMLParser
from typing import Any

import pytest
from PIL import Image

from testsupport.finished_runs import make_finished_run
from testsupport.workplace import Workplace
from trainer.sharing import page as sharing
from trainer.sharing.films import DeadlinePassed, Film, film_of
from trainer.sharing.page import MAX_BYTES, Parts, SharePage, make_share_page
from tril.analysis.outcome import UnderstoodShares
from tril.analysis.summary import Interval
from tril.errors import Conflict, Invalid
from tril.files.artifact_store import ArtifactStore
from tril.games import game_of
from tril.games.measures import ActionRate, GameScore, Measure, Per
from tril.store import behaviours, recordings
from tril.store.models import Source
from tril.store.training import evaluations, runs
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.making import pictures_path, vocabulary_path
from tril.vocabulary.pictures import write_pictures

PARTS = Parts("p{margin:0}", "void 0;")
EVIL = "<script>alert(1)</script>\"'&"
PICTURE = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


class Elements(HTMLParser):
    """The elements of a page with their attributes, and the text outside of scripts."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.inline: dict[str, list[str]] = {"script": [], "style": []}
        self.words: list[str] = []
        self._within = ""
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        self._within = tag if tag in self.inline else ""
        if self._within:
            self.inline[tag].append("")

    def handle_endtag(self, tag: str) -> None:
        self._within = ""

    def handle_data(self, data: str) -> None:
        if self._within:
            self.inline[self._within][-1] += data
        else:
            self.words.append(data)

    def of(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.found if name == tag]

    @property
    def text(self) -> str:
        return " ".join("".join(self.words).split())


def made(workplace: Workplace, run_id: str) -> SharePage:
    store = ArtifactStore(workplace.settings.artifact_root)
    return make_share_page(workplace.database, store, run_id, workplace.settings.data, PARTS)


def made_within(workplace: Workplace, run_id: str, within_s: float) -> SharePage:
    store, data = ArtifactStore(workplace.settings.artifact_root), workplace.settings.data
    return make_share_page(workplace.database, store, run_id, data, PARTS, within_s)


@pytest.fixture
def run_id(workplace: Workplace) -> str:
    return make_finished_run(workplace)


def films(page: Elements) -> list[dict[str, object]]:
    scripts = zip(page.of("script"), page.inline["script"], strict=True)
    return [json.loads(text) for attributes, text in scripts if attributes.get("class") == "film"]


def test_a_page_shows_the_run_with_its_games_and_figures(workplace: Workplace, run_id: str) -> None:
    shared = made(workplace, run_id)
    page = Elements(shared.html.decode())
    assert "Column 1" in page.text
    assert "Shoot all six aliens of the leftmost column" in page.text
    assert shared.contents.verdict is not None
    assert shared.contents.verdict.sentence in page.text
    assert "Targets hit, of 6" in page.text
    assert "Agreement of R" not in page.text  # five come before
    assert [a["aria-label"] for a in page.of("canvas") if "aria-label" in a] == [
        "Game screen of Imitator",
        "Game screen of Demonstrator, best game",
    ]
    tiles = [a for a in page.of("button") if a.get("class") == "tile"]
    assert [a["data-film"] for a in tiles] == [str(number) for number in workplace.ranked]
    assert "exactly as played" in page.text
    # Each game is there once, with R for the two in step.
    numbers = [film["number"] for film in films(page)]
    assert len(numbers) == len(set(numbers)) == 5
    assert sum(film["levels"] is not None for film in films(page)) == 2
    with Image.open(io.BytesIO(shared.poster)) as poster:
        assert poster.size == (1200, 630)


def test_a_page_loads_nothing_and_allows_only_its_own_style_and_script(
    workplace: Workplace, run_id: str
) -> None:
    page = Elements(made(workplace, run_id).html.decode())
    (policy,) = [a["content"] for a in page.of("meta") if "http-equiv" in a]
    assert policy is not None
    assert policy.startswith("default-src 'none'; img-src data:; font-src data:;")
    allowed = set(re.findall(r"'sha256-([^']+)'", policy))
    styles, run = page.inline["style"], page.inline["script"][-1]
    used = {
        base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in [*styles, run]
    }
    assert used == allowed
    assert run == PARTS.script
    for _, attributes in page.found:
        assert "style" not in attributes
        assert not [name for name in attributes if name.startswith("on")]
        for name in ("src", "href"):
            assert (attributes.get(name) or "data:").startswith("data:")


def test_what_people_typed_is_text(workplace: Workplace, run_id: str) -> None:
    with workplace.database.writing() as session:
        runs.get(session, run_id).name = EVIL
        row = behaviours.get(session, workplace.behaviour_id)
        row.name, row.description = EVIL, f"{EVIL} It stays."
    page = Elements(made(workplace, run_id).html.decode())
    assert page.text.count("<script>alert(1)</script>") >= 3
    assert not [text for text in page.inline["script"] if "alert" in text]
    (title,) = [a["content"] for a in page.of("meta") if a.get("property") == "og:title"]
    assert title == f"{EVIL}, taught by ranking games"


def test_statements_have_their_shares_and_the_pictures_that_there_are(
    workplace: Workplace, run_id: str
) -> None:
    with workplace.database.writing() as session:
        row = behaviours.get(session, workplace.behaviour_id)
        game = game_of(behaviours.as_behaviour(row))
        words = Vocabulary.load(vocabulary_path(workplace.settings.data, game))
        looks = [
            f"{look.colour}:{look.width[0]}-{look.width[1]}x{look.height[0]}-{look.height[1]}"
            for look in (kind.looks[0] for kind in words.kinds)
        ]
        run = runs.get(session, run_id)
        values = run.outcome.model_dump(mode="json", exclude_unset=True)
        values["check"]["statements"] = [
            # Kinds had other numbers when it was told; its subjects name them by their looks.
            {
                "sentence": f"what you steer {EVIL}",
                "probability": 0.72,
                "kinds": [7],
                "subjects": [f"thing {looks[3]} x", f"thing {looks[9]} count"],
            },
            {"sentence": "of an earlier version", "probability": 0.1},
        ]
        run.outcome = run.outcome.model_validate(values)
    write_pictures(pictures_path(workplace.settings.data, game), {3: PICTURE})
    page = Elements(made(workplace, run_id).html.decode())
    assert f"what you steer {EVIL} 72%" in page.text
    assert "of an earlier version 10%" in page.text
    things = [a["src"] for a in page.of("img") if a.get("class") == "thing"]
    assert things == [f"data:image/png;base64,{base64.b64encode(PICTURE).decode()}"]


def test_a_run_without_targets_measures_and_demonstrations_has_a_page(
    workplace: Workplace, run_id: str
) -> None:
    with workplace.database.writing() as session:
        behaviours.get(session, workplace.behaviour_id).target = None
        run = runs.get(session, run_id)
        assert run.snapshot is not None
        run.snapshot = run.snapshot.model_copy(update={"tiers": [], "perfect": []})
        run.outcome = run.outcome.model_copy(update={"check": None})
    page = Elements(made(workplace, run_id).html.decode())
    assert "The game is shown frame by frame" in page.text
    assert "The order that it learned from" not in page.text
    assert "Death rate" in page.text
    assert len(films(page)) == 1


def test_what_was_understood_is_the_first_figure_without_measures(
    workplace: Workplace, run_id: str
) -> None:
    share = Interval(0.88, 0.8, 0.9, 20)
    with workplace.database.writing() as session:
        behaviours.get(session, workplace.behaviour_id).target = None
        run = runs.get(session, run_id)
        assert run.outcome.headline is not None
        shares = UnderstoodShares(imitator=share, clone=None, best=Interval(0.31, 0.2, 0.4, 3))
        headline = run.outcome.headline.model_copy(update={"understood": shares})
        run.outcome = run.outcome.model_copy(update={"headline": headline})
    page = Elements(made(workplace, run_id).html.decode())
    shown = "Worth by what Tril understood (100%: a full game) 88% Person 31% in the best games"
    assert shown in page.text
    assert "worth more than the best ones that it learned from: 88% against 31%" in page.text


def test_measures_are_figures_with_those_of_the_person(workplace: Workplace, run_id: str) -> None:
    measures: tuple[Measure, ...] = (
        GameScore(at_least=100),
        ActionRate(button="fire", per=Per.TIME),
    )
    with workplace.database.writing() as session:
        row = behaviours.get(session, workplace.behaviour_id)
        row.target, row.measures = None, [measure.to_json() for measure in measures]
        for shown in recordings.by_ids(session, workplace.ranked).values():
            shown.source = Source.PERSON
            shown.measured = {measures[0].key: 50.0, measures[1].key: 0.25}
        for game in evaluations.listing(session, run_id):
            game.recording.measured = {measures[0].key: 120.0, measures[1].key: 0.5}
    page = Elements(made(workplace, run_id).html.decode())
    assert "Score: at least 100 120 Clone 120 Person 50 in all ranked games" in page.text
    assert "Button fire held 50% of the time" in page.text
    assert "0 of 1 measure met" in page.text
    assert "Person, best game" in page.text


def test_a_page_that_would_be_too_large_holds_less_and_says_so(
    workplace: Workplace, run_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = made(workplace, run_id).html
    assert len(whole) <= MAX_BYTES
    sizes = []
    for share in (0.97, 0.8, 0.6, 0.45):
        limit = int(len(whole) * share)
        monkeypatch.setattr(sharing, "MAX_BYTES", limit)
        html = made(workplace, run_id).html
        assert len(html) <= limit
        sizes.append(len(html))
        text = Elements(html.decode()).text
        assert re.search("pictures a second|ranked games are shown, evenly", text), share
    assert sizes == sorted(sizes, reverse=True)


def test_only_a_finished_run_has_a_page(workplace: Workplace) -> None:
    with pytest.raises(Conflict, match="It can be taken away once it is done"):
        made(workplace, workplace.make_run())


def test_ranked_games_that_take_too_long_are_left_out_and_it_says_so(
    workplace: Workplace, run_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    replayed = 0
    make = film_of

    def slow(*arguments: Any, **options: Any) -> Film:
        nonlocal replayed
        replayed += 1
        # The two games in step, and one more.
        if replayed > 3:
            raise DeadlinePassed(0.5)
        return make(*arguments, **options)

    monkeypatch.setattr(sharing, "film_of", slow)
    page = Elements(made_within(workplace, run_id, 60).html.decode())
    tiles = [a for a in page.of("button") if a.get("class") == "tile"]
    assert 0 < len(tiles) < len(workplace.ranked)
    assert f"{len(tiles)} of {len(workplace.ranked)} ranked games are shown" in page.text
    assert "took too long to replay" in page.text


def test_where_not_even_two_games_are_done_in_time_it_names_the_way_out(
    workplace: Workplace, run_id: str
) -> None:
    with pytest.raises(Invalid, match=f"tril runs share {run_id}"):
        made_within(workplace, run_id, 1e-6)

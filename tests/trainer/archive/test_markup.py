"""Names and texts of people are text in whatever a run is written as."""

from __future__ import annotations

import csv
import io
import shlex
import zipfile
from collections.abc import Iterator
from xml.etree import ElementTree

import pytest

from testsupport.finished_runs import make_finished_run
from testsupport.workplace import Workplace, make_workplace
from trainer.archive.commands import _addition
from trainer.archive.run_archive import write_archive
from trainer.archive.tables import curves_table
from tril.files.artifact_store import ArtifactStore
from tril.games.behaviours import Behaviour
from tril.store import behaviours
from tril.store.training import metrics

NAME = r"--$\frac$ </pre><script>1</script> ```` [x](javascript:1) | {raw}`h` ¦ <"
DESCRIPTION = '# <img src=x onerror="1"> &lt; *b* $x$'
CURVE = '=HYPERLINK("http://a")'


@pytest.fixture(scope="module")
def members(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, bytes]]:
    folder = tmp_path_factory.mktemp("hostile")
    made: Workplace = make_workplace(folder / "data")
    run_id = make_finished_run(made)
    with made.database.writing() as session:
        row = behaviours.get(session, made.behaviour_id)
        behaviours.update(
            session,
            row,
            name=NAME,
            description=DESCRIPTION,
            target=behaviours.as_behaviour(row).target,
            ordered=False,
        )
        metrics.add_curves(session, run_id, [("imitator", 1_000_000, {CURVE: -1.5})])
    path = folder / "run.zip"
    store = ArtifactStore(made.settings.artifact_root)
    write_archive(made.database, store, run_id, path, lambda _: b"")
    with zipfile.ZipFile(path) as archive:
        yield {name: archive.read(name) for name in archive.namelist()}
    made.database.close()


def test_mathematics_in_a_name_is_drawn_as_text(members: dict[str, bytes]) -> None:
    for name, content in members.items():
        if name.endswith(".svg"):
            ElementTree.fromstring(content)


def test_a_formula_is_text_in_a_table(members: dict[str, bytes]) -> None:
    rows = list(csv.reader(io.StringIO(members["curves.csv"].decode())))
    (row,) = (row for row in rows if "HYPERLINK" in row[2])
    assert row[2:] == [f"'{CURVE}", "-1.5"]
    series = {"imitator": {"hits": [(1, -0.5)]}}
    assert curves_table(series).splitlines()[1] == "imitator,1,hits,-0.5"


def test_markup_is_text_in_the_report(members: dict[str, bytes]) -> None:
    page = members["report.html"].decode()
    assert "<script" not in page
    assert "<img src=x" not in page
    assert "&lt;script&gt;" in page


def test_markup_is_text_in_the_model_card(members: dict[str, bytes]) -> None:
    from markdown_it import MarkdownIt

    page = MarkdownIt("commonmark", {"html": True}).render(members["model-card.md"].decode())
    assert "<script" not in page
    assert "<img" not in page
    assert "href" not in page
    assert "<em>" not in page
    assert "&lt;script&gt;" in page
    # The fence around the commands is longer than any in a name, so the page goes on behind it.
    assert page.count("<pre>") == 1
    assert "Training it again" in page


def test_a_name_is_a_word_of_the_command_that_is_printed() -> None:
    line = _addition(Behaviour("x", NAME, "", "space_invaders", ((0, 0),), False))
    assert shlex.split(line)[-2:] == ["--", NAME]


@pytest.mark.parametrize("text", ["1. a", "12) b", "- c", "+ d", "=====", "---", "a\n# b", "    e"])
def test_a_text_at_the_beginning_of_a_line_makes_no_list_and_no_heading(text: str) -> None:
    from markdown_it import MarkdownIt

    from trainer.reporting.rendering import _plain

    page = MarkdownIt("commonmark").render(f"x\n{_plain(text)}\n")
    assert page.startswith("<p>x\n")
    assert page.count("<") == 2

"""What is in Space Invaders is known to its own folders alone; every other file is listed here."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
GENERATED = "frontend/src/api/schema.d.ts"
NAMES = re.compile(r"alien|space.?invaders", re.IGNORECASE)

OWN_FOLDERS = (
    "tril/games/space_invaders/",
    "tril/demonstrators/space_invaders/",
    "frontend/src/games/space-invaders/",
)

# Every entry is a debt; the list only gets shorter.
INFERENCE = "the recipe `fast` infers wanted aliens, until it is generalised"
PUBLISHED = "the published work is about this game"
STORED = "what was stored before there were other games"
REGISTERED = "it is the default game, or registered by its name"
DEMONSTRATOR = "the scripted player and its examples know one game"
ALLOWED = {
    "server/api/rankings.py": INFERENCE,
    "server/api/schemas/rankings.py": INFERENCE,
    "trainer/archive/standalone/reward_wrapper.py": INFERENCE,
    "trainer/reporting/digests.py": INFERENCE,
    "trainer/reward/advice.py": INFERENCE,
    "trainer/reward/model.py": INFERENCE,
    "trainer/reward/pretraining.py": INFERENCE,
    "trainer/reward/reward_trainer.py": INFERENCE,
    "trainer/reward/wanted_aliens.py": INFERENCE,
    "trainer/runtime/stages/learning.py": INFERENCE,
    "tril/analysis/opinions.py": INFERENCE,
    "tril/analysis/outcome.py": INFERENCE,
    "tril/analysis/wanted_aliens.py": INFERENCE,
    "tril/recipes/built_in.py": INFERENCE,
    "tril/recipes/values.py": INFERENCE,
    "trainer/archive/tables.py": PUBLISHED,
    "trainer/reporting/figures.py": PUBLISHED,
    "trainer/reporting/results_page.py": PUBLISHED,
    "trainer/reporting/run_report.py": PUBLISHED,
    "trainer/runtime/stages/attention.py": PUBLISHED,
    "tril/analysis/verdict.py": PUBLISHED,
    "tril/play/env.py": PUBLISHED,
    "tril/demonstrators/__init__.py": DEMONSTRATOR,
    "tril/demonstrators/error_model.py": DEMONSTRATOR,
    "tril/demonstrators/example.py": DEMONSTRATOR,
    "tril/demonstrators/judging.py": DEMONSTRATOR,
    "tril/demonstrators/kinds.py": DEMONSTRATOR,
    "tril/demonstrators/plan_matching.py": DEMONSTRATOR,
    "tril/demonstrators/varied.py": DEMONSTRATOR,
    "tril/play/saved_game.py": STORED,
    "tril/store/models.py": STORED,
    "frontend/src/features/behaviours/draft.ts": REGISTERED,
    "frontend/src/games/views.ts": REGISTERED,
    "tril/exchange/formats/recording_object.py": REGISTERED,
    "tril/games/__init__.py": REGISTERED,
}


def files(*folders: str) -> list[str]:
    """Return the files of folders that git knows or would add."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *folders],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    return [name for name in listed if (ROOT / name).exists()]


def naming(names: list[str]) -> set[str]:
    """Return the files, outside the game's own folders, that name the game or its aliens."""
    return {
        name
        for name in names
        if not name.startswith(OWN_FOLDERS)
        and NAMES.search((ROOT / name).read_text(encoding="utf-8"))
    }


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="needs the repository")
def test_only_listed_files_name_space_invaders() -> None:
    python = [n for n in files("cli", "server", "trainer", "tril") if n.endswith(".py")]
    page = [n for n in files("frontend/src") if n.endswith((".ts", ".tsx")) and n != GENERATED]
    assert len(python) > 200
    assert len(page) > 200
    assert naming([*python, *page]) == set(ALLOWED)

"""How many words the main pages show, and the README has.

    python -m benchmarks.pages.words

Serves a data folder of its own with ranked games and a finished run, opens each page in Chromium at
1280x800 and counts the words that are drawn, above the fold and below it: neither what is folded
nor what only a screen reader has. A number is a word. The README counts without its code blocks,
tables and addresses.
"""

from __future__ import annotations

import argparse
import json
import re
import tempfile
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from benchmarks.pages.lighthouse import pages_of
from benchmarks.pages.long_runs import page_of
from server.web.pages import FRONTEND
from testsupport.browser import launch_chromium
from testsupport.finished_runs import make_finished_run
from testsupport.live import live_server
from testsupport.workplace import make_workplace

README = Path(__file__).parents[2] / "README.md"
VIEW = {"width": 1280, "height": 800}
STILL_MS = 1500
"""For how long nothing is added to a page that is counted."""
WORDS = """async (still) => {
  await new Promise((resolve) => {
    let timer = setTimeout(resolve, still);
    const observer = new MutationObserver(() => {
      clearTimeout(timer);
      timer = setTimeout(resolve, still);
    });
    observer.observe(document.body, { subtree: true, childList: true });
    setTimeout(resolve, 20 * still);
  });
  const isDrawn = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const { clipPath } = getComputedStyle(at);
      if (clipPath === 'inset(50%)' || at.tagName === 'OPTION') return false;
    }
    return element.checkVisibility({ opacityProperty: true, visibilityProperty: true });
  };
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const counts = { all: 0, fold: 0 };
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const n = node.data.split(/\\s+/).filter((word) => /[\\p{L}\\p{N}]/u.test(word)).length;
    if (n === 0 || !isDrawn(node.parentElement)) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    counts.all += n;
    if (range.getBoundingClientRect().top < innerHeight) counts.fold += n;
  }
  return counts;
}"""


def counted(page: Page, path: str) -> dict[str, int]:
    """Return the numbers of words of a page, above the fold and in all."""
    page.goto(path)
    page.get_by_role("heading").first.wait_for()
    counts: dict[str, int] = page.evaluate(WORDS, STILL_MS)
    return counts


def words_of_readme(text: str) -> int:
    """Return the number of words of a Markdown text that are read as sentences."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^\|.*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"\]\([^)]*\)|https?://\S+", "", text)
    return sum(any(map(str.isalnum, word)) for word in text.split())


def main() -> None:
    """Count and print."""
    argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0]).parse_args()
    found: dict[str, dict[str, int]] = {}
    with tempfile.TemporaryDirectory(prefix="tril-words-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        run_id = make_finished_run(workplace)
        known = pages_of(run_id)
        paths = {
            "home": known["behaviours"],
            "games": "/games",
            **{name: known[name] for name in ("play", "recordings", "rank", "train")},
            "result": known["run"],
            "watch": f"/runs/{run_id}/watch",
        }
        with (
            live_server(workplace.settings.data, frontend=FRONTEND) as server,
            sync_playwright() as playwright,
            launch_chromium(playwright) as browser,
        ):
            page = page_of(browser, server)
            page.set_viewport_size({"width": VIEW["width"], "height": VIEW["height"]})
            for name, path in paths.items():
                found[name] = counted(page, path)
        workplace.database.close()
    print("| page | words at 1280x800 without scrolling | in all |\n|---|---:|---:|")
    for name, counts in found.items():
        print(f"| {name} | {counts['fold']} | {counts['all']} |")
    readme = words_of_readme(README.read_text(encoding="utf-8"))
    print(f"| README | | {readme} |")
    print(json.dumps({"benchmark": "words", "pages": found, "readme": readme}))


if __name__ == "__main__":
    main()

"""Every page in a real browser that denies storage: access itself throws."""

from __future__ import annotations

from playwright.sync_api import Browser, expect

from tests.e2e.every_page import EveryPage, settled
from tests.e2e.pages import DESKTOP, signed_in
from tests.e2e.playing import expect_running

DENY = """
for (const name of ["localStorage", "sessionStorage"]) {
  Object.defineProperty(window, name, {
    get() { throw new DOMException("Access is denied for this document.", "SecurityError"); },
  });
}
navigator.locks.request = () =>
  Promise.reject(new DOMException("Access is denied for this document.", "SecurityError"));
"""


def test_every_page_works_without_storage(browser: Browser, every_page: EveryPage) -> None:
    # An error in the console fails the test.
    with signed_in(browser, every_page.server, "/", viewport=DESKTOP) as page:
        page.add_init_script(DENY)
        for path in every_page.paths.values():
            settled(page, path)
            expect(page.get_by_text("This page crashed")).to_have_count(0)
        page.goto("/behaviours/1/play")
        page.get_by_role("button", name="Start game").click()
        expect_running(page)
        page.get_by_role("button", name="Latency L").click()
        expect(page.get_by_role("button", name="Latency L")).to_have_attribute(
            "aria-pressed", "true"
        )

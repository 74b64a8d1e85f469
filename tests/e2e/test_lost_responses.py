"""Failed saves, repeated submissions and orders of other people, in a real browser."""

from __future__ import annotations

import re

from playwright.sync_api import Browser, Dialog, Page, Route, expect

from tests.e2e.pages import DESKTOP, signed_in
from testsupport.live import LiveServer
from tril.store import rankings
from tril.store.training import runs

RANKING = re.compile("/api/behaviours/1/ranking$")
RUNS = re.compile("/api/runs$")
ANNOUNCED = "Another tab or person changed the order."
FAILED_LOAD = "Failed to load resource"


def saved_tiers(server: LiveServer) -> list[list[int]]:
    """Return the tiers of column 1 as they are stored."""
    with server.database.reading() as session:
        return [list(tier) for tier in rankings.current(session, 1).tiers]


def run_ids(server: LiveServer) -> set[str]:
    """Return the runs of column 1."""
    with server.database.reading() as session:
        return {row.id for row in runs.listing(session, 1)}


def save_elsewhere(server: LiveServer, tiers: list[list[int]]) -> None:
    """Save an order of column 1 from another browser."""
    revision = server.http.get("/api/behaviours/1/ranking").json()["revision"]
    order = {"base_revision": revision, "tiers": tiers}
    server.http.put("/api/behaviours/1/ranking", json=order).raise_for_status()


def expect_order(page: Page, tiers: list[list[int]]) -> None:
    """Expect an order on the board."""
    board = page.get_by_role("list", name="Tiers, best first")
    expect(board.get_by_role("heading", level=3)).to_have_text(
        [f"Recording {key}" for tier in tiers for key in tier]
    )


def test_an_order_that_was_refused_outlives_another_tab_and_a_reload(
    browser: Browser, built: LiveServer
) -> None:
    first, second, *others = saved_tiers(built)
    wanted = [second, first, *others]
    with signed_in(browser, built, "/behaviours/1/rank", FAILED_LOAD, viewport=DESKTOP) as page:

        def refuse(route: Route) -> None:
            if route.request.method == "PUT":
                route.fulfill(status=503, json={"detail": "Busy."})
            else:
                route.continue_()

        page.route(RANKING, refuse)
        page.get_by_role("button", name=f"Down: Recording {first[0]}", exact=True).click()
        refused = page.get_by_role("alert").get_by_text("The order could not be saved: Busy.")
        expect(refused).to_be_visible()
        path = page.get_by_role("navigation", name="Path")
        path.get_by_role("link", name="Play").click()
        expect(page.get_by_role("button", name="Start game")).to_be_visible()

        asked: list[str] = []

        def leave(dialog: Dialog) -> None:
            asked.append(dialog.type)
            dialog.accept()

        page.on("dialog", leave)
        page.reload()
        assert asked == ["beforeunload"]
        assert saved_tiers(built) == [first, second, *others]
        path.get_by_role("link", name="Rank").click()
        expect_order(page, wanted)
        expect(refused).to_be_visible()

        page.unroute(RANKING)
        page.get_by_role("button", name="Try again").click()
        expect(page.get_by_text("Saved", exact=True)).to_be_visible()
        assert saved_tiers(built) == wanted


def test_a_double_click_on_train_makes_one_run(browser: Browser, built: LiveServer) -> None:
    before = run_ids(built)
    with signed_in(browser, built, "/behaviours/1/train", viewport=DESKTOP) as page:
        page.get_by_role("button", name="Train", exact=True).dblclick()
        page.wait_for_url(re.compile("/runs/"))
        expect(page.get_by_role("progressbar", name="Imitator")).to_be_visible()
        (made,) = run_ids(built) - before
        assert page.url.endswith(f"/runs/{made}")


def test_train_pressed_again_after_a_lost_response_makes_one_run(
    browser: Browser, built: LiveServer
) -> None:
    before = run_ids(built)
    with signed_in(browser, built, "/behaviours/1/train", FAILED_LOAD, viewport=DESKTOP) as page:
        answered: list[str] = []

        def lose(route: Route) -> None:
            if route.request.method == "POST" and not answered:
                answered.append(route.fetch().json()["id"])
                route.abort()
            else:
                route.continue_()

        page.route(RUNS, lose)
        train = page.get_by_role("button", name="Train", exact=True)
        train.click()
        expect(page.get_by_role("alert").first).to_be_visible()
        assert run_ids(built) - before == set(answered)
        train.click()
        page.wait_for_url(re.compile(f"/runs/{answered[0]}$"))
        assert run_ids(built) - before == set(answered)


def test_an_order_that_arrives_during_a_keyboard_drag_is_announced_and_waits(
    browser: Browser, built: LiveServer
) -> None:
    tiers = saved_tiers(built)
    first, second, third, last = tiers
    theirs = [last, third, second, first]
    with signed_in(browser, built, "/behaviours/1/rank", FAILED_LOAD, viewport=DESKTOP) as page:
        name = f"Recording {last[0]}"
        page.get_by_role("button", name=f"Move {name}", exact=True).focus()
        page.keyboard.press("Space")
        expect(page.get_by_text(f"Picked up {name}.")).to_be_attached()
        # dnd-kit listens to the arrow keys from a timer on.
        page.evaluate("() => new Promise((done) => setTimeout(done))")
        for announced in ("Over new tier between tiers 3 and 4", "Over tier 3 of 4"):
            page.keyboard.press("ArrowUp")
            expect(page.get_by_text(announced)).to_be_attached()

        save_elsewhere(built, theirs)
        expect(page.get_by_text(f"{ANNOUNCED} You see it when this drag is over.")).to_be_visible()
        expect(page.get_by_text(f"Dropped {name}")).to_have_count(0)
        page.keyboard.press("Space")
        expect(page.get_by_text(f"Dropped {name}: tier 3 of 4, with 1 recording.")).to_be_attached()
        dialog = page.get_by_role("dialog", name="The order was changed elsewhere")
        expect(dialog).to_be_visible()
        assert saved_tiers(built) == theirs
        dialog.get_by_role("button", name="Use mine").click()
        expect(page.get_by_text("Saved", exact=True)).to_be_visible()
        assert saved_tiers(built) == [first, second, [*third, *last]]


def test_an_order_that_arrives_during_a_drag_is_shown_once_it_is_cancelled(
    browser: Browser, built: LiveServer
) -> None:
    theirs = [[key] for tier in reversed(saved_tiers(built)) for key in tier]
    with signed_in(browser, built, "/behaviours/1/rank", viewport=DESKTOP) as page:
        name = f"Recording {theirs[0][0]}"
        page.get_by_role("button", name=f"Move {name}", exact=True).focus()
        page.keyboard.press("Space")
        expect(page.get_by_text(f"Picked up {name}.")).to_be_attached()
        save_elsewhere(built, theirs)
        expect(page.get_by_text(f"{ANNOUNCED} You see it when this drag is over.")).to_be_visible()
        page.keyboard.press("Escape")
        expect(page.get_by_text(f"{ANNOUNCED} This is the new one.")).to_be_visible()
        expect_order(page, theirs)
        assert saved_tiers(built) == theirs

"""Firefox and WebKit, driven by their own protocols: no Playwright drives those that Debian has.

Firefox speaks WebDriver BiDi (https://w3c.github.io/webdriver-bidi) by itself; WebKitGTK has a
driver for WebDriver (https://w3c.github.io/webdriver). Input is the same in both.
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import tempfile
import time
import urllib.request
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

from testsupport.browser import install_debian_packages
from testsupport.ports import free_port
from testsupport.waiting import wait_until

KEYS = {
    "Enter": "\ue007",
    "ArrowLeft": "\ue012",
    "ArrowUp": "\ue013",
    "ArrowRight": "\ue014",
    "ArrowDown": "\ue015",
    "Space": " ",
}
"""The names of keys that WebDriver gives private characters; others are their own."""

FIREFOX_PREFERENCES = """
user_pref("focusmanager.testmode", true);
user_pref("browser.startup.homepage_override.mstone", "ignore");
user_pref("datareporting.policy.dataSubmissionEnabled", false);
"""
"""No desktop gives the window the focus, without which no key reaches a page."""

MINI_BROWSERS = "lib/*/webkit2gtk-4.*/MiniBrowser"
TIMEOUT_S = 60.0
AT_REST_S = 0.4
"""For which a button has not moved before it is clicked."""

Command = Callable[[str, dict[str, Any]], Any]


class OtherBrowser:
    """One page of a browser.

    Args:
        navigate: Goes to a URL.
        run: Returns what a JavaScript expression, or its promise, gives; text.
        perform: Performs input actions, by WebDriver's names.
    """

    def __init__(
        self,
        navigate: Callable[[str], object],
        run: Callable[[str], str],
        perform: Callable[[Sequence[dict[str, Any]]], object],
    ) -> None:
        self.go_to = navigate
        self._run = run
        self._perform = perform

    def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression that is no promise."""
        return json.loads(self._run(f"JSON.stringify(({expression}) ?? null)"))

    def hold(self, key: str, seconds: float = 0.05) -> None:
        """Press a key, hold it and let it go."""
        value = KEYS.get(key, key)
        pause = {"type": "pause", "duration": round(1000 * seconds)}
        down, up = ({"type": f"key{way}", "value": value} for way in ("Down", "Up"))
        self._perform([{"type": "key", "id": "keyboard", "actions": [down, pause, up]}])

    def until(self, expression: str) -> Any:
        """Wait until an expression is true; returns its value."""
        found: list[Any] = [None]

        def holds() -> bool:
            found[0] = self.evaluate(expression)
            return bool(found[0])

        wait_until(
            holds,
            TIMEOUT_S,
            lambda: f"{expression}\n{self.evaluate('document.body.innerText')}",
        )
        return found[0]

    def click(self, kind: Literal["button", "a"], name: str) -> None:
        """Click the button or link whose name begins so, once it is there, enabled and at rest."""
        sought = f"({json.dumps(kind)}, {json.dumps(name)})"
        place: Any = None
        since = time.monotonic()

        def rests() -> bool:
            # What loads above it moves it: a click would miss.
            nonlocal place, since
            before, place = place, self.evaluate(f"({FIND}){sought} && ({PLACE}){sought}")
            if place is None or place != before:
                since = time.monotonic()
            return time.monotonic() - since >= AT_REST_S

        wait_until(rests, TIMEOUT_S, lambda: f"{name}\n{self.evaluate('document.body.innerText')}")
        x, y = place
        move = {"type": "pointerMove", "x": x, "y": y, "origin": "viewport"}
        down, up = ({"type": f"pointer{way}", "button": 0} for way in ("Down", "Up"))
        pointer = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}}
        self._perform([pointer | {"actions": [move, down, up]}])


FIND = """(kind, name) => [...document.querySelectorAll(kind)].find((one) =>
  (one.getAttribute("aria-label") ?? one.innerText).trim().startsWith(name)
  && !one.disabled && one.getClientRects().length) ?? null"""

PLACE = f"""(kind, name) => {{
  const found = ({FIND})(kind, name);
  found.scrollIntoView({{ block: "center", behavior: "instant" }});
  const box = found.getBoundingClientRect();
  return [Math.round(box.x + box.width / 2), Math.round(box.y + box.height / 2)];
}}"""


@contextmanager
def firefox() -> Iterator[OtherBrowser]:
    """Run a headless Firefox with an empty profile for a block.

    Raises:
        FileNotFoundError: There is none, and none could be installed.
    """
    program = _program("firefox-esr", "firefox")
    with tempfile.TemporaryDirectory(prefix="tril-firefox-") as profile:
        Path(profile, "user.js").write_text(FIREFOX_PREFERENCES, encoding="utf-8")
        port = free_port()
        command = [program, "--headless", "--no-remote", "--profile", profile]
        with _running([*command, f"--remote-debugging-port={port}"], {}):
            socket = _connected(f"ws://127.0.0.1:{port}/session")
            with socket:
                numbers = iter(range(1, 1_000_000))

                def ask(method: str, parameters: dict[str, Any]) -> Any:
                    number = next(numbers)
                    message = {"id": number, "method": method, "params": parameters}
                    socket.send(json.dumps(message))
                    while (answer := json.loads(socket.recv(TIMEOUT_S))).get("id") != number:
                        pass
                    if answer["type"] == "error":
                        raise RuntimeError(f"{method}: {answer['message']}")
                    return answer["result"]

                ask("session.new", {"capabilities": {}})
                page = ask("browsingContext.create", {"type": "tab"})["context"]
                ask("browsingContext.activate", {"context": page})
                size = {"width": 1280, "height": 900}
                ask("browsingContext.setViewport", {"context": page, "viewport": size})

                def run(expression: str) -> str:
                    found = ask(
                        "script.evaluate",
                        {
                            "expression": expression,
                            "target": {"context": page},
                            "awaitPromise": False,
                        },
                    )
                    if found["type"] == "exception":
                        raise RuntimeError(found["exceptionDetails"]["text"])
                    value: str = found["result"]["value"]
                    return value

                yield OtherBrowser(
                    lambda url: ask(
                        "browsingContext.navigate",
                        {"context": page, "url": url, "wait": "complete"},
                    ),
                    run,
                    lambda actions: ask(
                        "input.performActions", {"context": page, "actions": list(actions)}
                    ),
                )


@contextmanager
def webkit() -> Iterator[OtherBrowser]:
    """Run WebKitGTK's small browser on a display of its own for a block.

    Raises:
        FileNotFoundError: There is none, and none could be installed.
    """
    driver, display = _program("WebKitWebDriver"), _program("Xvfb")
    browser = next(Path("/usr").glob(MINI_BROWSERS), None)
    if browser is None:
        raise FileNotFoundError("There is no MiniBrowser of WebKitGTK.")
    port, screen = free_port(), f":{90 + os.getpid() % 900}"
    with (
        _running([display, screen, "-screen", "0", "1280x1024x24"], {}),
        _running([driver, f"--port={port}"], {"DISPLAY": screen, "LIBGL_ALWAYS_SOFTWARE": "1"}),
    ):
        base = f"http://127.0.0.1:{port}/session"
        options = {"binary": str(browser), "args": ["--automation"]}
        asked = {"capabilities": {"alwaysMatch": {"webkitgtk:browserOptions": options}}}
        wait_until(lambda: _listens(port), TIMEOUT_S)
        session = f"{base}/{_post(base, asked)['sessionId']}"
        try:
            yield OtherBrowser(
                lambda url: _post(f"{session}/url", {"url": url}),
                lambda expression: _post(
                    f"{session}/execute/sync", {"script": f"return {expression}", "args": []}
                ),
                lambda actions: _post(f"{session}/actions", {"actions": list(actions)}),
            )
        finally:
            urllib.request.urlopen(urllib.request.Request(session, method="DELETE")).close()


def _program(*names: str) -> str:
    """Return the path of the first of some programs, after an attempt to install them.

    Raises:
        FileNotFoundError: There is none.
    """
    packages = {"firefox-esr": "firefox-esr", "WebKitWebDriver": "webkit2gtk-driver"}
    found = next(filter(None, map(shutil.which, names)), None)
    if found is None:
        install_debian_packages(packages.get(names[0], names[0].lower()))
        found = next(filter(None, map(shutil.which, names)), None)
    if found is None:
        raise FileNotFoundError(f"There is no {names[0]} on this machine.")
    return found


@contextmanager
def _running(command: Sequence[str], more: dict[str, str]) -> Iterator[None]:
    process = subprocess.Popen(
        command,
        env=os.environ | more,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _connected(url: str) -> Any:
    give_up_at = time.monotonic() + TIMEOUT_S
    while True:
        try:
            return connect(url, max_size=None)
        except (OSError, WebSocketException):
            if time.monotonic() > give_up_at:
                raise
            time.sleep(0.1)


def _post(url: str, body: dict[str, Any]) -> Any:
    request = urllib.request.Request(
        url, json.dumps(body).encode(), {"Content-Type": "application/json"}
    )
    with urllib.request.urlopen(request, timeout=TIMEOUT_S) as answer:
        return json.load(answer)["value"]


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0

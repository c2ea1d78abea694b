# SPDX-License-Identifier: GPL-3.0-or-later
"""A real browser without a display, driven through WebDriver (W3C): Chromium and its driver, spoken to with the standard library."""

from __future__ import annotations

import base64
import json
import shutil
import socket
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--hide-scrollbars",
)  # fmt: skip
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")  # names that systems give to it
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the key of an element, fixed by the standard


def missing() -> str:
    """Why no browser can be started here; empty where one can."""
    wanted = [name for name, found in (("chromium", _program()), ("chromedriver", shutil.which("chromedriver"))) if not found]
    return f"{' and '.join(wanted)} not installed (Debian: apt-get install chromium chromium-driver)" if wanted else ""


def _program() -> str | None:
    """Where the browser is."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


class Browser:
    """One window."""

    def __init__(self, port: int, session: str) -> None:
        self._at = f"http://127.0.0.1:{port}/session/{session}"

    def open(self, path: Path) -> None:
        """Open a file and wait until the page says that it is ready."""
        _call("POST", f"{self._at}/url", {"url": path.resolve().as_uri()})
        assert self.run_async("window.ready.then(done)"), self.run("return document.getElementById('trouble').textContent")

    def run(self, script: str, *arguments: Any) -> Any:
        """Run a script in the page; it returns what its ``return`` gives."""
        return _call("POST", f"{self._at}/execute/sync", {"script": script, "args": list(arguments)})

    def run_async(self, script: str) -> Any:
        """Run a script in the page that calls ``done(value)``."""
        code = f"const done = arguments[arguments.length - 1]; {script}"
        return _call("POST", f"{self._at}/execute/async", {"script": code, "args": []})

    def wait_for(self, condition: str) -> None:
        """Wait for a frame at which a condition holds; the time of scripts bounds it."""
        self.run_async(f"const look = () => ({condition}) ? done(true) : requestAnimationFrame(look); look();")

    def drawn(self) -> None:
        """Wait until the request is drawn: the second frame from now begins when the first has been."""
        self.run_async("requestAnimationFrame(() => requestAnimationFrame(() => done(true)))")

    def click(self, selector: str) -> None:
        """Click the first element that a CSS selector finds, as a reader would."""
        found = _call("POST", f"{self._at}/element", {"using": "css selector", "value": selector})
        _call("POST", f"{self._at}/element/{found[ELEMENT]}/click", {})

    def click_at(self, x: float, y: float) -> None:
        """Click a place of the window, in CSS pixels."""
        moves = [
            {"type": "pointerMove", "x": round(x), "y": round(y)},
            {"type": "pointerDown", "button": 0},
            {"type": "pointerUp", "button": 0},
        ]
        _call("POST", f"{self._at}/actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": moves}]})

    def drag(self, x: float, y: float, dx: float, dy: float) -> None:
        """Drag from a place of the window."""
        moves: list[dict[str, Any]] = [{"type": "pointerMove", "x": round(x), "y": round(y)}, {"type": "pointerDown", "button": 0}]
        moves += [{"type": "pointerMove", "x": round(x + dx), "y": round(y + dy), "duration": 100}, {"type": "pointerUp", "button": 0}]
        _call("POST", f"{self._at}/actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": moves}]})

    def size(self, width: int, height: int) -> None:
        """Make the window so large [pixels]."""
        _call("POST", f"{self._at}/window/rect", {"width": width, "height": height})

    def screenshot(self, path: Path) -> None:
        """A picture of the window."""
        path.write_bytes(base64.b64decode(_call("GET", f"{self._at}/screenshot")))

    def pdf(self) -> bytes:
        """The page as it is printed."""
        return base64.b64decode(_call("POST", f"{self._at}/print", {"background": True, "page": {"width": 21.0, "height": 29.7}}))

    def complaints(self) -> list[str]:
        """Messages of the console since the last call; remarks of the graphics driver on speed do not count."""
        said = _call("POST", f"{self._at}/se/log", {"type": "browser"})
        return [line["message"] for line in said if "GPU stall due to ReadPixels" not in line["message"]]


@contextmanager
def browser(folder: Path, width: int = 1500, height: int = 1000) -> Iterator[Browser]:
    """Start a browser with a profile of its own in a folder, and end it."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    driver = subprocess.Popen(["chromedriver", f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        _wait_for(port)
        options = {
            "args": [*FLAGS, f"--user-data-dir={folder / 'profile'}", f"--window-size={width},{height}"],
            "binary": _program(),
        }
        wanted = {
            "browserName": "chrome",
            "goog:chromeOptions": options,
            "goog:loggingPrefs": {"browser": "ALL"},
            "timeouts": {"script": 60000},
        }
        session = _call("POST", f"http://127.0.0.1:{port}/session", {"capabilities": {"alwaysMatch": wanted}})["sessionId"]
        try:
            yield Browser(port, session)
        finally:
            _call("DELETE", f"http://127.0.0.1:{port}/session/{session}")
    finally:
        driver.terminate()
        driver.wait(10)


def _wait_for(port: int) -> None:
    for _ in range(100):
        try:
            if _call("GET", f"http://127.0.0.1:{port}/status")["ready"]:
                return
        except OSError:
            time.sleep(0.1)
    raise RuntimeError("chromedriver does not answer")


def _call(method: str, address: str, body: dict[str, Any] | None = None) -> Any:
    """One call; an error of the browser is raised with its message."""
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(address, data, {"Content-Type": "application/json"}, method=method)
    try:
        with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=120) as answer:
            return json.load(answer)["value"]
    except urllib.error.HTTPError as failure:
        raise RuntimeError(json.load(failure)["value"]["message"]) from None

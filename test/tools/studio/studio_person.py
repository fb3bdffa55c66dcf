"""What a person does on the page of `artrec studio`, in a headless browser, each action counted."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
_LONG_S = 300  # a first start compiles
_SOON_S = 60  # what a click does at once, on a machine that has much else to do


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def studio(arguments: Sequence[str], folder: Path) -> Iterator[int]:
    """`artrec studio` with these arguments, at work in a folder; its port."""
    port = free_port()
    command = [sys.executable, "-m", "artrec_ros.tools.main", "--debug", "studio", *arguments]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NO_NETRC": "1"}
    environment.pop("PYTEST_CURRENT_TEST", None)
    with (folder / "studio.log").open("wb") as log:
        process = subprocess.Popen(
            [*command, "--port", str(port), "--no-open"], cwd=folder, env=environment, stdout=log, stderr=log
        )
        try:
            _wait_for(port, process, folder)
            yield port
        finally:
            process.terminate()
            process.wait(30)


def _wait_for(port: int, process: subprocess.Popen[bytes], folder: Path) -> None:
    end = time.monotonic() + _LONG_S
    while time.monotonic() < end:
        if process.poll() is not None:
            raise AssertionError((folder / "studio.log").read_text())
        try:
            urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=5).read()
            return
        except OSError:
            time.sleep(0.3)
    raise AssertionError("the page did not come up")


class Person:
    """:ivar did: kind of action -> how often. :ivar scale: pixels of the page per pixel of the picture."""

    def __init__(self, page: Any, image_width: int) -> None:
        self.page, self.did, self._width = page, Counter[str](), image_width

    def open(self, port: int, first: str = "colours") -> None:
        """:param first: the tab that is seen at the beginning."""
        self.page.goto(f"http://127.0.0.1:{port}/")
        self.page.wait_for_selector(f"[data-name={first}-picture] img")
        self.settle()

    def tab(self, name: str) -> None:
        self.press_button(f"tab-{name}")

    def press_button(self, name: str) -> None:
        self.did["buttons"] += 1
        self.page.locator(f"[data-name='{name}']").first.click()
        self.settle()

    def type(self, name: str, text: str) -> None:
        """Into a field, and Enter."""
        self.did["typed"] += 1
        field = self.page.locator(f"[data-name='{name}']").first
        field = field if field.evaluate("e => e.tagName") == "INPUT" else field.locator("input").first
        field.fill(text)
        field.press("Enter")
        self.settle()

    def option(self, name: str, text: str) -> None:
        """One of the buttons of a toggle."""
        self.did["buttons"] += 1
        self.page.locator(f"[data-name={name}] button", has_text=text).first.click()
        self.settle()

    def key(self, key: str, times: int = 1) -> None:
        for _ in range(times):
            self.did["keys"] += 1
            self.page.keyboard.press(key)
            self.page.wait_for_timeout(80)

    def frame(self, name: str) -> None:
        """With the arrow keys to the frame of this name."""
        for _ in range(500):
            told = self.text("frame")
            if told.split()[-1] == name:
                return
            self.key("ArrowRight" if told.split()[0].partition("/")[0] != told.split()[0].partition("/")[2] else "Home")
            self.until(lambda before=told: self.text("frame") != before)
        raise AssertionError(f"no frame {name}")

    def click(self, viewer: str, place: Sequence[float]) -> None:
        self.did["clicks"] += 1
        self.page.mouse.click(*self._at(viewer, place))
        self.page.wait_for_timeout(80)

    def drag(self, viewer: str, start: Sequence[float], end: Sequence[float]) -> None:
        self.did["drags"] += 1
        self.page.mouse.move(*self._at(viewer, start))
        self.page.mouse.down()
        self.page.mouse.move(*self._at(viewer, end), steps=3)
        self.page.mouse.up()
        self.page.wait_for_timeout(80)

    def _at(self, viewer: str, place: Sequence[float]) -> tuple[float, float]:
        image = self.page.locator(f"[data-name={viewer}] img").first
        image.scroll_into_view_if_needed()
        box = image.bounding_box()
        scale = box["width"] / self._width
        return box["x"] + (place[0] + 0.5) * scale, box["y"] + (place[1] + 0.5) * scale

    def until(self, happened: Callable[[], bool]) -> None:
        """Waits for it: a busy machine takes its time. :raises AssertionError: it does not happen."""
        end = time.monotonic() + _SOON_S
        while not happened():
            self.page.wait_for_timeout(50)
            assert time.monotonic() < end

    def settle(self) -> None:
        """Until nothing is at work."""
        end, quiet = time.monotonic() + _LONG_S, 0
        while quiet < 4:
            self.page.wait_for_timeout(150)
            quiet = 0 if self.page.locator("[data-busy]").count() else quiet + 1
            assert time.monotonic() < end, "still at work"

    def complaint(self) -> str:
        """The first error that the page shows; '' where there is none."""
        shown = self.page.locator(".q-notification.bg-negative")
        return str(shown.first.inner_text()) if shown.count() else ""

    def sees(self, name: str, words: str) -> None:
        """Waits for words to be there: a busy machine takes its time. :raises AssertionError: they do not come."""
        end = time.monotonic() + _SOON_S
        while words not in self.text(name):
            self.page.wait_for_timeout(100)
            assert time.monotonic() < end, f"{name}: '{words}' is not in '{self.text(name)}'"

    def text(self, name: str) -> str:
        return str(self.page.locator(f"[data-name={name}]").first.inner_text())

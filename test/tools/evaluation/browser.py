"""A headless chromium, driven through chromium-driver by the W3C WebDriver protocol; the standard library is enough."""

from __future__ import annotations

import base64
import json
import os
import re
import shutil
import subprocess
import time
import urllib.request
from pathlib import Path
from typing import Any

DRIVER = shutil.which("chromedriver")
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


NO_GL = ("--disable-gpu",)
SOFTWARE_GL = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist")


class Browser:
    """One page in one window. A context manager. :param graphics: what draws in three dimensions, if anything."""

    def __init__(self, profile: Path, size: tuple[int, int], graphics: tuple[str, ...] = NO_GL) -> None:
        self._profile, self._size, self._graphics = profile, size, graphics

    def __enter__(self) -> Browser:
        assert DRIVER is not None
        self._driver = subprocess.Popen([DRIVER, "--port=0"], stdout=subprocess.PIPE, text=True)
        assert self._driver.stdout is not None
        for line in self._driver.stdout:
            if found := re.search(r"started successfully on port (\d+)", line):
                break
        self._base = f"http://127.0.0.1:{found[1]}/session"
        arguments = ["--headless=new", *self._graphics, "--hide-scrollbars", f"--user-data-dir={self._profile}",
                     *(["--no-sandbox"] if os.geteuid() == 0 else []), "--disable-dev-shm-usage"]  # fmt: skip
        wanted = {"goog:chromeOptions": {"binary": BROWSER, "args": arguments}, "goog:loggingPrefs": {"browser": "ALL"}}
        try:
            session = self._send("POST", "", {"capabilities": {"alwaysMatch": wanted}})
        except BaseException:
            self._driver.kill()
            raise
        self._base += f"/{session['sessionId']}"
        self.resize(*self._size)
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self._send("DELETE", "")
        finally:
            self._driver.terminate()
            self._driver.wait(20)

    def resize(self, width: int, height: int) -> None:
        """The page's own size, below a window's least width, too."""
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self._send("POST", "/goog/cdp/execute", {"cmd": "Emulation.setDeviceMetricsOverride", "params": metrics})

    def prefer(self, scheme: str) -> None:
        """What the user prefers: 'light' or 'dark'."""
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self._send("POST", "/goog/cdp/execute", {"cmd": "Emulation.setEmulatedMedia", "params": {"features": features}})

    def open(self, page: Path) -> None:
        """Shows a page, and waits until it is laid out: on a busy machine the driver may answer before that."""
        self.run("window.isLeft = true")
        self._send("POST", "/url", {"url": page.resolve().as_uri()})
        wanted = "return !window.isLeft && document.readyState === 'complete' && document.body.offsetHeight > 0"
        end = time.monotonic() + 60
        while not self.run(wanted):
            assert time.monotonic() < end, f"{page} did not load"
            time.sleep(0.05)

    def run(self, script: str, *arguments: Any) -> Any:
        """What a script returns in the page."""
        return self._send("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def complaints(self) -> list[str]:
        """What the browser's console says, favicons apart."""
        log = self._send("POST", "/se/log", {"type": "browser"})
        return [entry["message"] for entry in log if "favicon" not in entry["message"]]

    def screenshot(self) -> bytes:
        return base64.b64decode(self._send("GET", "/screenshot"))

    def _send(self, method: str, path: str, body: dict[str, Any] | None = None) -> Any:
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self._base + path, data, {"Content-Type": "application/json"}, method=method)
        with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=60) as answer:
            return json.load(answer)["value"]

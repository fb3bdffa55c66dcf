"""Progress on a terminal, and where there is none."""

from __future__ import annotations

import os
import select
import sys
import time

import pytest

from artrec_ros.io.base import bars


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bars, "FIRST_S", 0.05)
    monkeypatch.setattr(bars, "LINE_S", 0.2)


def test_where_nobody_looks_long_work_says_a_line_now_and_then(capsys: pytest.CaptureFixture[str]) -> None:
    for _ in bars.bar(range(20), "reading", unit="frame"):
        time.sleep(0.03)
    lines = capsys.readouterr().err.splitlines()
    assert 2 <= len(lines) <= 5
    assert all(line.startswith("reading: ") and " of 20 frames, " in line for line in lines)


def test_work_that_is_told_of_says_lines_too(capsys: pytest.CaptureFixture[str]) -> None:
    with bars.bar(total=10, unit="trial") as shown:
        for _ in range(10):
            time.sleep(0.03)
            shown.update()
    lines = capsys.readouterr().err.splitlines()
    assert lines and all(" of 10 trials, " in line for line in lines)


def test_short_work_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert list(bars.bar(range(3), unit="frame")) == [0, 1, 2]
    assert capsys.readouterr().err == ""


def test_a_terminal_that_has_no_width_shows_a_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    master, slave = os.openpty()  # of 0 columns
    with os.fdopen(slave, "w") as terminal, monkeypatch.context() as patched:
        patched.setattr(sys, "stderr", terminal)
        assert list(bars.bar(range(3), unit="frame")) == [0, 1, 2]
        shown = os.read(master, 10_000)
        while (
            b"3/3" not in shown and select.select([master], [], [], 1.0)[0]
        ):  # a terminal may hand it on piece by piece
            shown += os.read(master, 10_000)
    os.close(master)
    assert b"3/3" in shown

"""Compiling ahead, and what users see of it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from artrec_ros.core.base import kernel_cache
from artrec_ros.core.warm_up_pieces import PIECES, PLANE, SPACE
from artrec_ros.tools.getting_ready import progress

ROOT = Path(__file__).parents[2]


PREPARE = (sys.executable, "-m", "artrec_ros.tools.main", "prepare")


@pytest.fixture(scope="module")
def printed() -> str:
    """By a process of its own: what this one has compiled says nothing of what lies on disk by now."""
    done = subprocess.run(PREPARE, cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_it_says_where_the_results_lie(printed: str) -> None:
    folder = Path(printed.rpartition(" in ")[2])
    assert folder in kernel_cache.folders() and (folder / "space.ready").exists()


def test_where_nothing_can_be_kept_it_fails_with_the_way_out(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    done = subprocess.run(
        PREPARE, cwd=ROOT, capture_output=True, text=True,
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "file")}, timeout=120,
    )  # fmt: skip
    (line,) = done.stderr.splitlines()
    assert done.returncode == 1 and str(tmp_path / "file") in line and "NUMBA_CACHE_DIR" in line


READ_ONLY = """
from artrec_ros.core.base import kernel_cache
kernel_cache.writable = lambda: None  # root may write whatever the folder's mode is
from numba.core import event
begun = []

class Listener(event.Listener):
    def on_start(self, what):
        begun.append(what.data["dispatcher"].py_func.__qualname__)

    def on_end(self, what):
        pass

event.register("numba:compile", Listener())
from artrec_ros.tools.main import main
assert main(["prepare"]) == 0
assert not begun, begun
"""


@pytest.mark.usefixtures("printed")
def test_what_is_kept_where_nothing_can_be_written_is_used() -> None:
    done = subprocess.run([sys.executable, "-c", READ_ONLY], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "done before" in done.stdout and not done.stderr


def test_lines_tell_how_far_it_is_where_there_is_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with progress() as told:
        pass
    assert capsys.readouterr().err == "", "what is there needs no word"
    with progress() as told:
        for share in (0.0, 0.4, 1.0):
            told(share)
    assert capsys.readouterr().err.splitlines() == ["getting ready, 0%: compiling, once on a machine"]


def test_a_line_tells_first_and_once_why_nothing_is_kept(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel_cache, "writable", lambda: None)
    with progress() as told:
        told(0.0)
        told(0.4)
    warning, line = capsys.readouterr().err.splitlines()
    assert warning.startswith("warning: ") and "NUMBA_CACHE_DIR" in warning
    assert line == "getting ready, 0%: compiling, at every start"


def test_a_folder_that_fills_up_is_told_of_at_the_first_result_that_has_no_room(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel_cache, "_problem", "")
    with progress() as told:
        told(0.1)
        assert "warning" not in capsys.readouterr().err
        kernel_cache.note_failed_write("/there: compiled code cannot be written: No space left on device")
        told(0.1)
        (line,) = capsys.readouterr().err.splitlines()
    assert "warning: /there" in line and "make room" in line
    assert not capsys.readouterr().err, "once"


def test_a_compiler_that_is_switched_off_is_told_of_though_nothing_is_compiled(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("numba.config.DISABLE_JIT", 1)
    with progress():
        pass
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("warning: NUMBA_DISABLE_JIT is set")


def test_every_part_has_its_pieces() -> None:
    assert {piece.part for piece in PIECES.values()} == {PLANE, SPACE}

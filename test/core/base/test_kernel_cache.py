"""Compiled code on disk."""

import os
import subprocess
import sys
import time

import pytest

from artrec_ros.core.base import kernel_cache

CACHED = (kernel_cache.version, kernel_cache.folders, kernel_cache.writable)


@pytest.fixture
def forgetful():
    """Nothing is remembered from before, nor after."""
    for function in CACHED:
        function.cache_clear()
    yield
    for function in CACHED:
        function.cache_clear()


def folder_in(parent):
    return parent / f"kernels-{kernel_cache.version()}"


def test_the_version_is_that_of_all_kernels_together(forgetful, monkeypatch, tmp_path):
    source = tmp_path / "room" / "one_kernels.py"
    source.parent.mkdir()
    monkeypatch.setattr(kernel_cache, "_CORE", tmp_path)
    versions = []
    for text in ("a = 1", "a = 2", "a = 1"):
        source.write_text(text)
        kernel_cache.version.cache_clear()
        versions.append(kernel_cache.version())
    assert versions[0] == versions[2] != versions[1]


def test_results_lie_where_the_environment_says_else_beside_the_package_else_with_the_user(
    forgetful, monkeypatch, tmp_path
):
    monkeypatch.setattr(kernel_cache, "_CORE", tmp_path / "core")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user"))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    assert kernel_cache.writable() == folder_in(tmp_path / "core" / "__pycache__")
    for function in CACHED:
        function.cache_clear()
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(kernel_cache, "_CORE", tmp_path / "file")  # below it no folder can be made
    assert kernel_cache.writable() == folder_in(tmp_path / "user" / "artrec_ros")
    for function in CACHED:
        function.cache_clear()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "given"))
    assert kernel_cache.writable() == folder_in(tmp_path / "given")
    assert kernel_cache.problem() == ""


def test_where_nothing_can_be_written_a_line_says_the_way_out(forgetful, monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    assert kernel_cache.writable() is None
    problem = kernel_cache.problem()
    assert str(tmp_path / "file") in problem and "NUMBA_CACHE_DIR" in problem and "\n" not in problem
    kernel_cache.note("part")
    assert not kernel_cache.is_noted("part")
    with kernel_cache.held(lambda: None):
        pass


def test_a_folder_without_room_for_a_lock_holds_nobody_up(forgetful, monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    (kernel_cache.writable() / "lock").mkdir()  # a file of this name cannot be opened
    with kernel_cache.held(lambda: None):
        pass


def test_a_compiler_that_is_switched_off_is_named_before_all_else(forgetful, monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert not kernel_cache.switched_off()
    monkeypatch.setattr("numba.config.DISABLE_JIT", 1)
    assert kernel_cache.problem() == kernel_cache.switched_off() != ""
    assert "NUMBA_DISABLE_JIT" in kernel_cache.problem()


def test_old_results_of_other_versions_are_removed_and_new_ones_stay(forgetful, monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    old, new = tmp_path / "kernels-old", tmp_path / "kernels-new"
    for folder in (old, new):
        folder.mkdir()
    long_ago = time.time() - 30 * 86400
    os.utime(old, (long_ago, long_ago))
    assert kernel_cache.writable() is not None
    assert new.exists() and not old.exists()


HOLDER = """
import sys
from artrec_ros.core.base import kernel_cache
with kernel_cache.held(lambda: None):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_one_process_at_a_time_compiles(forgetful, monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    other = subprocess.Popen([sys.executable, "-c", HOLDER], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert other.stdout.readline() == b"held\n"
    waited = []

    def waiting():
        waited.append(True)
        if len(waited) == 2:
            other.communicate()

    with kernel_cache.held(waiting):
        assert len(waited) >= 2

"""`artrec replay --rerun`: the file itself, whole or not there, and what is told where it cannot be made."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from rerun_recording import PNG, Recording, run


def test_each_of_several_sources_has_its_path(tmp_path, params, bag):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    assert run(params, tmp_path / "two.rrd", bag, bag) == 0
    rows = Recording(tmp_path / "two.rrd").rows
    paths = [{path.removeprefix(f"/source_{i}/") for path in rows if path.startswith(f"/source_{i}/")} for i in (0, 1)]
    assert paths[0] == paths[1] and "objects/crane_0/base/bodies" in paths[0]


def test_rerun_itself_has_nothing_against_the_file(tmp_path, params, bag):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    assert run(params, tmp_path / "seen.rrd", bag) == 0
    command = [sys.executable, "-m", "rerun", "rrd", "verify", str(tmp_path / "seen.rrd")]
    environment = {**os.environ, "HOME": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment)
    assert done.returncode == 0 and "without error" in done.stdout + done.stderr, done.stderr


def test_of_an_interrupted_replay_nothing_is_left_that_looks_whole(tmp_path, params, bag, monkeypatch):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    from artrec_ros.tools.replaying.rerun_file import RerunFile

    def fails(self, *_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(RerunFile, "add", fails)
        assert run(params, tmp_path / "seen.rrd", bag) == 1
    assert not list(tmp_path.glob("seen.rrd*"))
    assert run(params, tmp_path / "seen.rrd", bag) == 0, "the same command goes on, with all frames from the first on"
    assert len(Recording(tmp_path / "seen.rrd").stamps("/camera/classes", "SegmentationImage:buffer")) == 4


def test_where_there_is_no_room_it_ends_and_says_so(tmp_path):
    """Rerun's own writer would be waited for in vain."""
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    program = f"""
import resource, numpy as np
from pathlib import Path
from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.base.errors import SourceError
from artrec_ros.io.results.journal import Recognised
from artrec_ros.tools.replaying.raw_frames import RawFrame
from artrec_ros.tools.replaying.rerun_file import RerunFile
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
noise = np.random.default_rng(0).integers(0, 255, (40, 30_000), np.uint8)  # nothing packs it
try:
    with RerunFile(Path({str(tmp_path / "seen.rrd")!r}), ImageConfig(), ()) as file:
        for i, picture in enumerate(noise):
            file.add(0, Recognised(i, "x"), RawFrame({PNG!r}, picture.tobytes(), None))
except SourceError as error:
    print("no room:", error)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert "no room:" in done.stdout and "seen.rrd" in done.stdout, done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("missing", ["rerun", "folder"])
def test_what_is_missing_is_told_before_any_work(tmp_path, params, bag, capsys, monkeypatch, missing):
    output = tmp_path / "seen.rrd"
    if missing == "rerun":
        monkeypatch.setitem(sys.modules, "rerun", None)
    else:
        pytest.importorskip("rerun", reason="rerun-sdk is not installed")
        output = tmp_path / "nowhere" / "seen.rrd"
    assert run(params, output, bag, more=["-o", str(tmp_path / "out")]) == 1
    told = capsys.readouterr().err.strip()
    assert ("pip install 'artrec_ros[rerun]'" if missing == "rerun" else "make it, or name another") in told
    assert len(told.splitlines()) == 1 and not (tmp_path / "out").exists()


def test_a_recording_has_its_ending(tmp_path, params, bag, capsys):
    assert run(params, tmp_path / "seen.mcap", bag) == 2
    assert "name it FILE.rrd" in capsys.readouterr().err

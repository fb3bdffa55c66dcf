"""What `artrec studio` begins with: frames of bags, videos and folders as files."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import SourceError
from artrec_ros.io.images.decoding import read_image
from artrec_ros.io.sources.opening import SourceOptions
from artrec_ros.tools.main import main
from artrec_ros.tools.studio_state.stills import open_stills

ROOT = Path(__file__).resolve().parents[3]


def test_a_bag_becomes_files_that_are_taken_again(tmp_path: Path) -> None:
    simulated = ["simulate", str(ROOT / "config/objects/excavator.yaml"), "--frames", "5", "-o", str(tmp_path / "sim")]
    assert main(simulated) == 0
    said: list[str] = []
    options = SourceOptions(image_kind="labels")
    stills = open_stills(tmp_path / "sim/bag", options, 3, tmp_path / "frames", said.append)
    assert len(stills) == 3 and stills.camera is not None and len(said) == 1
    assert stills.stamps_ns[0] >= 1_700_000_000_000_000_000, "files are named by their stamps"
    np.testing.assert_array_equal(stills.image(0), read_image(tmp_path / "sim/images/0000.png"))
    taken = open_stills(tmp_path / "sim/bag", options, 3, tmp_path / "frames", said.append)
    assert len(said) == 1 and taken.files == stills.files and taken.camera is not None


def test_a_video_is_a_source(tmp_path: Path) -> None:
    writer = cv2.VideoWriter(str(tmp_path / "film.mp4"), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (64, 48))
    for level in range(6):
        writer.write(np.full((48, 64, 3), 40 * level, np.uint8))
    writer.release()
    stills = open_stills(tmp_path / "film.mp4", SourceOptions(), 3, tmp_path / "frames", print)
    assert stills.stamps_ns == [0, 200_000_000, 400_000_000]
    assert abs(float(stills.image(2).mean()) - 160) < 6


@pytest.mark.parametrize("name", ["none", "none.mp4"])
def test_a_source_that_is_not_there_is_named(name: str, tmp_path: Path) -> None:
    with pytest.raises(SourceError, match=name):
        open_stills(tmp_path / name, SourceOptions(), 3, tmp_path / "frames", print)

"""What is no source is told, with what is one."""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import SourceError
from artrec_ros.io.images.decoding import IMAGE_SUFFIXES
from artrec_ros.io.images.video import VIDEO_SUFFIXES
from artrec_ros.io.inventory.inventory import take_stock
from artrec_ros.io.sources.opening import open_sources
from artrec_ros.io.sources.video_source import VideoSource

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("suffix", [".M4V", ".mpg", ".wmv", ".flv", ".3gp", ".ts", ".MTS", ".gif"])
def test_videos_are_known_by_all_their_suffixes(tmp_path, suffix):
    film = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (64, 48))
    writer.write(np.zeros((48, 64, 3), np.uint8))
    writer.release()
    path = film.rename(tmp_path / f"film{suffix}")  # OpenCV looks at what it holds
    with open_sources([path]) as sources:
        assert isinstance(sources.parts[0], VideoSource) and len(list(sources)) == 1
    (item,) = take_stock([path])
    assert item.error is None and item.content.count == 1


def test_a_file_of_no_known_kind_is_told_what_would_be_one(tmp_path):
    path = tmp_path / "film.xyz"
    path.write_bytes(bytes(99))
    for suffix in (".mp4", ".gif", ".png", ".mcap"):
        with pytest.raises(SourceError, match=rf"film.xyz: '.xyz' is no source: .*\{suffix}"):
            open_sources([path])
    (item,) = take_stock([path])
    assert "no kind of file that artrec inspect reads" in item.error and ".mp4" in item.error and ".png" in item.error


def test_of_an_image_its_folder_is_wanted(tmp_path):
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((8, 8), np.uint8))
    with pytest.raises(SourceError, match="is an image; give the folder"):
        open_sources([tmp_path / "a.png"])


@pytest.mark.parametrize("name", ["rtsp://camera/live", "http://host/film.mp4", "/dev/video97", "/dev/null"])
def test_live_sources_go_to_the_node(name):
    with pytest.raises(SourceError, match=re.escape(f"{name}: is no file: live images go to the node")):
        open_sources([Path(name)])
    (item,) = take_stock([Path(name)])
    assert "live images go to the node" in item.error


def test_a_folder_may_be_called_like_an_address(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("http:/host").mkdir(parents=True)
    cv2.imwrite("http:/host/a.png", np.zeros((8, 8), np.uint8))
    with open_sources([Path("http:/host")]) as sources:
        assert sources.count == 1


def test_the_documentation_lists_the_suffixes():
    text = (ROOT / "docs/replay.md").read_text(encoding="utf-8")
    assert not [s for s in (*VIDEO_SUFFIXES, *IMAGE_SUFFIXES) if f"`{s}`" not in text]

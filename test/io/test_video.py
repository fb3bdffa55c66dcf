"""Videos hold every picture, at the pictures' own rate."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.io.images.video import VideoWriter


def frames_of(path):
    video, frames = cv2.VideoCapture(str(path)), []
    while (read := video.read())[0]:
        frames.append(read[1])
    return frames, video.get(cv2.CAP_PROP_FPS)


@pytest.mark.parametrize(("step_ns", "rate_hz"), [(50_000_000, 20), (0, 60), (10**10, 1)])
def test_all_pictures_are_there_at_their_rate(tmp_path, step_ns, rate_hz):
    with VideoWriter(tmp_path / "v.mp4") as video:
        for i in range(4):
            video.add(i * step_ns, np.full((65, 97, 3), 60 * i, np.uint8))
    frames, rate = frames_of(tmp_path / "v.mp4")
    assert rate == pytest.approx(rate_hz)
    assert [round(float(f.mean()) / 60) for f in frames] == [0, 1, 2, 3]
    assert frames[0].shape == (64, 96, 3)  # the codec wants even sizes


def test_pictures_of_another_size_are_fitted_in(tmp_path):
    with VideoWriter(tmp_path / "v.mp4") as video:
        video.add(0, np.full((64, 96, 3), 200, np.uint8))
        video.add(10**8, np.full((128, 96, 3), 200, np.uint8))
    second = frames_of(tmp_path / "v.mp4")[0][1]
    assert second[:, :40].mean() > 180 and second[:, 60:].mean() < 60


def test_one_picture_is_a_video_and_none_is_no_file(tmp_path):
    with VideoWriter(tmp_path / "one.mp4") as video:
        video.add(0, np.zeros((64, 96, 3), np.uint8))
    assert len(frames_of(tmp_path / "one.mp4")[0]) == 1
    with VideoWriter(tmp_path / "none.mp4"):
        pass
    assert not (tmp_path / "none.mp4").exists()


@pytest.mark.parametrize("name", ["12:30", "http:x", "pipe:1"])
def test_a_folder_may_have_any_name(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    path = Path(name) / "v.mp4"
    path.parent.mkdir()
    with VideoWriter(path) as video:
        video.add(0, np.zeros((64, 96, 3), np.uint8))
    assert len(frames_of(path.absolute())[0]) == 1

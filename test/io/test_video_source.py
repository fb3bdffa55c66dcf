"""Videos as sources."""

import re

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import SourceError
from artrec_ros.io.inventory.inventory import take_stock
from artrec_ros.io.sources.frames import SourceOptions
from artrec_ros.io.sources.opening import open_sources

COUNT = 25


@pytest.fixture
def film(tmp_path):
    path = tmp_path / "film.mp4"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (64, 48))
    for level in range(COUNT):
        writer.write(np.full((48, 64, 3), 10 * level, np.uint8))
    writer.release()
    return path


def source_of(path, said=None, **options):
    return open_sources([path], SourceOptions(**options), (said if said is not None else []).append).parts[0]


def told(frames):
    return [(f.name, f.stamp_ns, round(float(f.image.mean()) / 10)) for f in frames]


def test_all_frames_come_with_their_names_and_the_videos_times(film):
    source = source_of(film)
    assert source.count == COUNT and not source.problems
    assert told(source) == [(f"film_{n:06d}", n * 100_000_000, n) for n in range(COUNT)]


@pytest.mark.parametrize("options", [{}, {"start_offset_s": 0.55, "playback_duration_s": 1.2}], ids=["all", "some"])
def test_parts_are_the_frames_of_the_whole_in_any_order(film, options):
    source = source_of(film, **options)
    parts, whole = list(source.parts(7)), told(source)
    assert [p.first for p in parts] == list(range(0, len(whole), 7)) and sum(p.count for p in parts) == len(whole)
    for order in (parts, parts[::-1], [parts[1], parts[1]]):
        assert told(f for p in order for f in source.read(p)) == [x for p in order for x in whole[p.first :][: p.count]]
    if options:
        assert [stamp for _, stamp, _ in whole] == list(range(600_000_000, 1_750_000_000, 100_000_000))


def test_a_reading_goes_on_while_parts_are_counted(film):
    source = source_of(film)
    frames, parts = iter(source), source.parts(3)
    both = [(next(frames).name, next(parts).first) for _ in range(4)]
    assert both == [(f"film_{n:06d}", 3 * n) for n in range(4)]


def test_what_is_read_once_more_to_be_drawn_is_not_decoded_from_the_start_each_time(film, monkeypatch):
    begun = []
    opened = cv2.VideoCapture
    monkeypatch.setattr(cv2, "VideoCapture", lambda *args: begun.append(args) or opened(*args))
    source = source_of(film)
    parts = list(source.parts(2))
    begun.clear()
    for part in parts:
        assert told(source.read(part)) == told(source.read(part))
    assert len(begun) <= 2


@pytest.mark.parametrize("options, count", [({}, COUNT), ({"start_offset_s": 1.0, "playback_duration_s": 0.5}, 5)])
def test_as_many_frames_as_are_asked_for_are_expected(film, options, count):
    assert source_of(film, **options).count == count


def test_what_begins_behind_the_end_is_told(film):
    said = []
    assert not list(source_of(film, said, start_offset_s=9.0))
    assert said == [f"{film}: nothing of it is read: it lasts 2.40 s, --start-offset is 9"]


def test_class_images_are_in_no_video(film):
    with pytest.raises(SourceError, match=re.escape("a video holds colours")):
        source_of(film, image_kind="labels")


@pytest.mark.parametrize("content", [None, b"", b"no video at all" * 99], ids=["none", "empty", "other"])
def test_what_is_no_video_is_named(tmp_path, content):
    path = tmp_path / "other.avi"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SourceError, match="other.avi: (there is no such file|cannot be read as a video)"):
        source_of(path)


def test_a_video_that_ends_too_early_says_so(tmp_path):
    path = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (64, 48))
    for _ in range(COUNT):
        writer.write(np.random.default_rng(1).integers(0, 255, (48, 64, 3), np.uint8))
    writer.release()
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    source = source_of(path)
    count = len(list(source))
    assert 5 < count < COUNT - 5
    (problem,) = source.problems
    assert problem.startswith(f"{path}: it ends after {count} of the ")


def test_a_bag_may_be_called_like_a_video(tmp_path):
    (tmp_path / "film.mp4").mkdir()
    with pytest.raises(SourceError, match="neither a bag"):
        open_sources([tmp_path / "film.mp4"])


def test_the_video_of_a_replay_is_no_input(tmp_path, film):
    film.rename(tmp_path / "video.mp4")
    (item,) = take_stock([tmp_path])
    assert item.error is not None and "video" not in str(item.content)


def test_inspect_looks_at_a_few_frames(film):
    (item,) = take_stock([film])
    assert item.error is None and item.content.count == COUNT and len(item.content.images) == 5


def drawn(path, count=COUNT):
    """A film of which each frame is coded by itself: one that is damaged spoils no other."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (64, 48))
    for level in range(count):
        writer.write(np.full((48, 64, 3), 10 * level, np.uint8))
    writer.release()
    return path


def damaged(path, *numbers):
    """So many frames of it are no JPEG any more."""
    data = bytearray(path.read_bytes())
    begins = [found.start() for found in re.finditer(b"\xff\xd8\xff", data)]
    assert len(begins) == COUNT
    for number in numbers:
        data[begins[number] : begins[number] + 200] = bytes(200)
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("lost", [(12,), (6, 7), (0,), (3, 4, 5, 6, 7, 8, 9, 10)], ids=str)
def test_frames_that_cannot_be_decoded_are_told_and_those_behind_them_come(tmp_path, lost):
    source = source_of(damaged(drawn(tmp_path / "film.avi"), *lost))
    frames = list(source)
    assert [f.name for f in frames] == [f"film_{n:06d}" for n in range(COUNT)]
    assert [f.stamp_ns for f in frames] == [n * 100_000_000 for n in range(COUNT)]
    assert [n for n, f in enumerate(frames) if f.error == "this frame of the video cannot be decoded"] == list(lost)
    assert told(f for f in frames if f.image is not None)[-1][2] == COUNT - 1 and not source.problems
    for size in (1, 7):  # parts may begin with a lost frame, or between two
        parts = list(source.parts(size))
        for order in (parts, parts[::-1]):
            read = [[(f.name, f.stamp_ns, f.error) for f in source.read(p)] for p in order]
            assert read == [[(f.name, f.stamp_ns, f.error) for f in frames[p.first :][: p.count]] for p in order]


def test_a_packet_is_no_frame_where_its_time_is_not_missing(film, monkeypatch):
    opened = cv2.VideoCapture

    class Stumbling:
        """Says of the 6th frame that nothing comes, as of a packet whose frame comes later."""

        def __init__(self, path):
            self.video, self.asked = opened(path), 0

        def grab(self):
            self.asked += 1
            return self.asked != 6 and self.video.grab()

        def __getattr__(self, name):
            return getattr(self.video, name)

    monkeypatch.setattr(cv2, "VideoCapture", Stumbling)
    assert told(source_of(film)) == [(f"film_{n:06d}", n * 100_000_000, n) for n in range(COUNT)]


def test_inspect_counts_frames_and_tells_those_that_are_lost(tmp_path):
    (item,) = take_stock([damaged(drawn(tmp_path / "film.avi"), 3)])
    assert item.content.count == COUNT
    assert item.content.problems == ("film_000003: this frame of the video cannot be decoded",)
    path = drawn(tmp_path / "cut.avi")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    (item,) = take_stock([path])
    (problem,) = item.content.problems
    assert item.content.count < COUNT and problem.startswith(f"it ends after {item.content.count} of the ")


@pytest.mark.parametrize(
    "name, content, way_out",
    [
        ("a.mp4", b"", ": it is empty; record it again"),
        ("a.mp4", b"no" * 99, "was not finished (its index is written last), or holds no picture; convert it (ffmpeg"),
        ("a.avi", b"no" * 99, ": it is damaged, or holds no picture; convert it (ffmpeg -i IN OUT.mp4), or record"),
    ],
)
def test_of_what_is_no_video_the_way_out_is_told(tmp_path, name, content, way_out):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SourceError, match=re.escape(way_out)):
        source_of(tmp_path / name)

"""However a source is cut into parts, the frames are those of the iteration of all, calibrations included."""

from __future__ import annotations

from pathlib import Path

import cv2
import pytest

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.io.sources.opening import SourceOptions, open_sources

SIZE = (8, 6)  # width, height


def described(frame):
    camera = frame.camera and (float(frame.camera.matrix[0, 0]), frame.camera.frame_id)
    image = None if frame.image is None else frame.image.tobytes()
    return frame.stamp_ns, frame.name, image, camera, frame.error


def check(path: Path, options: SourceOptions | None = None, sizes=(1, 2, 3, 7, 100)) -> int:
    """How many frames there are."""
    with open_sources([path], options) as sources:
        (source,) = sources.parts
        whole = [described(f) for f in source]
        for size in sizes:
            parts = list(source.parts(size))
            assert [p.first for p in parts] == list(range(0, len(whole), size))
            assert sum(p.count for p in parts) == len(whole)
            for part in reversed(parts):
                assert [described(f) for f in source.read(part)] == whole[part.first : part.first + part.count]
    return len(whole)


@pytest.fixture
def script(ros2, pictures):
    """Images of which several have one time of recording, and calibrations that change between them."""
    times = [10, 20, 20, 20, 30, 40, 40, 50, 60, 60, 70]
    said = []
    for i, (t, image) in enumerate(zip(times, pictures(len(times), SIZE[::-1]), strict=True)):
        if i in (2, 3, 7):
            said.append(("/cam/camera_info", t, ros2.info(t, 100.0 + i, SIZE)))
        if i == 5:
            said.append(("/cam/image", t, ros2.image(t, image, height=600)))  # damaged
        said.append(("/cam/image", t, ros2.image(t, image)))
    return said


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_bags(tmp_path, script, write_rosbag2, storage):
    assert check(write_rosbag2(tmp_path / "bag", script, storage)) == 12


def test_the_rest_of_a_bag(tmp_path, script, write_rosbag2):
    path = write_rosbag2(tmp_path / "bag", script)
    assert check(path, SourceOptions(start_offset_s=10e-9, playback_duration_s=31e-9)) == 8


def test_ros1_bags(tmp_path, ros1, pictures, write_rosbag1):
    script = [("/cam/image", 10 * (1 + i // 2), ros1.image(i + 1, p)) for i, p in enumerate(pictures(9))]
    assert check(write_rosbag1(tmp_path / "b.bag", script, chunk_bytes=100)) == 9


def test_a_bag_that_lost_its_index(tmp_path, script, write_rosbag2):
    file = write_rosbag2(tmp_path / "bag", script) / "bag.mcap"
    data = file.read_bytes()
    file.write_bytes(data[: int(len(data) * 0.6)])
    assert check(file) > 0


def test_bags_in_files_that_overlap_in_time(tmp_path, script, write_rosbag2):
    both = tmp_path / "both"
    both.mkdir()
    for i, part in enumerate((script[:9], script[6:])):
        (write_rosbag2(tmp_path / f"b{i}", part) / f"b{i}.mcap").rename(both / f"{i}.mcap")
    assert check(both) == 12 + sum(topic == "/cam/image" for topic, _, _ in script[6:9])


def test_folders(tmp_path, pictures):
    for i, image in enumerate(pictures(7)):
        cv2.imwrite(str(tmp_path / f"{i}.png"), image)
    (tmp_path / "3.png").write_bytes(b"none")
    assert check(tmp_path) == 7
    assert check(tmp_path, SourceOptions(start_offset_s=0.1)) == 4


def test_an_index_saves_reading_from_the_start(tmp_path, script, write_rosbag2):
    """Of frames recorded at one time, a part begins at the first of them."""
    with open_sources([write_rosbag2(tmp_path / "bag", script)]) as sources:
        parts = list(sources.parts[0].parts(3))
    assert [(p.from_ns, p.skip) for p in parts] == [(10, 0), (20, 2), (40, 1), (60, 0)]
    assert all(len(p.cameras) == p.count and isinstance(p.cameras[0], Camera) for p in parts)

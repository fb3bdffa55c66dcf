"""What `artrec studio` begins with: frames of bags, videos and folders as files."""

from __future__ import annotations

import dataclasses
import socket
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from studio_pictures import Pictures
from studio_sitting import again

from artrec_ros.core.base.errors import ArtrecError, ImageError, SourceError
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.images.decoding import read_image
from artrec_ros.io.sources.frames import Frame
from artrec_ros.io.sources.opening import SourceOptions
from artrec_ros.tools.main import main
from artrec_ros.tools.studio_state.ros import Ros
from artrec_ros.tools.studio_state.session import Session
from artrec_ros.tools.studio_state.stills import live_stills, open_stills

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


def test_what_a_bag_lacks_is_told(tmp_path: Path) -> None:
    simulated = ["simulate", str(ROOT / "config/objects/excavator.yaml"), "--frames", "5", "-o", str(tmp_path / "sim")]
    assert main(simulated) == 0
    file = tmp_path / "sim/bag/bag.mcap"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    stills = open_stills(tmp_path / "sim/bag", SourceOptions(image_kind="labels"), 3, tmp_path / "frames", print)
    assert any(line.startswith(f"{file}: it ends in the middle") for line in stills.problems)


def test_doubts_about_a_bags_calibration_are_problems(tmp_path: Path) -> None:
    """As a replay tells them."""
    of_right = dataclasses.replace(CAMERA, frame_id="right")
    for name, infos, told in (
        ("other", [of_right], "/eye/camera_info is of frame 'right', images are of 'left': it is used, though"),
        ("none", [], "no topic '/eye/camera_info': without calibration there are no metric poses"),
    ):
        with BagWriter(tmp_path / name) as writer:
            for camera in infos:
                writer.write_camera("/eye/camera_info", 1, camera)
            writer.write_image("/eye/image", 2, "left", GREY)
        (problem,) = open_stills(tmp_path / name, SourceOptions(), 3, tmp_path / f"{name}_frames", print).problems
        assert told in problem


@pytest.mark.parametrize("folder", [".", "http:x"])
def test_a_video_is_a_source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: str) -> None:
    monkeypatch.chdir(tmp_path)
    film = Path(folder) / "film.mp4"
    film.parent.mkdir(exist_ok=True)
    writer = cv2.VideoWriter(str(film.absolute()), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (64, 48))
    for level in range(6):
        writer.write(np.full((48, 64, 3), 40 * level, np.uint8))
    writer.release()
    stills = open_stills(film, SourceOptions(), 3, tmp_path / "frames", print)
    assert stills.stamps_ns == [0, 200_000_000, 400_000_000]
    assert abs(float(stills.image(2).mean()) - 160) < 6


@pytest.mark.parametrize("name", ["none", "none.mp4"])
def test_a_source_that_is_not_there_is_named(name: str, tmp_path: Path) -> None:
    with pytest.raises(SourceError, match=name):
        open_stills(tmp_path / name, SourceOptions(), 3, tmp_path / "frames", print)


def test_without_ros_a_live_topic_is_refused_in_one_line(
    pictures: Pictures, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("nicegui", reason="NiceGUI is not installed (extra studio)")
    for name in [n for n in sys.modules if n.startswith("artrec_ros.node.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "rclpy", None)
    arguments = ["--params-file", str(pictures.parameters), "-o", str(tmp_path / "studio")]
    assert main(["studio", "--topic", "/camera/image_raw", *arguments]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "ROS 2 is missing" in line and "source one, or install artrec_ros" in line
    with pytest.raises(ArtrecError, match="ROS 2 is missing"):
        Ros().parameters()
    assert main(["studio", *arguments]) == 1
    assert "SOURCE is missing: name a folder, bag or video, or with --topic a live one" in capsys.readouterr().err


CAMERA = Camera(np.array([[90.0, 0, 32], [0, 90, 24], [0, 0, 1]]), np.zeros(5), (64, 48))
GREY = np.full((48, 64, 3), 90, np.uint8)


def taken(stamp_ns: int, camera: Camera | None = None) -> Frame:
    return Frame(stamp_ns, "/camera/image_raw", GREY, camera)


def test_windows_that_ask_at_once_share_one_part_in_the_graph(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []

    class Slow:
        def __init__(self, name: str) -> None:
            time.sleep(0.1)
            made.append(name)

        def close(self) -> None:
            made.pop()

    modules = SimpleNamespace(Graph=Slow, RemoteParameters=lambda graph: graph)
    monkeypatch.setattr("artrec_ros.tools.studio_state.ros._module", lambda name: modules)
    ros = Ros()
    with ThreadPoolExecutor(4) as pool:
        asked = [pool.submit(ros.parameters) for _ in range(4)]
        assert len({id(a.result()) for a in asked}) == 1 == len(made)
    ros.close()
    assert not made


def test_frames_that_are_taken_are_files_and_there_again(tmp_path: Path) -> None:
    folder = tmp_path / "frames"
    live = Topic([taken(1_700_000_000_000_000_005)])
    said: list[str] = []
    stills = live_stills(live, SourceOptions(), folder, said.append)
    assert said == ["waiting for an image on /camera/image_raw"] and stills.camera is None
    assert stills.add(taken(1_700_000_000_000_000_009, CAMERA)) == 1
    assert stills.add(taken(1_700_000_000_000_000_005)) == 0, "it was taken before"
    assert len(stills) == 2 and stills.camera is CAMERA and (folder / "camera.yaml").is_file()
    with pytest.raises(ImageError, match="damaged"):
        stills.add(Frame(7, "x", error="damaged"))
    other = dataclasses.replace(CAMERA, matrix=CAMERA.matrix * [[1.5, 1, 1], [1, 1.5, 1], [1, 1, 1]])
    with pytest.raises(ImageError, match=r"another one than in .*camera.yaml: begin a new sitting"):
        stills.add(taken(1_700_000_000_000_000_011, other))
    once_more = live_stills(Topic([]), SourceOptions(), folder, said.append)
    assert len(said) == 1 and once_more.files == stills.files and once_more.stamps_ns == stills.stamps_ns
    assert once_more.camera is not None and once_more.camera.sees_as(CAMERA)
    np.testing.assert_array_equal(once_more.image(1), GREY)
    given = live_stills(Topic([]), SourceOptions(camera=other), folder, print)
    given.add(taken(1_700_000_000_000_000_011, CAMERA))
    assert given.camera is other, "what --camera-info names goes before"


def test_a_calibration_for_images_of_another_size_is_told_and_not_used(tmp_path: Path) -> None:
    for number, size in enumerate([(48, 64), (24, 32)]):
        cv2.imwrite(str(tmp_path / f"{number}.png"), np.zeros(size, np.uint8))
    fits = open_stills(tmp_path, SourceOptions(camera=CAMERA), 9, tmp_path / "frames", print)
    assert fits.camera is CAMERA and not fits.problems
    assert fits.camera_of(0) is CAMERA and fits.camera_of(1) is None
    (tmp_path / "0.png").write_bytes(b"damaged")
    unfit = open_stills(tmp_path, SourceOptions(camera=CAMERA), 9, tmp_path / "frames", print)
    assert unfit.camera is None
    assert unfit.problems == [
        "--camera-info: calibrated for 64x48 pixels, but images have 32x24: no metric poses; give a calibration of "
        "that size, or fx, fy, cx, cy of this one times 0.5 where they were scaled"
    ]


def test_images_are_looked_at_by_several_threads(tmp_path: Path) -> None:
    for number in range(40):
        cv2.imwrite(str(tmp_path / f"{number:02d}.png"), np.full((4, 4), number, np.uint8))
    stills = open_stills(tmp_path, SourceOptions(), 99, tmp_path / "frames", print)

    def look(seed: int) -> bool:
        numbers = np.random.default_rng(seed).integers(0, 40, 2000).tolist()
        return all(int(stills.image(n)[0, 0]) == n for n in numbers)

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-7)
    try:
        with ThreadPoolExecutor(8) as pool:
            assert all(pool.map(look, range(8)))
    finally:
        sys.setswitchinterval(before)


def test_frames_of_an_earlier_sitting_go_before_and_are_told(
    pictures: Pictures, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("nicegui", reason="NiceGUI is not installed (extra studio)")
    output = tmp_path / "studio"
    live_stills(Topic([taken(1_700_000_000_000_000_005)]), SourceOptions(), output / "frames", print)
    with socket.socket() as other:  # a port in use ends it before the page is served
        other.bind(("127.0.0.1", 0))
        other.listen()
        where = ["--params-file", str(pictures.parameters), "-o", str(output), "--port", str(other.getsockname()[1])]
        assert main(["studio", str(tmp_path / "film.mp4"), *where]) == 1
        told = f"going on with what is in {output / 'frames'} (1), not with {tmp_path / 'film.mp4'}"
        assert told in capsys.readouterr().err
        assert main(["studio", str(pictures.source), *where]) == 1
        assert "going on" not in capsys.readouterr().err, "a folder of images is looked at where it lies"


def test_a_first_image_that_cannot_be_used_is_told(tmp_path: Path) -> None:
    live = Topic([Frame(5, "/camera/image_raw", error="encoding 'yuv' is none of mono8")])
    with pytest.raises(SourceError, match="--topic /camera/image_raw: encoding 'yuv'"):
        live_stills(live, SourceOptions(), tmp_path / "frames", print)


def test_a_calibration_that_comes_later_is_used_from_then_on(
    pictures: Pictures, taught: Session, tmp_path: Path
) -> None:
    session = again(taught, tmp_path, pictures)
    session.stills = live_stills(Topic([taken(1_700_000_000_000_000_005)]), SourceOptions(), tmp_path / "f", print)
    session.recognise(0)
    assert session.known([0])
    assert session.take(taken(1_700_000_000_000_000_006, CAMERA)) == 1
    assert not session.known([0]) and session.stills.camera is CAMERA


def test_a_frame_is_taken_while_another_is_recognised(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    session.stills = live_stills(Topic([taken(1_700_000_000_000_000_005)]), SourceOptions(), tmp_path / "f", print)
    with ThreadPoolExecutor(1) as pool, session._lock:  # as of a thread that recognises, or has code compiled first
        number = pool.submit(session.take, taken(1_700_000_000_000_000_006))
        assert number.result(timeout=20) == 1


class Topic:
    """A topic whose images are frames already."""

    topic, graph = "/camera/image_raw", None

    def __init__(self, frames: list[Frame]) -> None:
        self._frames = frames

    def held(self) -> tuple[Frame, ...]:
        return tuple(self._frames)

    def frame(self, held: Frame) -> Frame:
        return held

    def state(self) -> str:
        return self.topic

    def wait(self, patience_s: float) -> None:
        assert self._frames, "what was taken before is enough"

    def close(self) -> None:
        pass

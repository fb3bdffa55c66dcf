"""An image of a bag has the calibration of its own stamp and camera, wherever that was recorded."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from artrec_ros.io.bags.heads import head_of
from artrec_ros.io.bags.infos import Info, Infos
from artrec_ros.io.bags.reader import Bag
from artrec_ros.io.bags.recovery import RawMessage
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.sources.look_ahead import LookAhead, own_first
from artrec_ros.io.sources.opening import SourceOptions, open_sources

STEP_NS = 33_333_333
FIRST_NS = 17 * 10**17
SIZE = (8, 6)
FOCALS = [300.0 + 10 * i for i in range(30)]


def stamp_of(i: int) -> int:
    return FIRST_NS + i * STEP_NS


def framed(message, frame_id):
    msgtype, content = message
    return msgtype, dataclasses.replace(content, header=dataclasses.replace(content.header, frame_id=frame_id))


def script(messages, pixels, late_ns, frames=("optical", "optical")):
    """Images at their stamps, and each one's calibration so much later; below zero: earlier."""
    said = []
    for i, focal in enumerate(FOCALS):
        said.append(("/cam/image", stamp_of(i), framed(messages.image(stamp_of(i), pixels), frames[0])))
        info = framed(messages.info(stamp_of(i), focal, SIZE), frames[1])
        said.append(("/cam/camera_info", stamp_of(i) + late_ns, info))
    return sorted(said, key=lambda s: s[1])


def focals(path, **options):
    with open_sources([path], SourceOptions(**options)) as sources:
        (source,) = sources.parts
        found = [float(f.camera.matrix[0, 0]) for f in source]
        for size in (1, 4, 7, 100):
            parts = list(source.parts(size))
            again = [[float(f.camera.matrix[0, 0]) for f in source.read(part)] for part in reversed(parts)]
            assert sum(reversed(again), []) == found, "parts tell something else"
        return found, source.problems


@pytest.mark.parametrize("late_ns", [-2 * 10**8, -1, 1, 5 * 10**6, 4 * 10**8])
@pytest.mark.parametrize("generation", ["ros1", "ros2"])
def test_that_of_the_images_stamp_is_taken(
    tmp_path, ros1, ros2, pictures, write_rosbag1, write_rosbag2, generation, late_ns
):
    pixels = pictures(1, SIZE[::-1])[0]
    if generation == "ros1":
        path = write_rosbag1(tmp_path / "a.bag", script(ros1, pixels, late_ns), chunk_bytes=200)
    else:
        path = write_rosbag2(tmp_path / "bag", script(ros2, pixels, late_ns))
    assert focals(path) == (FOCALS, [])


def test_a_cut_costs_no_image_its_own(tmp_path, ros2, pictures, write_rosbag2):
    for late_ns in (-(10**8), 10**8):
        path = write_rosbag2(tmp_path / f"bag{late_ns}", script(ros2, pictures(1, SIZE[::-1])[0], late_ns))
        starts_ns = FIRST_NS + min(late_ns, 0)
        begin, end = ((stamp_of(i) - starts_ns - 1) * 1e-9 for i in (10, 20))
        found, _ = focals(path, start_offset_s=begin, playback_duration_s=end - begin)
        assert found == FOCALS[10:20]


def test_too_late_a_one_is_not_waited_for(tmp_path, ros2, pictures, write_rosbag2):
    """Nothing but the newest before it can be told of an image then."""
    path = write_rosbag2(tmp_path / "bag", script(ros2, pictures(1, SIZE[::-1])[0], 20 * STEP_NS + 5))
    found, _ = focals(path)
    assert found[:13] == [300.0] * 13 and found[14:] == FOCALS[14:], "at the end nothing keeps images from waiting"


def test_that_of_the_images_camera_goes_before_a_newer_one(tmp_path, ros2, pictures, write_rosbag2):
    pixels = pictures(1, SIZE[::-1])[0]
    said = script(ros2, pixels, -5, ("left", "left"))
    said += [(topic, t + 1, framed(ros2.info(t, 900.0, SIZE), "right")) for topic, t, _ in said if "info" in topic]
    path = write_rosbag2(tmp_path / "bag", sorted(said, key=lambda s: s[1]))
    assert focals(path) == (FOCALS, [])


def test_another_cameras_is_used_and_told_once(tmp_path, ros2, pictures, write_rosbag2):
    path = write_rosbag2(tmp_path / "bag", script(ros2, pictures(1, SIZE[::-1])[0], 5, ("left", "right")))
    found, (problem,) = focals(path)
    assert found == FOCALS and "/cam/camera_info is of frame 'right', images are of 'left'" in problem
    for frames in (("left", ""), ("", "right")):
        path = write_rosbag2(tmp_path / "_".join(frames), script(ros2, pictures(1, SIZE[::-1])[0], 5, frames))
        assert focals(path) == (FOCALS, []), "nobody says that it is another's"


@pytest.mark.parametrize("late_ns", [-(2 * 10**8), -1, 1, 5 * 10**6, 4 * 10**8])
def test_an_image_that_is_answered_before_the_next_is_sent_goes_behind_its_own(
    tmp_path, ros2, pictures, write_rosbag2, late_ns
):
    path = write_rosbag2(tmp_path / "bag", script(ros2, pictures(1, SIZE[::-1])[0], late_ns))
    with Bag(path) as bag:
        recorded = list(bag.messages(bag.topics))
        sent = list(own_first(recorded, bag.messages(["/cam/camera_info"])))
        for i, _ in enumerate(FOCALS):
            one, other = (n for n, m in enumerate(sent) if head_of(m.data, m.log_ns).stamp_ns == stamp_of(i))
            assert "info" in sent[one].topic and sent[other].topic == "/cam/image", "and none is sent twice"
        times = [m.log_ns for m in sent]
        assert times == sorted(times), "clocks do not go back"
        assert sorted(m.data for m in sent) == sorted(m.data for m in recorded)


@pytest.mark.parametrize("generation", ["ros1", "ros2"])
def test_the_head_is_that_of_the_whole_message(ros1, ros2, generation):
    messages = ros1 if generation == "ros1" else ros2
    store = messages.store
    write = store.serialize_ros1 if messages.ros1 else store.serialize_cdr
    for frame_id in ("", "a", "ündër/die"):
        msgtype, content = framed(messages.image(FIRST_NS, np.zeros((2, 3), np.uint8)), frame_id)
        raw = RawMessage("/i", msgtype, 5, bytes(write(content, msgtype)))
        assert head_of(raw.data, raw.log_ns, messages.ros1)[:2] == (FIRST_NS, frame_id)
        for length in range(20):
            stamp_ns, name, _ = head_of(raw.data[:length], raw.log_ns, messages.ros1)
            assert stamp_ns in (5, FIRST_NS) and isinstance(name, str)


def test_an_image_that_is_damaged_keeps_its_stamp(tmp_path, ros2):
    msgtype, content = ros2.image(FIRST_NS, np.zeros((2, 3), np.uint8))
    with BagWriter(tmp_path / "bag") as writer:
        writer.write_raw("/i", 5, msgtype, bytes(ros2.store.serialize_cdr(content, msgtype))[:30])
    with open_sources([tmp_path / "bag"], SourceOptions()) as sources:
        (frame,) = sources
    assert frame.error and frame.stamp_ns == FIRST_NS


def test_bytes_in_the_other_order(ros2):
    msgtype, content = framed(ros2.image(FIRST_NS, np.zeros((2, 3), np.uint8)), "eye")
    data = bytes(ros2.store.serialize_cdr(content, msgtype, little_endian=False))
    assert head_of(data, 5)[:2] == (FIRST_NS, "eye")


def test_many_cameras_do_not_pile_up():
    infos = Infos[int]()
    for i in range(1000):
        infos.add(Info(i, f"eye{i}", i))
    assert infos.newest("eye3") is None and infos.newest("eye999").content == 999
    assert infos.choose(3, "eye3").content == 999, "the newest of all, where the camera's own is none of them"


def test_images_that_wait_their_turn_keep_calibrations_that_came_after_stamps_went_back():
    infos, stamps, late = Infos[int](), [100 * 10**9 + n * 10**8 for n in range(30)], 15
    images = [*stamps, *stamps]
    for n, stamp in enumerate(images):
        infos.add(Info(stamp, "eye", n))
        if n >= late:
            infos.meet(images[n - late], "eye")
        if n >= late + len(stamps):
            assert infos.choose(images[n - late], "eye").content == n - late


def test_a_recording_in_which_the_clock_was_set_back_has_none_of_the_same_stamp_from_before():
    ahead, found = LookAhead[str](), []
    for log_ns, stamp in enumerate([100 * 10**9, 102 * 10**9] * 2):
        found += ahead.add_image(RawMessage("/i", "", log_ns, b""), stamp, "eye")
        found += ahead.add_info(Info(stamp, "eye", f"{log_ns}"), log_ns)
    assert [held.info.content for held in found] == ["0", "1", "2", "3"]

"""Sources give every image in order with its stamp and calibration, and say in one line what they cannot give."""

from __future__ import annotations

import os

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import SourceError
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.io.images.decoding import IMAGE_SUFFIXES
from artrec_ros.io.sources.opening import SourceOptions, open_sources, stamps_by_name

STEP_NS = 10**8
HEADER_NS = 5 * 10**9  # headers are stamped so much later than the recording


def read(paths, said=None, **options):
    with open_sources(paths, SourceOptions(**options), None if said is None else said.append) as sources:
        frames = list(sources)
        return frames, sources


def labels_and_colours(messages, pixels):
    """A bag's script: label images, colour images of another topic, and a calibration that comes after the first."""
    script = []
    for i, p in enumerate(pixels):
        t = (i + 1) * STEP_NS
        script += [("/cam/labels", t, messages.image(t + HEADER_NS, p))]
        script += [("/cam/colour/compressed", t, messages.compressed(t + HEADER_NS, np.dstack([p] * 3)))]
        script += [("/cam/camera_info", t + 1, messages.info(t, 100.0 + i, (8, 6)))]
    return script


@pytest.fixture
def two_topics(tmp_path, ros2, pictures, write_rosbag2):
    pixels = pictures(3)
    return write_rosbag2(tmp_path / "bag", labels_and_colours(ros2, pixels)), pixels


def test_frames_come_with_header_stamp_topic_pixels_and_the_newest_calibration(two_topics):
    frames, sources = read([two_topics[0]], topic="/cam/labels")
    assert sources.count == 3 and sources.problems == []
    assert [f.stamp_ns for f in frames] == [i * STEP_NS + HEADER_NS for i in (1, 2, 3)]
    assert {f.name for f in frames} == {"/cam/labels"}
    assert np.array_equal([f.image for f in frames], two_topics[1])
    assert [f.camera.matrix[0, 0] for f in frames] == [100, 100, 101]  # the first came before any: the nearest holds
    assert {f.camera.frame_id for f in frames} == {"optical"}


def test_ros1_bags_have_calibrations_too(tmp_path, ros1, pictures, write_rosbag1):
    pixels = pictures(3)
    frames, _ = read([write_rosbag1(tmp_path / "a.bag", labels_and_colours(ros1, pixels))], topic="/cam/labels")
    assert np.array_equal([f.image for f in frames], pixels)
    assert [f.camera.matrix[0, 0] for f in frames] == [100, 100, 101]


@pytest.mark.parametrize(("kind", "topic"), [("labels", "/cam/labels"), ("colour", "/cam/colour/compressed")])
def test_of_several_topics_the_one_that_fits_the_kind_is_taken_and_told(two_topics, kind, topic):
    said = []
    frames, _ = read([two_topics[0]], said, image_kind=kind)
    assert {f.name for f in frames} == {topic}
    assert all(f.camera is not None for f in frames)
    assert len(said) == 1 and topic in said[0]


def test_of_several_fitting_topics_none_is_guessed(tmp_path, ros2, pictures, write_rosbag2):
    script = [(topic, STEP_NS, ros2.image(STEP_NS, pictures(1)[0])) for topic in ("/a", "/b")]
    with pytest.raises(SourceError, match=r"--topic.*/a .*/b ") as caught:
        read([write_rosbag2(tmp_path / "bag", script)], image_kind="labels")
    assert "\n" not in str(caught.value)


def test_wrong_topics_are_refused_with_what_there_is(two_topics):
    with pytest.raises(SourceError, match="no topic '/nothing'. Image topics: /cam/colour/compressed"):
        read([two_topics[0]], topic="/nothing")
    with pytest.raises(SourceError, match="'/cam/camera_info' is sensor_msgs/msg/CameraInfo, no image"):
        read([two_topics[0]], topic="/cam/camera_info")
    with pytest.raises(SourceError, match="no topic '/nothing'"):
        read([two_topics[0]], topic="/cam/labels", camera_info_topic="/nothing")
    with pytest.raises(SourceError, match="'/cam/labels' is sensor_msgs/msg/Image, no calibration"):
        read([two_topics[0]], topic="/cam/labels", camera_info_topic="/cam/labels")


def test_a_bag_without_images_lists_what_there_is(tmp_path, ros2, write_rosbag2):
    bag = write_rosbag2(tmp_path / "bag", [("/cam/camera_info", STEP_NS, ros2.info(STEP_NS, 100, (8, 6)))])
    with pytest.raises(SourceError, match="no image topic. Topics: /cam/camera_info"):
        read([bag])


def test_offset_and_duration_cut_each_source(two_topics):
    frames, _ = read([two_topics[0]] * 2, topic="/cam/labels", start_offset_s=0.1, playback_duration_s=0.1)
    assert [f.stamp_ns - HEADER_NS for f in frames] == [2 * STEP_NS] * 2
    assert frames[0].camera is not None


@pytest.mark.parametrize(
    ("focal_px", "size", "said"), [(0.0, (8, 6), "not calibrated"), (100.0, (16, 12), "calibrated for 16x12")]
)
def test_an_unfit_calibration_is_told_once_and_not_used(tmp_path, ros2, pictures, write_rosbag2, focal_px, size, said):
    script = [("/cam/camera_info", t * STEP_NS, ros2.info(0, focal_px, size)) for t in (1, 2, 3)]
    script += [("/cam/image", t * STEP_NS + 1, ros2.image(t, p)) for t, p in enumerate(pictures(3), 1)]
    warnings = []
    frames, _ = read([write_rosbag2(tmp_path / "bag", sorted(script, key=lambda s: s[1]))], warnings)
    assert len(frames) == 3 and all(f.image is not None and f.camera is None for f in frames)
    assert len(warnings) == 1 and said in warnings[0]


def test_a_calibration_file_for_another_size_is_told_once_and_not_used(tmp_path, pictures):
    for i, picture in enumerate(pictures(3)):
        cv2.imwrite(str(tmp_path / f"{i}.png"), picture)
    height, width = picture.shape[:2]
    K, warnings = np.diag((100.0, 100.0, 1.0)), []
    other = Camera(K, np.zeros(0), (2 * width, 2 * height))
    frames, _ = read([tmp_path], warnings, camera=other)
    assert [f.camera for f in frames] == [None] * 3
    assert len(warnings) == 1 and "--camera-info: calibrated for" in warnings[0] and f"{width}x{height}" in warnings[0]
    frames, _ = read([tmp_path], warnings, camera=Camera(K, np.zeros(0), (width, height)))
    assert all(f.camera.size == (width, height) for f in frames) and len(warnings) == 1


def test_a_missing_calibration_is_told_once(tmp_path, ros2, pictures, write_rosbag2):
    script = [("/cam/image", t, ros2.image(t, p)) for t, p in enumerate(pictures(2), 1)]
    warnings = []
    frames, _ = read([write_rosbag2(tmp_path / "bag", script)], warnings)
    assert [f.camera for f in frames] == [None, None]
    assert len(warnings) == 1 and "/cam/camera_info" in warnings[0]


def test_an_unusable_image_is_a_frame_with_its_error(tmp_path, ros2, pictures, write_rosbag2):
    good = pictures(1)[0]
    short = ros2.image(2, good, data=np.zeros(30, np.uint8))
    bag = write_rosbag2(tmp_path / "bag", [("/i", 1, ros2.image(1, good)), ("/i", 2, short)])
    (first, second), _ = read([bag])
    assert first.error is None and np.array_equal(first.image, good)
    assert second.image is None and second.stamp_ns == 2 and "30 bytes" in second.error


def test_an_unset_stamp_is_replaced_by_the_time_of_recording(tmp_path, ros2, pictures, write_rosbag2):
    (frame,), _ = read([write_rosbag2(tmp_path / "bag", [("/i", 77, ros2.image(0, pictures(1)[0]))])])
    assert frame.stamp_ns == 77


def save(folder, names, pictures):
    folder.mkdir()
    pixels = pictures(len(names))
    for name, p in zip(names, pixels, strict=True):
        cv2.imwrite(str(folder / name), p)
    return pixels


def test_folders_are_read_in_natural_order_at_a_rate(tmp_path, pictures):
    pixels = save(tmp_path / "f", ["a1.png", "a2.PNG", "a10.png"], pictures)
    (tmp_path / "f" / "notes.txt").write_text("no image")
    frames, sources = read([tmp_path / "f"], rate_hz=10.0)
    assert [f.name for f in frames] == ["a1.png", "a2.PNG", "a10.png"]
    assert [f.stamp_ns for f in frames] == [0, STEP_NS, 2 * STEP_NS]
    assert np.array_equal([f.image for f in frames], pixels)
    assert sources.count == 3


def test_names_of_sixteen_digits_are_stamps(tmp_path, pictures):
    names = ["1700000000000000000.png", "1700000000500000000.png"]
    save(tmp_path / "f", names, pictures)
    frames, _ = read([tmp_path / "f"], start_offset_s=0.2)
    assert [f.stamp_ns for f in frames] == [1700000000500000000]


@pytest.mark.parametrize("first", ["9" * 26, "2147483648000000000"])
def test_names_beyond_all_stamps_are_names(tmp_path, pictures, first):
    """A stamp's seconds have 32 bits."""
    save(tmp_path / "f", [f"{first}.png", "1700000000500000000.png"], pictures)
    frames, _ = read([tmp_path / "f"])
    assert [f.stamp_ns for f in frames] == [0, 33333333]
    assert stamps_by_name(sorted((tmp_path / "f").iterdir())) == []


def test_a_name_that_is_no_text_is_told_as_text(tmp_path, pictures):
    save(tmp_path / "f", ["0.png", "1.png"], pictures)
    try:
        (tmp_path / "f" / "1.png").rename(os.fsdecode(os.fsencode(tmp_path / "f") + b"/1\xff.png"))
    except OSError:
        pytest.skip("this file system has none but UTF-8 names")
    (tmp_path / "f" / "0.png").write_bytes(b"\x89PNG")
    frames, _ = read([tmp_path / "f"])
    assert [f.name for f in frames] == ["0.png", "1\\xff.png"] and frames[1].image is not None


def test_a_damaged_file_among_good_ones_is_a_frame_with_its_error(tmp_path, pictures):
    save(tmp_path / "f", ["0.png", "1.png", "2.png"], pictures)
    (tmp_path / "f" / "1.png").write_bytes(b"\x89PNG")
    frames, _ = read([tmp_path / "f"])
    assert [f.error is None for f in frames] == [True, False, True]


def test_a_given_camera_goes_before_the_bags(two_topics):
    camera = Camera(np.diag([50.0, 50.0, 1.0]), np.zeros(0), (8, 6), "other")
    frames, _ = read([two_topics[0]], topic="/cam/labels", camera=camera)
    assert [f.camera.matrix[0, 0] for f in frames] == [50, 50, 50]


def test_sources_follow_one_another(tmp_path, two_topics, pictures):
    save(tmp_path / "f", ["0.png"], pictures)
    frames, sources = read([tmp_path / "f", two_topics[0]], topic="/cam/labels")
    assert [f.name for f in frames] == ["0.png"] + ["/cam/labels"] * 3
    assert sources.count == 4


def test_a_folder_without_images_or_bags_is_refused(tmp_path):
    with pytest.raises(SourceError, match=r"neither a bag .*\)$"):
        read([tmp_path])


def test_files_of_other_kinds_in_a_folder_are_told_once(tmp_path, pictures):
    save(tmp_path / "images", ["0.png", "1.webp"], pictures)
    said = []
    for name in ("a.tif", "b.TIF", "c.gif", "notes.txt", "camera.yaml", ".hidden", "none"):
        (tmp_path / "images" / name).touch()
    (tmp_path / "images" / "folder.tif").mkdir()
    with open_sources([tmp_path / "images"], report=said.append) as sources:
        (source,) = sources.parts
        assert len(list(source.read(next(source.parts(10))))) == len(list(source)) == 2
    assert said == [
        f"{tmp_path / 'images'}: passed over: 1 .gif, 2 .tif, 1 without suffix; images are {', '.join(IMAGE_SUFFIXES)}"
    ]
    (tmp_path / "images" / "0.png").unlink()
    (tmp_path / "images" / "1.webp").unlink()
    with pytest.raises(SourceError, match="; it holds 1 .gif, 2 .tif, 1 without suffix$"):
        read([tmp_path / "images"])


def test_a_video_in_a_folder_is_to_be_named(tmp_path):
    (tmp_path / "film.MP4").touch()
    with pytest.raises(SourceError, match="give a video in it by its name: .*film.MP4"):
        read([tmp_path])


def test_images_one_level_below_are_pointed_at(tmp_path, pictures):
    save(tmp_path / "recorded", ["0.png"], pictures)
    (tmp_path / "film.mp4").touch()
    (tmp_path / "run.sh").touch()
    with pytest.raises(SourceError, match="look in .*recorded$"):
        read([tmp_path])


def test_a_truncated_bag_gives_its_frames_and_then_says_so(tmp_path, ros2, pictures, write_rosbag2):
    script = [("/i", t, ros2.image(t, p)) for t, p in enumerate(pictures(300, (64, 64)), 1)]
    file = write_rosbag2(tmp_path / "bag", script) / "bag.mcap"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    frames, sources = read([file])
    assert 50 < len(frames) < 300
    assert len(sources.problems) == 1 and "truncated" in sources.problems[0]

"""Bags in every form give their messages; damaged ones give what is left and one line that says so."""

from __future__ import annotations

import os
import re
import shutil
import sqlite3
import sys
from pathlib import Path

import numpy as np
import pytest
from rosbags import rosbag1, rosbag2
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionMode
from rosbags.typesys import Stores, get_typestore

from artrec_ros.core.base.errors import ImageError, SourceError
from artrec_ros.io.bags.reader import Bag, bag_files
from artrec_ros.io.bags.topics import choose_topic

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

STEP_NS = 10**8
THIRD_PARTY = Path(os.environ.get("ARTREC_SHARED", Path(__file__).parents[3] / "shared")) / "data" / "bags"


def script(messages, pixels, start=0):
    return [("/image", t, messages.image(t, p)) for i, p in enumerate(pixels) for t in [start + (i + 1) * STEP_NS]]


def images(bag: Bag) -> list[np.ndarray]:
    parsed = [bag.parse(m) for m in bag.messages(["/image"])]
    return [np.asarray(p.data).reshape(p.height, p.width) for p in parsed]


def assert_all(path: Path, pixels, problems=0):
    with Bag(path) as bag:
        assert bag.topics["/image"].count == len(pixels)
        assert bag.start_ns == STEP_NS
        assert np.array_equal(images(bag), pixels)
        assert len(bag.problems) == problems


@pytest.mark.parametrize(
    ("storage", "compression"),
    [
        ("mcap", None),
        ("sqlite3", None),
        ("mcap", CompressionMode.STORAGE),
        ("mcap", CompressionMode.MESSAGE),
        ("sqlite3", CompressionMode.MESSAGE),
        ("sqlite3", CompressionMode.FILE),
        ("mcap", CompressionMode.FILE),
    ],
)
def test_rosbag2_with_each_storage_and_compression(tmp_path, ros2, pictures, storage, compression, write_rosbag2):
    pixels = pictures(4)
    assert_all(write_rosbag2(tmp_path / "bag", script(ros2, pixels), storage, compression), pixels)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_single_file_needs_no_metadata(tmp_path, ros2, pictures, storage, write_rosbag2):
    pixels = pictures(3)
    folder = write_rosbag2(tmp_path / "bag", script(ros2, pixels), storage)
    (folder / "metadata.yaml").unlink()
    (file,) = folder.iterdir()
    assert_all(file, pixels)
    assert_all(folder, pixels)


def test_a_split_bag_is_read_in_the_order_of_time_even_without_metadata(tmp_path, ros2, pictures, write_rosbag2):
    pixels = pictures(6)
    (tmp_path / "split").mkdir()
    for part, name in enumerate(["x_2.mcap", "x_10.mcap", "x_1.mcap"]):
        whole = write_rosbag2(
            tmp_path / f"part{part}", script(ros2, pixels[2 * part : 2 * part + 2], 2 * part * STEP_NS)
        )
        shutil.move(whole / f"part{part}.mcap", tmp_path / "split" / name)
    assert_all(tmp_path / "split", pixels)


def test_ros1(tmp_path, ros1, pictures, write_rosbag1):
    pixels = pictures(4)
    assert_all(write_rosbag1(tmp_path / "a.bag", script(ros1, pixels)), pixels)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3", "ros1"])
def test_latched_topics_are_known_as_such(tmp_path, storage):
    """By the publishers' quality of service, as recorders note it."""
    path = tmp_path / ("bag.bag" if storage == "ros1" else "bag")
    kept = {"/kept": QosDurability.TRANSIENT_LOCAL, "/passing": QosDurability.VOLATILE}
    if storage == "ros1":
        store = get_typestore(Stores.ROS1_NOETIC)
        with rosbag1.Writer(path) as writer:
            for topic, durability in kept.items():
                latching = int(durability == QosDurability.TRANSIENT_LOCAL)
                noted = writer.add_connection(topic, "std_msgs/msg/Empty", typestore=store, latching=latching)
                writer.write(noted, 1, b"")
    else:
        plugin = rosbag2.StoragePlugin.MCAP if storage == "mcap" else rosbag2.StoragePlugin.SQLITE3
        store, no_time = get_typestore(Stores.ROS2_JAZZY), QosTime(0, 0)
        with rosbag2.Writer(path, version=9, storage_plugin=plugin) as writer:
            for topic, durability in kept.items():
                quality = (QosHistory(1), 1, QosReliability(1), durability, no_time, no_time)
                qos = [Qos(*quality, QosLiveliness(1), no_time, False)]
                noted = writer.add_connection(topic, "std_msgs/msg/Bool", typestore=store, offered_qos_profiles=qos)
                writer.write(noted, 1, b"\0\1\0\0\1")
    with Bag(path) as bag:
        assert {name: topic.latched for name, topic in bag.topics.items()} == {"/kept": True, "/passing": False}


def test_the_span_is_half_open(tmp_path, ros2, pictures, write_rosbag2):
    with Bag(write_rosbag2(tmp_path / "bag", script(ros2, pictures(5)))) as bag:
        times = [m.log_ns for m in bag.messages(["/image"], 2 * STEP_NS, 4 * STEP_NS)]
    assert times == [2 * STEP_NS, 3 * STEP_NS]


def cut(source: Path, target: Path, share: float) -> Path:
    data = source.read_bytes()
    target.write_bytes(data[: int(share * len(data))])
    return target


def assert_a_beginning(path: Path, pixels, least: int):
    """What is read of a damaged bag is a beginning of what was in it, and one line says that it is damaged."""
    with Bag(path) as bag:
        found = images(bag)
        (problem,) = bag.problems
    assert least <= len(found) < len(pixels)
    assert np.array_equal(found, pixels[: len(found)])
    assert str(path) in problem and "\n" not in problem


@pytest.mark.parametrize("compression", [None, CompressionMode.STORAGE])
@pytest.mark.parametrize("share", [0.3, 0.5, 0.7])
def test_a_truncated_mcap_gives_its_beginning(tmp_path, ros2, pictures, share, compression, write_rosbag2):
    pixels = pictures(600, (64, 64))
    folder = write_rosbag2(tmp_path / "bag", script(ros2, pixels), "mcap", compression)
    assert_a_beginning(cut(folder / "bag.mcap", tmp_path / "cut.mcap", share), pixels, 100)


@pytest.mark.parametrize("share", [0.5, 0.7, 0.95])
def test_a_truncated_sqlite3_gives_its_beginning(tmp_path, ros2, pictures, share, write_rosbag2):
    pixels = pictures(2000)
    folder = write_rosbag2(tmp_path / "bag", script(ros2, pixels), "sqlite3")
    assert_a_beginning(cut(folder / "bag.db3", tmp_path / "cut.db3", share), pixels, 100)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_a_truncated_ros1_bag_gives_its_beginning(tmp_path, ros1, pictures, share, write_rosbag1):
    pixels = pictures(500)
    whole = write_rosbag1(tmp_path / "whole.bag", script(ros1, pixels), chunk_bytes=4000)
    assert_a_beginning(cut(whole, tmp_path / "cut.bag", share), pixels, 50)


def test_a_truncated_compressed_file_gives_its_beginning(tmp_path, ros2, pictures, write_rosbag2):
    pixels = pictures(2000)
    folder = write_rosbag2(tmp_path / "bag", script(ros2, pixels), "mcap")
    packed = tmp_path / "bag.mcap.zstd"
    packed.write_bytes(zstd.compress((folder / "bag.mcap").read_bytes()))
    assert_all(packed, pixels)
    assert_a_beginning(cut(packed, tmp_path / "cut.mcap.zstd", 0.6), pixels, 10)


def test_an_mcap_whose_last_bytes_are_missing_loses_no_message(tmp_path, ros2, pictures, write_rosbag2):
    pixels = pictures(10)
    file = write_rosbag2(tmp_path / "bag", script(ros2, pixels), "mcap") / "bag.mcap"
    file.write_bytes(file.read_bytes()[:-8])
    assert_all(file, pixels, problems=1)


def test_a_damaged_chunk_in_the_middle_is_told(tmp_path, ros2, pictures, write_rosbag2):
    pixels = pictures(1000, (64, 64))
    file = write_rosbag2(tmp_path / "bag", script(ros2, pixels), "mcap", CompressionMode.STORAGE) / "bag.mcap"
    data = bytearray(file.read_bytes())
    third_chunk = [m.start() for m in re.finditer(re.escape(b"\x28\xb5\x2f\xfd"), data)][2]
    data[third_chunk : third_chunk + 4] = bytes(4)
    file.write_bytes(data)
    with Bag(file) as bag:
        found = images(bag)
        assert 100 < len(found) < 900
        assert len(bag.problems) == 1


def test_counts_of_metadata_are_held_against_what_was_read(tmp_path, ros2, pictures, write_rosbag2):
    folder = write_rosbag2(tmp_path / "bag", script(ros2, pictures(3)), "sqlite3")
    with sqlite3.connect(folder / "bag.db3") as database:
        database.execute("DELETE FROM messages WHERE id = 2")
    with Bag(folder) as bag:
        assert len(images(bag)) == 2
        (problem,) = bag.problems
    assert problem == f"{folder}: '/image': 2 messages were read, but metadata.yaml tells of 3: 1 is lost"


def test_a_topic_of_which_nothing_can_be_read_is_not_passed_over_for_another(tmp_path, ros2, pictures, write_rosbag2):
    both = [(name, t, m) for _, t, m in script(ros2, pictures(3)) for name in ("/image", "/overlay")]
    folder = write_rosbag2(tmp_path / "bag", both, "sqlite3")
    with Bag(folder) as bag, pytest.raises(SourceError, match="choose one with --topic"):
        choose_topic(bag, None, "labels", print)
    with sqlite3.connect(folder / "bag.db3") as database:
        of_image = "SELECT id FROM topics WHERE name = '/image'"
        database.execute(f"UPDATE messages SET data = 'text' WHERE topic_id IN ({of_image})")
    with Bag(folder) as bag, pytest.raises(SourceError, match="'/image': 0 messages .* choose one with --topic"):
        choose_topic(bag, None, "labels", print)


@pytest.mark.parametrize("content", ["", ": [", "5", "rosbag2_bagfile_information: {version: 9}", "a: b"])
def test_metadata_that_tells_nothing_is_told_and_all_is_read(tmp_path, ros2, pictures, write_rosbag2, content):
    folder = write_rosbag2(tmp_path / "bag", script(ros2, pictures(3)))
    (folder / "metadata.yaml").write_text(content)
    with Bag(folder) as bag:
        assert len(images(bag)) == 3
        (problem,) = bag.problems
    assert problem.startswith(f"{folder}: metadata.yaml tells nothing: it is empty or damaged")


@pytest.mark.parametrize("change", ["data = 'text'", "timestamp = 'abc'", "timestamp = -5"])
def test_rows_that_are_no_messages_are_left_out_and_told(tmp_path, ros2, pictures, write_rosbag2, change):
    pixels = pictures(4)
    file = write_rosbag2(tmp_path / "bag", script(ros2, pixels), "sqlite3") / "bag.db3"
    with sqlite3.connect(file) as database:
        database.execute(f"UPDATE messages SET {change} WHERE id = 2")
    with Bag(file) as bag:
        assert np.array_equal(images(bag), [pixels[0], pixels[2], pixels[3]])
        assert bag.problems == [f"{file}: damaged database: 1 of its rows is no message"]
        assert bag.start_ns > 0 and bag.end_ns - bag.start_ns < 10**12


def test_a_file_that_metadata_does_not_list_is_told(tmp_path, ros2, pictures, write_rosbag2):
    folder = write_rosbag2(tmp_path / "bag", script(ros2, pictures(3)))
    shutil.copy(folder / "bag.mcap", folder / "bag_1.mcap")
    with Bag(folder) as bag:
        assert bag.problems == [f"{folder}: metadata.yaml does not list bag_1.mcap, which is not read"]


def test_a_file_written_over_by_another_is_told(tmp_path, ros2, pictures, write_rosbag2):
    file = write_rosbag2(tmp_path / "bag", script(ros2, pictures(3))) / "bag.mcap"
    (tmp_path / "split").mkdir()
    for name in ("a.mcap", "b.mcap"):
        shutil.copy(file, tmp_path / "split" / name)
    with Bag(tmp_path / "split") as bag:
        (problem,) = bag.problems
    assert "b.mcap: holds the same messages as a.mcap" in problem


def test_a_length_beyond_all_memory_ends_in_one_line(tmp_path, ros2, pictures, write_rosbag2):
    file = write_rosbag2(tmp_path / "bag", script(ros2, pictures(3))) / "bag.mcap"
    data = bytearray(file.read_bytes())
    data[9:17] = b"\xff" * 8  # of the first record
    file.write_bytes(data)
    with pytest.raises(SourceError, match="truncated"):
        Bag(file)


def test_a_ros1_bag_without_index_is_read_and_told(tmp_path, ros1, pictures, write_rosbag1):
    pixels = pictures(3)
    file = write_rosbag1(tmp_path / "a.bag", script(ros1, pixels))
    data = bytearray(file.read_bytes())
    place = data.find(b"index_pos=") + 10
    data[place : place + 8] = bytes(8)
    file = tmp_path / "a.bag.active"  # what rosbag calls it until it is closed
    file.write_bytes(data)
    with Bag(file) as bag:
        assert np.array_equal(images(bag), pixels)
        (problem,) = bag.problems
    assert "it has no index" in problem and "rosbag reindex" in problem


def test_types_of_2018_are_read(tmp_path, ros2, pictures, write_rosbag2):
    pixels = pictures(3)
    folder = write_rosbag2(tmp_path / "bag", script(ros2, pixels), "sqlite3")
    with sqlite3.connect(folder / "bag.db3") as database:
        database.execute("UPDATE topics SET type = 'sensor_msgs/Image'")
    with Bag(folder) as bag:
        assert bag.topics["/image"].msgtype == "sensor_msgs/msg/Image"
        assert np.array_equal(images(bag), pixels) and not bag.problems


@pytest.mark.parametrize("name", ["a.mcap", "a.db3", "a.bag"])
def test_a_pointer_of_git_lfs_says_what_it_is(tmp_path, name):
    (tmp_path / name).write_text("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 12345\n")
    with pytest.raises(SourceError, match="is a pointer of Git LFS.*'git lfs pull'"):
        Bag(tmp_path / name)


def test_a_pipe_is_no_bag(tmp_path):
    os.mkfifo(tmp_path / "a.mcap")
    with pytest.raises(SourceError, match="a pipe or device"):
        Bag(tmp_path / "a.mcap")


@pytest.mark.parametrize("name", ["a.mcap", "a.db3", "a.bag", "a.mcap.zstd"])
@pytest.mark.parametrize("content", [b"", b"nothing that a bag starts with"])
def test_what_is_no_bag_is_refused_in_one_line(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SourceError, match="nothing could be read") as caught:
        Bag(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value) and "\n" not in str(caught.value)


def test_missing_paths_and_files_are_named(tmp_path, ros2, pictures, write_rosbag2):
    with pytest.raises(SourceError, match="no such file or folder"):
        Bag(tmp_path / "nothing")
    folder = write_rosbag2(tmp_path / "bag", script(ros2, pictures(1)))
    (folder / "bag.mcap").unlink()
    with pytest.raises(SourceError, match=r"bag\.mcap: metadata\.yaml lists it"):
        Bag(folder)


def test_a_folder_of_several_bags_names_some(tmp_path):
    for name in "abcd":
        (tmp_path / f"{name}.bag").touch()
    with pytest.raises(SourceError, match=r"holds several bags \(4\); name \S+/a.bag or \S+/b.bag or \S+/c"):
        bag_files(tmp_path, None)


def test_storage_chooses_among_a_folders_files(tmp_path, ros2, pictures, write_rosbag2):
    both = tmp_path / "both"
    both.mkdir()
    for storage, suffix in (("mcap", ".mcap"), ("sqlite3", ".db3")):
        folder = write_rosbag2(tmp_path / storage, script(ros2, pictures(1)), storage)
        shutil.copy(folder / f"{storage}{suffix}", both)
    assert [f.suffix for f in bag_files(both, "mcap")] == [".mcap"]
    assert [f.suffix for f in bag_files(both, "sqlite3")] == [".db3"]
    with pytest.raises(SourceError, match=r"no bag \(\.db3"):
        bag_files(tmp_path / "mcap", "sqlite3")


def test_a_message_that_does_not_fit_its_type_is_an_image_error(tmp_path, ros2, pictures, write_rosbag2):
    folder = write_rosbag2(tmp_path / "bag", script(ros2, pictures(2)), "sqlite3")
    with sqlite3.connect(folder / "bag.db3") as database:
        database.execute("UPDATE messages SET data = x'00010000ff' WHERE id = 1")
    with Bag(folder) as bag:
        first, second = bag.messages(["/image"])
        with pytest.raises(ImageError, match="damaged sensor_msgs/msg/Image message of 5 bytes"):
            bag.parse(first)
        assert bag.parse(second).width == 8


@pytest.mark.skipif(not THIRD_PARTY.exists(), reason="the third-party bags are not on this machine")
@pytest.mark.parametrize(
    ("name", "messages", "problems"),
    [
        ("images_30_bytes_mcap", 188, 0),
        ("ros1_array_test.bag", 20, 0),
        ("ros1_lz4.bag", 8647, 0),
        ("ros1_no_messages.bag", 0, 0),
        ("ros1_truncated.bag", 3, 1),
        ("split_mcap", 6074, 0),
        ("talker_sqlite3", 20, 0),
    ],
)
def test_bags_that_other_tools_wrote(name, messages, problems):
    with Bag(THIRD_PARTY / name) as bag:
        assert sum(1 for _ in bag.messages(bag.topics)) == messages
        assert len(bag.problems) == problems

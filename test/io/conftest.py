"""Bags for the tests, written with rosbags in every form that recorders leave behind."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_messages import Messages, Script
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore


def _write_rosbag2(
    path: Path, script: Script, storage: str = "mcap", compression: rosbag2.CompressionMode | None = None
) -> Path:
    plugin = rosbag2.StoragePlugin.MCAP if storage == "mcap" else rosbag2.StoragePlugin.SQLITE3
    writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
    if compression is not None:
        writer.set_compression(compression, rosbag2.CompressionFormat.ZSTD)
    store = get_typestore(Stores.ROS2_JAZZY)
    with writer:
        connections: dict[str, Any] = {}
        for topic, log_ns, (msgtype, message) in script:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msgtype, typestore=store)
            writer.write(connections[topic], log_ns, store.serialize_cdr(message, msgtype))
    return path


def _write_rosbag1(path: Path, script: Script, chunk_bytes: int | None = None) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    writer = rosbag1.Writer(path)
    if chunk_bytes is not None:
        writer.chunk_threshold = chunk_bytes
    with writer:
        connections: dict[str, Any] = {}
        for topic, log_ns, (msgtype, message) in script:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msgtype, typestore=store)
            writer.write(connections[topic], log_ns, store.serialize_ros1(message, msgtype))
    return path


@pytest.fixture(scope="session")
def ros2() -> Messages:
    return Messages()


@pytest.fixture(scope="session")
def ros1() -> Messages:
    return Messages(ros1=True)


@pytest.fixture(scope="session")
def write_rosbag2() -> Callable[..., Path]:
    """(path, script, storage, compression) -> path."""
    return _write_rosbag2


@pytest.fixture(scope="session")
def write_rosbag1() -> Callable[..., Path]:
    """(path, script, chunk_bytes) -> path."""
    return _write_rosbag1


@pytest.fixture
def pictures() -> Callable[..., list[np.ndarray]]:
    """(count, (height, width)) -> label images of noise, each different, that no compression makes small."""
    rng = np.random.default_rng(5)
    return lambda count, size=(6, 8): [rng.integers(0, 8, size, np.uint8) for _ in range(count)]

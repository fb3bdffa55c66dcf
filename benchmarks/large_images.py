"""How many large images arrive, by default and with config/dds/large_images.xml at the publisher.

python benchmarks/large_images.py
"""

from __future__ import annotations

import argparse
import array
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

SIZES = ((640, 480), (1280, 720))
COUNT, RATE_HZ = 300, 30
PROFILE = Path(__file__).parents[1] / "config" / "dds" / "large_images.xml"


def publish(width: int, height: int) -> None:
    import rclpy
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from sensor_msgs.msg import Image

    rclpy.init()
    node = rclpy.create_node("camera")
    publisher = node.create_publisher(Image, "image", QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT))
    msg = Image(height=height, width=width, step=3 * width, encoding="bgr8")
    msg.data = array.array("B", bytes(3 * width * height))
    while not publisher.get_subscription_count():
        time.sleep(0.1)
    time.sleep(1.0)  # the other side connects in its own time
    for _ in range(COUNT):
        publisher.publish(msg)
        time.sleep(1 / RATE_HZ)
    time.sleep(1.0)


def main() -> None:
    import rclpy
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from sensor_msgs.msg import Image

    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    os.environ.setdefault("ROS_DOMAIN_ID", str(101 + os.getpid() % 100))
    os.environ.setdefault("ROS_LOG_DIR", tempfile.gettempdir())
    rclpy.init()
    node = rclpy.create_node("listener")
    delays_ms: list[float] = []
    node.create_subscription(
        Image,
        "image",
        lambda msg, info: delays_ms.append((time.time_ns() - info["source_timestamp"]) * 1e-6),
        QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT),
    )
    for width, height in SIZES:
        for name, profile in (("by default", {}), ("with the file", {"FASTRTPS_DEFAULT_PROFILES_FILE": str(PROFILE)})):
            delays_ms.clear()
            command = [sys.executable, __file__, str(width), str(height)]
            with subprocess.Popen(command, env={**os.environ, **profile}) as camera:
                while camera.poll() is None:
                    rclpy.spin_once(node, timeout_sec=0.05)
            median = f"median {np.median(delays_ms):.1f} ms" if delays_ms else ""
            print(f"{width}x{height} bgr8, {name}: {len(delays_ms)} of {COUNT} arrived {median}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "size", nargs="*", type=int, help="width and height: publish such images, as the run does itself"
    )
    size = parser.parse_args().size
    if size and len(size) != 2:
        parser.error("width and height, or nothing")
    publish(*size) if size else main()

"""The part of studio.py that needs a ROS graph: the studio on a live topic, and beside a node that runs."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import rclpy
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from artrec_ros.node.conversions import image_to_msg

TOPIC, RATE_HZ = "/camera/image_raw", 10
OWN = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": str(1 + os.getpid() % 100)}


@contextmanager
def filming(pictures: Path) -> Iterator[None]:
    """The pictures of a folder on a topic, again and again."""
    context = rclpy.Context()
    context.init(args=[])
    node = rclpy.create_node("film", context=context)
    publisher = node.create_publisher(Image, TOPIC, 1)
    shown, over = [cv2.imread(str(p)) for p in sorted(pictures.glob("*.png"))], threading.Event()

    def film() -> None:
        number = 0
        while not over.wait(1 / RATE_HZ):
            header = Header(stamp=node.get_clock().now().to_msg(), frame_id="camera")
            publisher.publish(image_to_msg(shown[number // RATE_HZ % len(shown)], header))
            number += 1

    thread = threading.Thread(target=film)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
        node.destroy_node()
        context.try_shutdown()


@contextmanager
def running(parameters: Path) -> Iterator[None]:
    """`artrec_node` with a parameter file."""
    program = "import sys; from artrec_ros.node.main import main; sys.exit(main())"
    arguments = ["--ros-args", "--params-file", str(parameters), "-r", f"image:={TOPIC}", "-p", "publish_tf:=true"]
    node = subprocess.Popen([sys.executable, "-c", program, *arguments])
    try:
        yield
    finally:
        node.terminate()
        node.wait(30)

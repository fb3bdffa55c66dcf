"""What share of a camera's images the node takes in, and how late its answers come, for each kind of scene.

    python benchmarks/live_share.py SHARED_DATA --seconds 60

Plays recorded images of each scene, in a loop, at 30 Hz and reliably, each stamped with the time at which it is sent,
against a node process as it is shipped, and subscribes to its results as a user would. Prints a table: images sent, the
share that the node took in, the others, milliseconds from an image's stamp until a subscriber has its answer, the
recogniser's part of it, and objects in an image. Nothing in it is random; the machine is to be quiet.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from node_load import at_rate

from artrec_ros.io.sources.frames import Frame, SourceOptions
from artrec_ros.io.sources.opening import open_sources

CONFIG = Path(__file__).parents[1] / "config"
MOST_FRAMES = 300
START_S, WARM_UP_S = 300.0, 5.0


@dataclass(frozen=True)
class Scene:
    """Recorded images, below the folder of data, and the shipped parameters that recognise in them."""

    name: str
    source: str
    parameters: str
    topic: str | None = None


LABELS, COLOURS = "/camera/segmentation", "/camera/image_color/compressed"
SCENES = (
    Scene("walk_lowres: one or two quadrupeds, labels", "walk_lowres/bag", "aibo", LABELS),
    Scene("walk_vga: two or three quadrupeds, labels", "walk_vga/bag", "aibo", LABELS + "/compressed"),
    Scene("the same from colour images", "walk_vga/bag", "aibo_colour", COLOURS),
    Scene("walk_crowd: four or five quadrupeds, labels", "walk_crowd/bag", "aibo", LABELS + "/compressed"),
    Scene("aibo_vga: one to four quadrupeds as far as 3 m, labels", "aibo_vga/bag", "aibo", LABELS + "/compressed"),
    Scene("vss: five soccer robots from above, colour", "vss/frames", "vss"),
    Scene("pendulum, colour", "pendulum/frames", "pendulum"),
)
COLUMNS = "scene", "size", "sent", "taken in", "dropped", "stamp to answer, ms (95, 99 %)", "recogniser, ms", "objects"
HEADER = f"| {' | '.join(COLUMNS)} |\n{'| --- ' * len(COLUMNS)}|"


def read_frames(scene: Scene, data: Path) -> list[Frame]:
    with open_sources([data / scene.source], SourceOptions(topic=scene.topic)) as sources:
        return [f for f in islice(sources, MOST_FRAMES) if f.image is not None]


class Camera:
    """Publishes frames on `image` and `camera_info`, and keeps when each was answered."""

    def __init__(self, frames: list[Frame], answers: str) -> None:
        import rclpy
        from geometry_msgs.msg import PoseArray
        from rclpy.executors import SingleThreadedExecutor
        from sensor_msgs.msg import CameraInfo, Image

        self.node = rclpy.create_node("live_camera")
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._images = self.node.create_publisher(Image, "image", 1)
        self._infos = self.node.create_publisher(CameraInfo, "camera_info", 1)
        self.answered: dict[int, float] = {}  # stamp in ns: when, s
        self.node.create_subscription(PoseArray, answers, self._on_answer, 100)
        self._messages = [(image_message(f), info_message(f)) for f in frames]
        self._spinning = threading.Thread(target=self._spin, daemon=True)
        self._open = True
        self._spinning.start()

    def _spin(self) -> None:
        while self._open:
            self._executor.spin_once(timeout_sec=0.1)

    def _on_answer(self, msg: Any) -> None:
        self.answered[msg.header.stamp.sec * 10**9 + msg.header.stamp.nanosec] = time.time()

    def send(self, number: int) -> int:
        """The stamp, ns."""
        image, info = self._messages[number % len(self._messages)]
        now_ns = time.time_ns()
        image.header.stamp.sec, image.header.stamp.nanosec = divmod(now_ns, 10**9)
        if info is not None:
            info.header = image.header
            self._infos.publish(info)
        self._images.publish(image)
        return now_ns

    def close(self) -> None:
        self._open = False
        self._spinning.join()
        self.node.destroy_node()


def image_message(frame: Frame) -> Any:
    import array

    from sensor_msgs.msg import Image

    image = np.ascontiguousarray(frame.image, np.uint8)
    height, width = image.shape[:2]
    msg = Image(height=height, width=width, encoding="mono8" if image.ndim == 2 else "bgr8", step=image.strides[0])
    msg.header.frame_id = "camera"
    msg.data = array.array("B", image.tobytes())
    return msg


def info_message(frame: Frame) -> Any:
    from sensor_msgs.msg import CameraInfo

    if frame.camera is None:
        return None
    distortion = [float(v) for v in frame.camera.distortion] or [0.0] * 5
    model = "plumb_bob" if len(distortion) <= 5 else "rational_polynomial"
    msg = CameraInfo(width=frame.camera.size[0], height=frame.camera.size[1], distortion_model=model, d=distortion)
    msg.k = frame.camera.matrix.reshape(9)
    return msg


def measure(scene: Scene, frames: list[Frame], args: argparse.Namespace) -> str:
    """A line of the table."""
    import rclpy

    file = CONFIG / f"{scene.parameters}.yaml"
    first = yaml.safe_load(file.read_text(encoding="utf-8"))["/**"]["ros__parameters"]["objects"][0]
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "times.npy"
        seconds = args.seconds + WARM_UP_S
        node_program, capacity = Path(__file__).with_name("node_load.py"), str(int(args.rate * (seconds + START_S)))
        command = [sys.executable, str(node_program), "--node", str(record), capacity]
        with subprocess.Popen([*command, "--ros-args", "--params-file", str(file), "--log-level", "error"]) as node:
            rclpy.init(args=[])
            camera = Camera(frames, f"{first}/poses")
            for number in at_rate(2.0, START_S, node):  # until it has started, compiled and answered
                camera.send(number)
                if camera.answered:
                    break
            sent = [camera.send(number) for number in at_rate(args.rate, seconds, node)]
            time.sleep(2.0)  # for the last answers
            camera.close()
            rclpy.shutdown()
            node.terminate()
            node.wait()
        return line(scene, frames, np.array(sent), camera.answered, np.load(record))


def line(scene: Scene, frames: list[Frame], sent_ns: np.ndarray, answered: dict[int, float], rows: np.ndarray) -> str:
    """Figures of the time after the warm-up. A row of `rows`: time, latency, recognition, objects."""
    start_s = sent_ns[0] * 1e-9 + WARM_UP_S
    sent = [int(s) for s in sent_ns if s * 1e-9 >= start_s]
    late = np.array([(answered[s] - s * 1e-9) * 1e3 for s in sent if s in answered])
    rows = rows[rows[:, 0] >= start_s]
    assert frames[0].image is not None
    height, width = frames[0].image.shape[:2]
    if not len(late) or not len(rows):
        return f"| {scene.name} | {width}×{height} | {len(sent)} | none {'| ' * (len(COLUMNS) - 4)}|"
    median, high, highest = np.percentile(late, [50, 95, 99])
    taken = min(len(rows), len(sent))  # one more may be answered at the ends of the time than was sent in it
    figures = f"{taken / len(sent):.0%} | {len(sent) - taken} | {median:.0f} ({high:.0f}, {highest:.0f})"
    recogniser = f"{np.median(rows[:, 2]):.0f} | {rows[:, 3].mean():.1f}"
    return f"| {scene.name} | {width}×{height} | {len(sent)} | {figures} | {recogniser} |"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, help="folder of recorded data")
    parser.add_argument("--seconds", type=float, default=60.0, help="for each scene")
    parser.add_argument("--rate", type=float, default=30.0, help="Hz")
    parser.add_argument("--only", help="scenes whose names hold this text")
    args = parser.parse_args()
    scenes = [s for s in SCENES if (args.data / s.source).exists() and (args.only or "") in s.name]
    if not scenes:
        parser.error(f"{args.data} holds none of these scenes: {'; '.join(s.name for s in SCENES)}")
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    os.environ.setdefault("ROS_DOMAIN_ID", str(101 + os.getpid() % 100))
    with tempfile.TemporaryDirectory() as logs:
        os.environ.setdefault("ROS_LOG_DIR", logs)
        print(HEADER)
        for scene in scenes:
            print(measure(scene, read_frames(scene, args.data), args), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

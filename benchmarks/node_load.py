"""The node under load: images of two objects at 60 Hz, for a minute or for ten, and what became of them.

    python benchmarks/node_load.py --minutes 10

Prints whether the node lived, which share of the images was dropped, how its memory grew, the time from the reception
of an image until its results were published, and how much of that the node adds to the recogniser's own time. Exits
with 1 where a bar is missed. Images are label images of two soccer robots, recognised in the image plane.
"""

from __future__ import annotations

import argparse
import array
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

DROPPED, GROWN, ADDED_MS = 0.001, 0.02, 1.5  # the bars
WARM_UP_S = 10.0
PX_PER_M, PATCH_M, APART_M, BEARING_RAD = 500.0, 0.04, 0.0526, 0.79  # of config/objects/vss.yaml, seen from above
COLOURS = {"mono8": 1, "bgr8": 3}
PARAMETERS = """
/**:
  ros__parameters:
    objects: [yellow, blue]
    yellow: {object_file: "package://artrec_ros/config/objects/vss.yaml", label: 1,
             constraint_file: "package://artrec_ros/config/constraints/vss.yaml"}
    blue: {object_file: "package://artrec_ros/config/objects/vss.yaml", label: 2,
           constraint_file: "package://artrec_ros/config/constraints/vss.yaml"}
"""
PALETTE = """    image:
      kind: palette
      classes: [yellow, blue, accent]
      yellow: {label: 1, rgb: [1, 1, 1]}
      blue: {label: 2, rgb: [2, 2, 2]}
      accent: {label: 3, rgb: [3, 3, 3]}
"""


def draw(size: tuple[int, int], turn_rad: float) -> np.ndarray:
    """(H, W) uint8: class numbers of two robots, turned."""
    image = np.zeros(size[::-1], np.uint8)
    for label, share, phase in ((1, 0.3, 0.0), (2, 0.7, 2.0)):
        centre = np.array([size[0] * share, size[1] / 2])
        turn = turn_rad + phase
        bearing = turn + BEARING_RAD
        accent = centre + APART_M * PX_PER_M * np.array([np.cos(bearing), np.sin(bearing)])
        for place, value in ((centre, label), (accent, 3)):
            box = cv2.boxPoints((place.tolist(), (PATCH_M * PX_PER_M,) * 2, np.degrees(turn)))
            cv2.fillPoly(image, [np.round(box * 16).astype(np.int32)], value, cv2.LINE_8, 4)
    return image


def run_node(arguments: list[str], record: Path, capacity: int) -> int:
    """The node itself, which keeps each image's times and writes them at its end."""
    from artrec_ros.node.main import main
    from artrec_ros.node.node import RecognizerNode
    from artrec_ros.node.pipeline import FrameReport

    rows = np.full((capacity, 4), -1.0)  # made in full at once: keeping records must not look like growth
    count, plain = 0, RecognizerNode.account

    def account(node: RecognizerNode, report: FrameReport) -> None:
        nonlocal count
        rows[count % capacity] = time.time(), report.latency_ms, report.recognition_ms, report.n_objects
        count += 1
        plain(node, report)

    RecognizerNode.account = account  # type: ignore[method-assign,assignment]
    code = main(arguments)
    np.save(record, rows[:count])
    return code


def publish(args: argparse.Namespace, node: subprocess.Popen) -> tuple[np.ndarray, list[tuple[float, float]]]:
    """Sends images until the time is over. Returns when each was sent, and the node's memory (time, MiB) by second."""
    import rclpy
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from sensor_msgs.msg import Image

    rclpy.init()
    peer = rclpy.create_node("load")
    policy = ReliabilityPolicy.BEST_EFFORT if args.best_effort else ReliabilityPolicy.RELIABLE
    publisher = peer.create_publisher(Image, "image", QoSProfile(depth=1, reliability=policy))
    width, height = args.size
    msg = Image(height=height, width=width, encoding=args.encoding, step=width * COLOURS[args.encoding])
    msg.header.frame_id = "camera"
    pixels = []
    for turn in np.linspace(0, 2 * np.pi, 120):
        labels = draw(args.size, float(turn))
        image = labels if args.encoding == "mono8" else np.repeat(labels[:, :, None], 3, axis=2)
        pixels.append(array.array("B", image.tobytes()))
    sent: list[float] = []
    memory: list[tuple[float, float]] = []
    for i in at_rate(args.rate, WARM_UP_S + 60 * args.minutes, node):
        msg.data = pixels[i % len(pixels)]
        msg.header.stamp = peer.get_clock().now().to_msg()
        publisher.publish(msg)
        sent.append(time.time())
        if not memory or time.time() > memory[-1][0] + 1:
            memory.append((time.time(), resident_mib(node.pid)))
    peer.destroy_node()
    rclpy.shutdown()
    return np.array(sent), memory


def at_rate(rate_hz: float, seconds: float, node: subprocess.Popen) -> Iterator[int]:
    """0, 1, 2, ... each in its time, while the node lives."""
    began, count = time.monotonic(), 0
    end = began + seconds
    while (now := time.monotonic()) < end and node.poll() is None:
        yield count
        count += 1
        time.sleep(max(0.0, began + count / rate_hz - time.monotonic()))
        if now - began > (count + rate_hz) / rate_hz:  # never a burst to make up for what a busy machine cost
            began = now - count / rate_hz


def resident_mib(pid: int) -> float:
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1024


def report(sent: np.ndarray, rows: np.ndarray, memory: list[tuple[float, float]], alive: bool) -> bool:
    """Prints the figures; whether every bar is held."""
    start, stop = sent[0] + WARM_UP_S, sent[-1] - 1.0
    n_sent = int(np.sum((sent >= start) & (sent < stop)))
    rows = rows[(rows[:, 0] >= start) & (rows[:, 0] < stop)]
    if not n_sent or not len(rows):
        print("node:        nothing processed")
        return False
    mib = np.array([m for t, m in memory if t >= start])
    part = max(1, len(mib) // 10)
    growth = float(np.mean(mib[-part:]) / np.mean(mib[:part]) - 1)
    n_dropped = max(0, n_sent - len(rows))  # at the ends of the time one more may be answered than was sent
    dropped = n_dropped / n_sent
    latency, added = rows[:, 1], rows[:, 1] - rows[:, 2]
    rate = n_sent / (stop - start)
    print(
        f"images:      {n_sent} sent in {stop - start:.0f} s ({rate:.1f} Hz), {rows[:, 3].mean():.2f} objects in each"
    )
    print(f"node:        {'alive at the end' if alive else 'DEAD'}")
    print(f"dropped:     {n_dropped} ({dropped:.3%}; bar {DROPPED:.1%})")
    print(f"memory:      {np.mean(mib[:part]):.1f} to {np.mean(mib[-part:]):.1f} MiB ({growth:+.2%}; bar {GROWN:.0%})")
    for name, values in (("received to published", latency), ("of it, the recogniser", rows[:, 2]), ("added", added)):
        median, high = np.percentile(values, [50, 99])
        bar = f" (bar {ADDED_MS} ms)" if name == "added" else ""
        print(f"{name + ':':24} median {median:.2f} ms, p99 {high:.2f} ms{bar}")
    held = n_dropped <= max(1, DROPPED * n_sent)  # in a short run one is no share
    return alive and held and growth < GROWN and float(np.median(added)) <= ADDED_MS


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--rate", type=float, default=60.0, help="Hz")
    parser.add_argument("--size", type=lambda s: tuple(map(int, s.split("x"))), default=(640, 480), help="WIDTHxHEIGHT")
    parser.add_argument("--encoding", choices=sorted(COLOURS), default="mono8")
    parser.add_argument("--best-effort", action="store_true")
    args = parser.parse_args()
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    os.environ.setdefault("ROS_DOMAIN_ID", str(101 + os.getpid() % 100))
    with tempfile.TemporaryDirectory() as folder:
        parameters, record = Path(folder) / "load.yaml", Path(folder) / "times.npy"
        parameters.write_text(PARAMETERS + (PALETTE if args.encoding == "bgr8" else ""))
        os.environ.setdefault("ROS_LOG_DIR", folder)
        capacity = str(int(args.rate * (60 * args.minutes + 3 * WARM_UP_S)))
        ros = ["--ros-args", "--params-file", str(parameters)]
        command = [sys.executable, __file__, "--node", str(record), capacity, *ros]
        with subprocess.Popen(command) as node:
            sent, memory = publish(args, node)
            alive = node.poll() is None
            node.terminate()
            node.wait()
        return 0 if report(sent, np.load(record), memory, alive) else 1


if __name__ == "__main__":
    if "--node" in sys.argv[1:2]:
        sys.exit(run_node(sys.argv[4:], Path(sys.argv[2]), int(sys.argv[3])))
    sys.exit(main())

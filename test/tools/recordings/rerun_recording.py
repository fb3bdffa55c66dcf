"""A recogniser that finds a crane where it is told to, what a replay of it writes, and that read back."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import ImageError
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose, rotation_from_quaternion, rotation_from_rotvec
from artrec_ros.core.model.found import Detection, ImagePose, Instance
from artrec_ros.core.model.frame_result import FrameResult, Rejection
from artrec_ros.tools.main import main

OBJECT = """
format: artrec_object/1
name: crane
markers: {patch: {outline: [[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]], axis: [[0, 0.05], [0.2, 0.05]]}}
components:
  base:
    required: true
    markers: {patch: {pose: {xyz: [0.1, 0.0, 0.05], rpy: [1.0, 0.2, 0.3]}}}
    body: {boxes: [{size: [0.4, 0.3, 0.1], xyz: [0.0, 0.0, 0.02], rpy: [0.0, 0.0, 0.5]}]}
  boom:
    markers: {patch: {pose: {xyz: [0.0, 0.3, 0.0], rpy: [0.0, 0.0, 0.0]}}}
    joint: {parent: base, origin: {xyz: [0.0, 0.1, 0.2], rpy: [0.0, 0.4, 0.0]}, axis: [0, 0, 1], limits: [-1.5, 1.5]}
  hook:
    markers: {patch: {pose: {xyz: [0.0, 0.1, 0.0], rpy: [0.0, 0.0, 0.0]}}}
    joint: {parent: boom, origin: {xyz: [0.0, 0.5, 0.0]}, axis: [1, 0, 0], limits: [-1.5, 1.5]}
"""
COLOURS = {"red": {"label": 3, "rgb": [200, 0, 0]}, "blue": {"label": 5, "rgb": [0, 0, 200]}}
PARAMETERS = {
    "objects": ["crane"],
    "crane": {"object_file": "crane.yaml", "label": 3},
    "image": {"kind": "palette", "tolerance": 40, "classes": [*COLOURS], **COLOURS},
}
CAMERA = Camera(np.array([[90.0, 0, 16], [0, 80, 12], [0, 0, 1]]), np.zeros(5), (32, 24), "optical")
STAMPS = [1_700_000_000_000_000_001 + i * 10**8 for i in range(5)]
CONTOUR = np.array([[3.0, 4.0], [9.0, 4.0], [9.0, 8.0]])
_A = np.random.default_rng(3).normal(size=(6, 6))
COVARIANCE = _A @ _A.T * 1e-4
BASE = Instance("base", "patch", 0.9, 6, 5, 0, 100, CONTOUR)
FOUND = Detection(
    "crane", 0, 0.8, ImagePose(6, 5, 0, 100), (BASE,), joints={"boom": 0.7}, pose_covariance=COVARIANCE,
    pose=Pose(rotation_from_rotvec([0.3, -0.5, 0.9]), np.array([0.1, -0.2, 1.5])),
)  # fmt: skip
TURNED_DOWN = Rejection("crane", "its boom is not confirmed", 0.4, 20.0, 10.0)
PNG = cv2.imencode(".png", np.zeros((2, 2), np.uint8))[1].tobytes()


class Recogniser:
    """The object is there in frames 0 and 3, in the latter flat in its image; frame 1 cannot be used."""

    def __init__(self) -> None:
        self.at = -1

    def follow(self, image, camera, stamp_ns, memory) -> tuple[FrameResult, None]:
        self.at += 1
        if self.at % 5 == 1:
            raise ImageError("too dark")
        flat = replace(FOUND, pose=None, joints={}, pose_covariance=None)
        found = {0: (FOUND,), 3: (flat,)}.get(self.at % 5, ())
        turned_down = (TURNED_DOWN,) if self.at % 5 == 2 else ()
        cut = ("recognizer.time_budget_ms",) if self.at % 5 == 4 else ()
        return FrameResult((32, 24), found, turned_down, {"blobs": 1.5, "total": 2.0}, ended_by=cut), None


def picture(number: int) -> np.ndarray:
    image = np.full((24, 32, 3), (20, 120, 20), np.uint8)
    image[4:8, 2 + number : 10 + number] = (0, 0, 200)  # BGR: red
    image[12:20, 16:30] = (200, 0, 0)
    return image


def run(params, output, *sources, more=()) -> int:
    what = ["--images", "none", "--no-video", "-o", str(output.with_suffix("")), "--rerun", str(output), *more]
    return main(["replay", *map(str, sources), "--params-file", str(params), *what])


class Recording:
    """path -> component -> {stamp in ns, None: for good: value}."""

    def __init__(self, path: Path) -> None:
        chunk = pytest.importorskip("rerun.chunk", reason="rerun-sdk is not installed")
        self.rows = defaultdict(lambda: defaultdict(dict))
        self.timelines = set()
        reader = chunk.RrdReader(str(path))
        self.blueprints = reader.blueprints()
        for part in reader.stream():
            self.timelines |= set(part.timeline_names)
            batch = part.to_record_batch()
            times = (
                batch.column("stamp").cast("int64").to_pylist()
                if "stamp" in batch.schema.names
                else [None] * len(batch)
            )
            for name in batch.schema.names:
                if ":" in name:
                    for time, value in zip(times, batch.column(name).to_pylist(), strict=True):
                        if value is not None:
                            self.rows[part.entity_path][name][time] = value

    def at(self, path: str, component: str, number: int):
        """As numbers, where it is made of numbers."""
        value = self.rows[path][component][STAMPS[number]]
        return value if isinstance(value[0], (str, bytes)) else np.array(value)

    def stamps(self, path: str, component: str) -> list[int]:
        return sorted(self.rows[path][component])


def placed(recording, path: str, number: int) -> Pose:
    quaternion, place = (recording.at(path, f"Transform3D:{name}", number)[0] for name in ("quaternion", "translation"))
    return Pose(rotation_from_quaternion(quaternion), np.asarray(place, float))

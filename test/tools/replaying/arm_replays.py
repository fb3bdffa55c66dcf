"""A small object, images of it, and a recogniser that finds it without looking."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import yaml

from artrec_ros.core.base.errors import ImageError
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.model.found import Detection, ImagePose, Instance
from artrec_ros.core.model.frame_result import FrameResult
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.tools.main import main

OBJECT = """
format: artrec_object/1
name: arm
markers: {patch: {outline: [[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]], axis: [[0, 0.05], [0.2, 0.05]]}}
components: {base: {required: true, markers: {patch: {}}}}
"""

PARAMETERS = {"objects": ["arm"], "arm": {"object_file": "arm.yaml", "label": 3}, "image": {"kind": "labels"}}


class Recogniser:
    """Finds an object at the place that the image's first pixel tells; refuses images that start with 9."""

    def __init__(self, at_frame=None) -> None:
        self.at_frame, self.seen, self.cameras = at_frame or {}, 0, []

    def follow(self, image, camera, stamp_ns, memory) -> tuple[FrameResult, None]:
        self.seen += 1
        self.cameras.append(camera)
        if self.seen in self.at_frame:
            self.at_frame[self.seen]()
        if image[0, 0] == 9:
            raise ImageError("a nine")
        x = float(image[0, 0])
        parts = (Instance("base", "patch", 0.9, x, 5, 0, 100),)
        detections = (Detection("arm", 0, 0.9, ImagePose(x, 5, 0, 100), parts),) if x else ()
        return FrameResult((image.shape[1], image.shape[0]), detections, timing_ms={"total": 2.0}), None


def bag(path: Path, firsts) -> Path:
    with BagWriter(path) as writer:
        for i, first in enumerate(firsts):
            image = np.full((24, 32), first, np.uint8)
            writer.write_camera(
                "/cam/camera_info", i * 10**8 + 1, Camera(np.diag([9.0, 9, 1]), np.zeros(5), (32, 24), "o")
            )
            writer.write_image("/cam/labels", i * 10**8 + 1, "o", image)
            writer.write_jpeg("/cam/colour/compressed", i * 10**8 + 1, "o", np.dstack([image] * 3))
    return path


def folder_of(path: Path, firsts) -> Path:
    """Pictures 0.png, 1.png, ..., each filled with one number."""
    path.mkdir()
    for n, first in enumerate(firsts):
        cv2.imwrite(str(path / f"{n}.png"), np.full((24, 32), first, np.uint8))
    return path


def params_of(path: Path, **sections) -> Path:
    path.write_text(yaml.safe_dump({"/**": {"ros__parameters": sections}}))
    return path


def summary_of(output: Path) -> dict:
    return json.loads((output / "summary.json").read_text())


def run(params, source, output, *more) -> int:
    return main(["replay", str(source), "--params-file", str(params), "-o", str(output), *more])

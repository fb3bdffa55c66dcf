"""Scenes of known outcome: an object with a base of two markers and an arm, seen by a camera, and runs on disk."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import yaml

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import Detection, ImagePose, Instance
from artrec_ros.core.model.frame_result import FrameResult, Rejection
from artrec_ros.io.results.results import FrameRecord
from artrec_ros.io.truth.records import TrueComponent, TrueObject
from artrec_ros.tools.replaying.names import overlay_name

CAMERA = Camera(np.array([[200.0, 0, 79.5], [0, 200, 59.5], [0, 0, 1]]), np.zeros(0), (160, 120), "camera")
FACING = Pose.from_xyz_rpy([0, 0, 0], [np.pi, 0, 0]).rotation  # an object whose z looks at the camera
OBJECT = {
    "format": "artrec_object/1",
    "name": "thing",
    "markers": {
        "plate": {"outline": [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.02]], "axis": [[-0.1, 0], [0.1, 0]]},
        "stripe": {"rectangle": {"width": 0.12, "height": 0.03}},
    },
    "components": {
        "base": {"required": True, "markers": {"plate": {"pose": {"xyz": [0, 0, 0.0]}}}},
        "arm": {
            "markers": {"stripe": {"pose": {"xyz": [0.1, 0, 0]}}},
            "joint": {"parent": "base", "axis": [0, 0, 1], "limits": [-1, 1]},
        },
    },
}
SUMMARY = {"sources": ["a"], "frames": 1, "frames_with_error": 0, "objects": {}, "total_ms": None, "problems": []}
SUMMARY |= {"interrupted": False, "looked_for": {}}


def pose_at(x: float, z: float = 1.0) -> Pose:
    """An object that faces the camera, `x` metres to the right, `z` ahead."""
    return Pose(FACING, [x, 0.0, z])


def pixel(x: float, z: float = 1.0) -> float:
    return 79.5 + 200 * x / z


def true_thing(x: float = 0.0, z: float = 1.0, name: str | None = "thing", **changes) -> TrueObject:
    """A thing in full view: base at its place, arm 20 px to its right."""
    size = 200 / z
    at = np.array([pixel(x, z), 59.5])
    components = {
        "base": TrueComponent(0.016 * size**2, 0.016 * size**2, at),
        "arm": TrueComponent(0.0036 * size**2, 0.0036 * size**2, at + (20, 0)),
    }
    return replace(TrueObject(2, pose_at(x, z), components, at, name, {"arm": 0.1}), **changes)


def found_thing(x: float = 0.0, z: float = 1.0, score: float = 0.9, arm: bool = True, **changes) -> Detection:
    u = pixel(x, z)
    parts = [Instance("base", "plate", 0.9, u, 59.5, 0, 200 / z)]
    parts += [Instance("arm", "stripe", 0.9, u + 20, 59.5, 0, 200 / z)] if arm else []
    pose = pose_at(x, z)
    d = Detection("thing", 0, score, ImagePose(u, 59.5, 0, 200 / z), tuple(parts), pose, {"arm": 0.15})
    return replace(d, **changes)


def record(stamp_ns: int, *detections: Detection, ms: float = 10.0, rejected: tuple[Rejection, ...] = (), name="/c"):
    result = FrameResult((160, 120), detections, rejected, {"total": ms, "pose": ms / 2})
    return FrameRecord.of(stamp_ns, name, result, "camera")


def write_run(folder: Path, records: list[FrameRecord], pictures: bool = False, score: float = 0.6) -> Path:
    """What a replay leaves: results, summary, parameters with the object's file, and overlays if asked."""
    (folder / "frames").mkdir(parents=True)
    (folder / "detections.jsonl").write_text("".join(r.to_json() + "\n" for r in records))
    looked_for = {"thing": {"label": 2, "required": "base"}}
    (folder / "summary.json").write_text(json.dumps(SUMMARY | {"looked_for": looked_for}))
    (folder / "thing.yaml").write_text(yaml.safe_dump(OBJECT, sort_keys=False))
    parameters = {"objects": ["thing"], "thing": {"object_file": str(folder / "thing.yaml"), "label": 2},
                  "recognizer": {"min_probability": score}}  # fmt: skip
    (folder / "parameters.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}))
    for i, r in enumerate(records if pictures else ()):
        picture = np.full((480, 640, 3), 90, np.uint8)
        cv2.putText(picture, f"{i}", (20, 60), cv2.FONT_HERSHEY_SIMPLEX, 2, (255, 255, 255), 3)
        cv2.imwrite(str(folder / "frames" / overlay_name(i, r.frame, r.stamp_ns)), picture)
    return folder


def truth_line(stamp_ns: int, *objects: TrueObject) -> str:
    def content(o: TrueObject) -> dict:
        parts = {
            n: {
                "full_px": c.full_px,
                "visible_px": c.visible_px,
                "centre": None if c.centre is None else list(c.centre),
            }
            for n, c in o.components.items()
        }
        pose = {"position": o.pose.position.tolist(), "rotation": o.pose.rotation.tolist()}
        named = {"object": o.name} if o.name else {}
        return named | pose | {"team": o.label, "components": parts, "centre_px": list(o.centre_px), "joints": o.joints}

    return json.dumps({"stamp_ns": stamp_ns, "objects": [content(o) for o in objects]})


def write_truth(path: Path, frames: dict[int, list[TrueObject]]) -> Path:
    path.write_text("".join(truth_line(t, *objects) + "\n" for t, objects in frames.items()))
    return path

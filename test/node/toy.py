"""A toy object of two flat markers, its files and label images of it: all that the node's tests need."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.learning.pair_learning import learn
from artrec_ros.core.model.found import Instance
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import ObjectModel
from artrec_ros.io.learned.constraints import save_constraints
from artrec_ros.io.objects.object_reader import load_object

SIZE = (320, 240)
CAMERA = Camera([[300.0, 0.0, 160.0], [0.0, 300.0, 120.0], [0.0, 0.0, 1.0]], [], SIZE, "camera")
LABEL = 7
KEYS = {"body": ("body", "hull"), "arm": ("arm", "lever")}

OBJECT = """
format: artrec_object/1
name: toy
markers:
  hull:
    outline: [[-0.10, -0.05], [0.10, -0.05], [0.10, 0.0], [0.02, 0.05], [-0.10, 0.05]]
    axis: [[-0.10, 0], [0.10, 0]]
  lever: {outline: [[0.0, -0.015], [0.12, -0.008], [0.12, 0.008], [0.0, 0.015]], axis: [[0, 0], [0.12, 0]]}
components:
  body:
    required: true
    markers:
      hull: {pose: {xyz: [0, 0, 0]}}
  arm:
    markers:
      lever: {pose: {xyz: [0.02, 0, 0]}}
    joint: {parent: body, origin: {xyz: [0, 0.08, 0]}, axis: [0, 0, 1], limits: [-0.6, 0.6], type: revolute}
"""
PARAMETERS = f"""
/**:
  ros__parameters:
    objects: [toy]
    toy: {{object_file: objects/toy.yaml, constraint_file: constraints/toy.yaml, label: {LABEL}}}
    image: {{kind: labels, blank: []}}
    recognizer: {{time_budget_ms: 2000.0}}
    expert: {{alignment: {{refine_steps: 6}}}}
"""


def write_files(folder: Path) -> Path:
    """The parameter file, with the object and the learned constraints that it names beside it."""
    (folder / "objects").mkdir(parents=True)
    (folder / "objects" / "toy.yaml").write_text(OBJECT)
    model = load_object(folder / "objects" / "toy.yaml", None)
    examples = [
        {KEYS[name]: _instance(name, outline, model) for name, outline in _outlines(model, q).items()}
        for q in np.linspace(-0.6, 0.6, 25)
    ]
    save_constraints(folder / "constraints" / "toy.yaml", learn(model, examples))
    path = folder / "toy_node.yaml"
    path.write_text(PARAMETERS)
    return path


def camera_info(matrix: np.ndarray = CAMERA.matrix) -> Any:
    """sensor_msgs/CameraInfo of the camera that `draw` has, or of another matrix."""
    from sensor_msgs.msg import CameraInfo

    msg = CameraInfo(width=SIZE[0], height=SIZE[1], distortion_model="plumb_bob", d=[0.0] * 5)
    msg.k = np.array(matrix, float).reshape(9)
    return msg


def draw(model: ObjectModel, x_m: float, y_m: float, z_m: float, arm_rad: float = 0.2) -> np.ndarray:
    """(H, W) uint8 label image of the toy facing the camera, upright, its origin at a place of the optical frame."""
    image = np.zeros(SIZE[::-1], np.uint8)
    K = CAMERA.matrix
    for outline, _ in _outlines(model, arm_rad).values():
        metric = outline * (1, -1) + (x_m, y_m)  # the object's y is up, the image's down
        pixels = metric / z_m * (K[0, 0], K[1, 1]) + (K[0, 2], K[1, 2])
        cv2.fillPoly(image, [np.round(pixels * 256).astype(np.int32)], LABEL, cv2.LINE_8, 8)
    return image


def _outlines(model: ObjectModel, arm_rad: float) -> dict[str, tuple[np.ndarray, float]]:
    """Each component's outline in the object's plane, x right, y up, and its turn there."""
    hull, lever = (_marker(model, name) for name in ("body", "arm"))
    c, s = np.cos(arm_rad), np.sin(arm_rad)
    return {
        "body": (hull.outline, 0.0),
        "arm": ((lever.outline + (0.02, 0)) @ np.array([[c, s], [-s, c]]) + (0, 0.08), arm_rad),
    }


def _marker(model: ObjectModel, component: str) -> Marker:
    return model.component(component).markers[0]


def _instance(component: str, placed: tuple[np.ndarray, float], model: ObjectModel) -> Instance:
    outline, turn = placed
    marker = _marker(model, component)
    # the outline moved rigidly: so did its centroid
    moved = Marker(marker.name, outline, outline[0], outline[1])
    x, y = moved.centroid * 1000 * (1, -1)
    return Instance(component, marker.name, 1.0, x, y, marker.axis_angle - turn, 1000.0)

"""Gestures of one object told apart, and one that was never taught refused: in the image plane, and in space.

    python benchmarks/gestures.py OUTPUT_DIR [--frames 40] [--examples 40] [--noise 1] [--path flat|space]

Everything is made here, from files alone: an object file, rendered label images with light, blur, noise, speckle and
things that belong to nothing, annotations (a COCO category for each gesture), constraints learned from them by
`artrec train`, a parameter file. Joints scatter about each gesture, the object turns out of the image plane. Each frame
that is scored was not trained on. Prints how many are right, and writes OUTPUT_DIR/result.json.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from artrec_ros.core.drawing import draw_result
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.model.found import Detection
from artrec_ros.core.model.target import Target
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.records import CocoBuilder
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import PlacedObject, Scene, sample_distractors
from artrec_ros.simulation.sensor import colour_image, label_image
from artrec_ros.simulation.simulator import SimulatedFrame, pinhole_camera
from artrec_ros.simulation.truth import measure
from artrec_ros.tools.main import main as artrec

LABEL = 3
SIZE, VIEW_DEG = (640, 480), 60.0
JOINTS = ("upper_left", "fore_left", "upper_right", "fore_right")
GESTURES = {  # radians, in the order of JOINTS; 0: the arm hangs, straight
    "up": (2.6, 0.0, -2.6, 0.0),
    "stop": (1.57, 1.4, -0.15, 0.0),
    "right": (0.15, 0.0, -1.57, 0.0),
    "hips": (0.7, -1.4, -0.7, 1.4),
}
UNTAUGHT = {"left": (1.57, 0.0, -0.15, 0.0)}  # one joint away from `stop`
SCATTER_RAD = 0.1  # standard deviation of each joint about its gesture's
TILT_RAD = 0.08
HEADING_RAD = {"flat": 0.3, "space": 0.6}  # greatest turn away from the camera

OBJECT = """\
format: artrec_object/1
name: signaller
markers:
  chest:
    outline: [[-0.08, -0.10], [0.08, -0.10], [0.08, 0.02], [0.03, 0.10], [-0.08, 0.10]]
    axis: [[0.0, -0.10], [0.0, 0.10]]
  upper: {outline: [[-0.026, -0.15], [0.026, -0.15], [0.026, -0.03], [-0.026, -0.03]], axis: [[0, -0.03], [0, -0.15]]}
  fore: {outline: [[-0.015, -0.19], [0.015, -0.19], [0.028, -0.03], [-0.028, -0.03]], axis: [[0, -0.03], [0, -0.19]]}
components:
  torso:
    required: true
    markers: {chest: {pose: {xyz: [0.051, 0, 0], x_axis: [0, 1, 0], y_axis: [0, 0, 1]}}}
    body: {label: 5, boxes: [{xyz: [0, 0, 0], size: [0.1, 0.2, 0.24]}]}
"""
ARM = """\
  upper_{side}:
    markers: {{upper: {{pose: {{xyz: [0.021, 0, 0], x_axis: [0, 1, 0], y_axis: [0, 0, 1]}}}}}}
    joint: {{parent: torso, origin: {{xyz: [0.03, {y}, 0.09]}}, axis: [1, 0, 0], limits: [{low}, {high}]}}
    body: {{label: 5, boxes: [{{xyz: [0, 0, -0.09], size: [0.04, 0.06, 0.18]}}]}}
  fore_{side}:
    markers: {{fore: {{pose: {{xyz: [0.021, 0, 0], x_axis: [0, 1, 0], y_axis: [0, 0, 1]}}}}}}
    joint: {{parent: upper_{side}, origin: {{xyz: [0, 0, -0.18]}}, axis: [1, 0, 0], limits: [-2.4, 2.4]}}
    body: {{label: 5, boxes: [{{xyz: [0, 0, -0.1], size: [0.04, 0.05, 0.2]}}]}}
"""
PARAMETERS = f"""\
/**:
  ros__parameters:
    objects: [signaller]
    signaller: {{object_file: object.yaml, constraint_file: constraints.yaml, label: {LABEL}}}
    image: {{kind: labels}}
    recognizer: {{time_budget_ms: 20000.0}}
"""


@dataclass(frozen=True)
class Outcome:
    """What was said of one frame whose gesture is known."""

    gesture: str
    found: bool
    told: str | None
    confidence: float


def write_object(folder: Path) -> None:
    left = ARM.format(side="left", y=0.13, low=-0.3, high=3.0)
    right = ARM.format(side="right", y=-0.13, low=-3.0, high=0.3)
    (folder / "object.yaml").write_text(OBJECT + left + right, encoding="utf-8")
    (folder / "params.yaml").write_text(PARAMETERS, encoding="utf-8")


def place(target: Target, angles: tuple[float, ...], heading_rad: float, rng: np.random.Generator) -> PlacedObject:
    """The object before the camera, turned by up to `heading_rad`, its joints about the gesture's."""
    facing = np.column_stack([(0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)])  # x to the camera, z up
    turn = rotation_from_rotvec([0.0, 0.0, rng.uniform(-heading_rad, heading_rad)])
    tilt = rotation_from_rotvec(rng.normal(0, TILT_RAD, 3))
    depth = rng.uniform(1.25, 1.9)
    position = np.array([rng.uniform(-0.2, 0.2) * depth, rng.uniform(-0.04, 0.04) * depth, depth])
    joints = {}
    for name, angle in zip(JOINTS, angles, strict=True):
        joint = target.model.component(name).joint
        assert joint is not None
        joints[name] = float(np.clip(angle + rng.normal(0, SCATTER_RAD), joint.lower, joint.upper))
    return PlacedObject(target, Pose(facing @ turn @ tilt, position), joints)


def frames(
    target: Target, gesture: str, count: int, heading_rad: float, sensor: SensorConfig, seed: int
) -> Iterator[SimulatedFrame]:
    """Frames of one gesture; frame i depends on the seed, the gesture and i alone."""
    angles = {**GESTURES, **UNTAUGHT}[gesture]
    camera = pinhole_camera(SIZE, VIEW_DEG)
    renderer = Renderer(camera)
    number = [*GESTURES, *UNTAUGHT].index(gesture)
    for index, child in enumerate(np.random.SeedSequence([seed, number]).spawn(count)):
        rng = np.random.default_rng(child)
        placed = place(target, angles, heading_rad, rng)
        scene = Scene((placed,), tuple(sample_distractors([target], [placed], camera, SceneConfig(), rng)), None)
        rendering = renderer.render(scene)
        colour = colour_image(rendering, sensor, rng)
        labels = label_image(rendering, colour, sensor, rng)
        yield SimulatedFrame(index, camera, scene, labels, colour, measure(rendering, scene.objects, camera))


def train(folder: Path, examples: int, heading_rad: float, sensor: SensorConfig) -> None:
    """Annotated examples, and what `artrec train` learns from them."""
    model = load_object(folder / "object.yaml", {})
    targets = [Target(name, model, LABEL) for name in GESTURES]
    coco = CocoBuilder.of(targets)
    for target in targets:
        for frame in frames(target, target.name, examples, heading_rad, sensor, seed=1):
            numbered = dataclasses.replace(frame, index=len(coco.content["images"]))
            coco.add(numbered, f"{target.name}_{frame.index}.png")
    (folder / "annotations.json").write_text(json.dumps(coco.content), encoding="utf-8")
    files = ["--object", str(folder / "object.yaml"), "--annotations", str(folder / "annotations.json")]
    if artrec(["train", *files, "--category", *GESTURES, "--output", str(folder / "constraints.yaml")]):
        raise SystemExit("artrec train failed")


def recognise(folder: Path, path: str, count: int, sensor: SensorConfig) -> list[Outcome]:
    """Every gesture, taught or not; the first frames' overlays are written to `folder`."""
    setup = load_parameters(folder / "params.yaml")
    recognizer, target = setup.build(), setup.targets[0]
    outcomes, used_s = [], 0.0
    for gesture in (*GESTURES, *UNTAUGHT):
        for frame in frames(target, gesture, count, HEADING_RAD[path], sensor, seed=2):
            camera: Camera | None = frame.camera if path == "space" else None
            start = time.process_time()
            result = recognizer.recognize(frame.labels, camera)
            used_s += time.process_time() - start
            outcomes.append(outcome(gesture, frame, result.detections))
            if frame.index < 3:
                picture = draw_result(frame.labels, result, [target.name], camera)
                cv2.imwrite(str(folder / f"{path}_{gesture}_{frame.index}.png"), picture)
    print(f"{path}: {1e3 * used_s / len(outcomes):.0f} ms of processor time a frame")
    return outcomes


def outcome(gesture: str, frame: SimulatedFrame, detections: tuple[Detection, ...]) -> Outcome:
    """Of the detection that lies on the object."""
    (truth,) = (m for m in frame.truths[0].markers if m.component == "torso")
    reach = np.sqrt(truth.full_px) / 2
    for d in detections:
        at = truth.centre if truth.centre is not None else frame.truths[0].centre_px
        if np.hypot(*(np.array([d.image.x, d.image.y]) - at)) < reach and d.class_fit is not None:
            return Outcome(gesture, True, d.class_fit.name, d.class_fit.confidence)
    return Outcome(gesture, False, None, 0.0)


def report(path: str, outcomes: list[Outcome]) -> dict[str, float]:
    """Prints a table; of the objects that were found, the share that is right, and of the untaught, refused."""
    columns = [*GESTURES, "none", "not found"]
    print(f"\n{path}: {'shown':10} " + " ".join(f"{c:>9}" for c in columns))
    for gesture in (*GESTURES, *UNTAUGHT):
        told = Counter((o.told or "none") if o.found else "not found" for o in outcomes if o.gesture == gesture)
        print(f"{'':{len(path) + 1}} {gesture:10} " + " ".join(f"{told[c]:9d}" for c in columns))
    taught = [o for o in outcomes if o.gesture in GESTURES]
    others = [o for o in outcomes if o.gesture in UNTAUGHT]
    sure = [o for o in outcomes if o.told is not None]
    rates = {
        "right": sum(o.told == o.gesture for o in taught) / len(taught),
        "right_of_found": sum(o.told == o.gesture for o in taught) / max(1, sum(o.found for o in taught)),
        "refused": sum(o.told is None for o in others) / len(others),
        "refused_and_found": sum(o.found and o.told is None for o in others) / len(others),
        "mean_confidence": float(np.mean([o.confidence for o in sure])) if sure else 0.0,
        "confident_right": sum(o.told == o.gesture for o in sure) / max(1, len(sure)),
    }
    print("  ".join(f"{name} {value:.3f}" for name, value in rates.items()))
    return rates


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    parser.add_argument("--frames", type=int, default=40, help="scored frames of each gesture")
    parser.add_argument("--examples", type=int, default=40, help="annotated examples of each gesture")
    parser.add_argument("--noise", type=float, default=1.0, help="factor of the sensor's disturbances")
    parser.add_argument("--path", choices=("flat", "space"), action="append")
    args = parser.parse_args()
    sensor = SensorConfig().scaled(args.noise)
    rates = {}
    for path in args.path or ("flat", "space"):
        folder = args.output / path
        folder.mkdir(parents=True, exist_ok=True)
        write_object(folder)
        train(folder, args.examples, HEADING_RAD[path], sensor)
        rates[path] = report(path, recognise(folder, path, args.frames, sensor))
    (args.output / "result.json").write_text(json.dumps(rates, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

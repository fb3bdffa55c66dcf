"""Small things on a table under a camera whose height and slant are known (`scene.floor`): how exact, how sure.

    python benchmarks/on_floor.py [--frames 40] [--tolerance-m 0.02] [--tilt-deg 5]

Cubes of 3 cm, bricks, and lorries with a tray that tips, four to eight in a picture of 640×480, cubes some 20 px wide.
Of each view a row: objects, those told at `recognizer.min_probability`, of these right (range within a tenth, turn
within 20 degrees, modulo the turns after which a box looks the same, joint within .3) and others' places; range and
turn, median and what nine in ten stay below; what share of places lies in 90 % and 50 % regions; log-loss of scores
as probabilities to be right; CPU time a picture.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import chi2

from artrec_ros.core.base.config import FloorConfig, ImageConfig, RecognizerConfig
from artrec_ros.core.base.config import SceneConfig as KnownScene
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Array, Pose, rotation_from_rpy, rotvec_from_rotation
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import Detection
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.objects.solids import box_solid
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import Floor, PlacedObject, Scene, sample_distractors
from artrec_ros.simulation.simulator import SimulatedFrame, pinhole_camera, render_frame

CAMERA = pinhole_camera((640, 480), 50.0)
OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # to x ahead, y left, z up
LEAST = 0.05  # probability of what is scored, be it told or not


@dataclass(frozen=True)
class View:
    """A camera over a table: how steep, how far from its middle; how far objects hang in the air at most; clutter."""

    name: str
    slant_deg: float
    away_m: float
    seed: int
    lift_m: float = 0.0
    clutter: int = 3

    @property
    def camera_from_room(self) -> Pose:
        turn = rotation_from_rpy(np.radians([0.0, self.slant_deg, 0.0])) @ OPTICAL
        return Pose(turn, np.array([0.0, 0.0, self.height_m])).inverse()

    @property
    def height_m(self) -> float:
        return float(self.away_m * np.sin(np.radians(self.slant_deg)))


VIEWS = (
    View("from above", 88.0, 0.9, 1),
    View("at a slant", 50.0, 0.9, 2),
    View("up to 4 cm in the air", 75.0, 0.9, 3, lift_m=0.04),
    View("clutter", 80.0, 1.1, 5, clutter=12),
)


def solid(
    name: str, size: tuple[float, ...], at: tuple[float, ...], label: int, joint: Joint | None = None
) -> Component:
    sides, bodies = box_solid(Box(Pose.from_xyz_rpy(at), np.array(size)))
    return Component(name, sides, joint is None, label=label, joint=joint, bodies=bodies, body_label=label)


HINGE = Joint("bed", Pose.from_xyz_rpy((-0.05, 0, 0.02)), np.array([0.0, -1.0, 0.0]), 0.0, 0.9)
BED, TRAY = ((0.10, 0.05, 0.02), (0, 0, 0.01)), ((0.06, 0.045, 0.02), (0.03, 0, 0.01))
TARGETS = (
    Target("cube", ObjectModel("cube", (solid("block", (0.03, 0.03, 0.03), (0, 0, 0.015), 2),)), 2),
    Target("brick", ObjectModel("brick", (solid("block", (0.06, 0.04, 0.025), (0, 0, 0.0125), 3),)), 3),
    Target("lorry", ObjectModel("lorry", (solid("bed", *BED, 6), solid("tray", *TRAY, 7, HINGE))), 6),
)  # fmt: skip
TURNS, LENGTH_M = {"cube": 4, "brick": 2, "lorry": 1}, {"cube": 0.03, "brick": 0.06, "lorry": 0.10}


def frames(view: View, count: int) -> Iterator[SimulatedFrame]:
    """Pictures of objects apart from each other."""
    renderer, T = Renderer(CAMERA), view.camera_from_room
    up = T.rotation[:, 2]
    table = Floor(up, float(up @ T.position), 1)
    for n, seed in enumerate(np.random.SeedSequence(view.seed).spawn(count)):
        rng = np.random.default_rng(seed)
        placed = list[PlacedObject]()
        at = list[Array]()
        for _ in range(int(rng.integers(4, 9))):
            target = TARGETS[int(rng.integers(len(TARGETS)))]
            place = _free_place(view, at, rng)
            if place is None:
                continue
            at.append(place)
            height, tilt = rng.uniform(0, view.lift_m), rng.normal(0, np.radians(0.5), 2)
            in_room = Pose(rotation_from_rpy([*tilt, rng.uniform(-np.pi, np.pi)]), np.array([*place, height]))
            joints = {name: float(rng.uniform(0, 0.9)) for name in target.model.joint_names}
            placed.append(PlacedObject(target, T @ in_room, joints))
        clutter = sample_distractors(TARGETS, placed, CAMERA, SceneConfig(distractors=view.clutter), rng)
        yield render_frame(n, renderer, Scene(tuple(placed), tuple(clutter), table), SensorConfig(), rng)


def _free_place(view: View, taken: list[Array], rng: np.random.Generator) -> Array | None:
    middle = np.array([view.away_m * np.cos(np.radians(view.slant_deg)), 0.0])
    for _ in range(50):
        place = middle + rng.uniform(-0.45, 0.45, 2) * view.away_m * (0.7, 0.8)
        pixel = project(CAMERA, view.camera_from_room.apply(np.array([[*place, 0.0]])))[0]
        inside = (pixel > 45).all() and (pixel < np.array(CAMERA.size) - 45).all()
        if inside and all(np.linalg.norm(place - other) > 0.13 for other in taken):
            return np.asarray(place)
    return None


@dataclass
class Tally:
    """What is told in one view."""

    objects: int = 0
    told: list[tuple[float, float, float]] = field(default_factory=list)  # range, turn, square of the place's error
    scores: list[tuple[float, bool]] = field(default_factory=list)
    right: int = 0
    false: int = 0
    seconds: float = 0.0

    def add(self, frame: SimulatedFrame, detections: tuple[Detection, ...], least: float) -> None:
        left = [t.placed for t in frame.truths]
        self.objects += len(left)
        for d in detections:
            mine = next((p for p in left if p.target.name == d.object and _is_on(d, p)), None)
            off = None if mine is None else _errors(d, mine)
            right = bool(mine and off and off[0] < 0.1 and off[1] < 20 and _is_bent_so(d, mine))
            self.scores.append((d.score, right))
            left = [p for p in left if p is not mine]
            if d.score >= least:
                self.right, self.false = self.right + right, self.false + (off is None)
                self.told += [] if off is None else [off]

    def row(self, name: str) -> str:
        away, turn, square = np.array(self.told).T
        score, right = np.clip([s for s, _ in self.scores], 1e-3, 0.999), np.array([r for _, r in self.scores])
        loss = -np.mean(np.log(np.where(right, score, 1 - score)))
        held = [np.mean(square < chi2.ppf(share, 3)) for share in (0.9, 0.5)]
        return (
            f"| {name} | {self.objects} | {len(self.told)} | {self.right} | {self.false} | "
            f"{100 * np.median(away):.2f} %, {100 * np.quantile(away, 0.9):.2f} % | "
            f"{np.median(turn):.1f}°, {np.quantile(turn, 0.9):.1f}° | {held[0]:.2f}, {held[1]:.2f} | {loss:.3f} | "
            f"{1000 * self.seconds:.0f} |"
        )


def _is_on(d: Detection, placed: PlacedObject) -> bool:
    assert d.pose is not None
    here, there = project(CAMERA, np.stack([d.pose.position, placed.T_camera_object.position]))
    size_px = CAMERA.focal_px * LENGTH_M[d.object] / placed.T_camera_object.position[2]
    return bool(np.linalg.norm(here - there) < 0.7 * size_px)


def _errors(d: Detection, placed: PlacedObject) -> tuple[float, float, float]:
    assert d.pose is not None and d.pose_covariance is not None
    true, off = placed.T_camera_object, d.pose.position - placed.T_camera_object.position
    ways = 2 * np.pi / TURNS[d.object] * np.arange(TURNS[d.object])
    turns = [true.rotation.T @ d.pose.rotation @ rotation_from_rpy([0, 0, way]) for way in ways]
    turn = np.degrees(np.linalg.norm(rotvec_from_rotation(np.array(turns)), axis=-1).min())
    away = abs(np.linalg.norm(d.pose.position) / np.linalg.norm(true.position) - 1)
    return float(away), float(turn), float(off @ np.linalg.solve(d.pose_covariance[:3, :3], off))


def _is_bent_so(d: Detection, placed: PlacedObject) -> bool:
    return all(abs(d.joints.get(name, value) - value) < 0.3 for name, value in placed.joints.items())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=40, help="of each view")
    parser.add_argument("--tolerance-m", type=float, default=0.02)
    parser.add_argument("--tilt-deg", type=float, default=5.0)
    args = parser.parse_args()
    for view in VIEWS:
        floor = FloorConfig(
            camera_height_m=view.height_m, camera_pitch_deg=view.slant_deg, object_height_m=view.lift_m / 2,
            height_tolerance_m=args.tolerance_m, max_tilt_deg=args.tilt_deg,
        )  # fmt: skip
        config = RecognizerConfig(min_probability=LEAST, time_budget_ms=60000.0, scene=KnownScene(floor=floor))
        engine, tally = Recognizer(TARGETS, config, Segmenter(ImageConfig())), Tally()
        for frame in frames(view, args.frames):
            begun = time.process_time()
            found = engine.recognize(frame.labels, CAMERA).detections
            tally.seconds += (time.process_time() - begun) / args.frames
            tally.add(frame, found, RecognizerConfig().min_probability)
        print(tally.row(view.name), flush=True)


if __name__ == "__main__":
    main()

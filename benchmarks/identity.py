"""How well objects keep their names: switches, lent names and purity of ids in simulated motion.

    python benchmarks/identity.py                       # 50 sequences, poses with noise, misses and false ones
    python benchmarks/identity.py --images 100          # 100 rendered frames, recognised (a second or so a frame)

A switch: an object's id is another one than when it was last found. A lent name: an id that two objects bore.
Purity: share of detections whose id is that of the object it was first given to. Both runs are seeded.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from artrec_ros.core.base.config import TrackingConfig
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.model.found import Detection, ImagePose
from artrec_ros.core.model.frame_result import FrameResult
from artrec_ros.core.tracking.tracker import Tracker
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.motion import MotionConfig, moving_scenes, simulate_motion
from artrec_ros.simulation.scene import PlacedObject, sample_scene
from artrec_ros.simulation.simulator import PERIOD_NS, START_NS, pinhole_camera

CONFIG = Path(__file__).parents[1] / "config"
NEAR = 0.15  # a detection this share of its range from an object is that object


@dataclass
class Score:
    """What happened to the names of one sequence after another."""

    found: int = 0
    missed: int = 0
    false: int = 0
    switches: int = 0
    lent: int = 0
    pure: int = 0
    _of_truth: dict[int, tuple[str, int]] = field(default_factory=dict)
    _owner: dict[tuple[str, int], int] = field(default_factory=dict)
    _lent: set[tuple[str, int]] = field(default_factory=set)

    def begin(self) -> None:
        self._of_truth, self._owner, self._lent = {}, {}, set()

    def add(self, pairs: Iterable[tuple[int, Detection | None]], false: int) -> None:
        """:param pairs: for each object of the scene what found it."""
        self.false += false
        for truth, detection in pairs:
            if detection is None:
                self.missed += 1
                continue
            name = (detection.object, detection.id)
            self.found += 1
            self.switches += self._of_truth.get(truth, name) != name
            self._of_truth[truth] = name
            owner = self._owner.setdefault(name, truth)
            self.pure += owner == truth
            if owner != truth and name not in self._lent:
                self._lent.add(name)
                self.lent += 1

    def line(self) -> str:
        return (
            f"found {self.found}, missed {self.missed}, false {self.false}: "
            f"switches {self.switches}, lent names {self.lent}, purity {self.pure / max(self.found, 1):.5f}"
        )


def with_noise(
    objects: dict[int, PlacedObject], rng: np.random.Generator, missing: float, in_image: bool
) -> Iterator[tuple[int, Detection]]:
    """Detections as a recogniser gives them; -1: one that belongs to nothing."""
    for number, placed in objects.items():
        if rng.random() >= missing:
            yield number, _detection(placed.target.name, placed.T_camera_object, rng, in_image)
    if rng.random() < 0.1:
        at = Pose(rotation_from_rotvec(rng.normal(0, 1.5, 3)), rng.uniform((-0.7, -0.4, 0.8), (0.7, 0.4, 2.5)))
        yield -1, _detection(next(iter(objects.values())).target.name, at, rng, in_image)


def _detection(name: str, truth: Pose, rng: np.random.Generator, in_image: bool) -> Detection:
    z = max(truth.position[2], 0.05)
    sigma = np.array([0.003, 0.003, 0.012, 0.06, 0.06, 0.06]) * [z, z, z, 1, 1, 1]
    noise = rng.normal(0, sigma)
    R = rotation_from_rotvec(noise[3:]) @ truth.rotation
    if rng.random() < 0.03:  # a mirrored turn
        R = rotation_from_rotvec([0.0, 1.0, 0.0]) @ R
    t = truth.position + noise[:3]
    theta = np.arctan2(R[1, 0], R[0, 0])
    image = ImagePose(300 * t[0] / z + 160, 300 * t[1] / z + 120, float(theta), 300 / z * np.exp(rng.normal(0, 0.02)))
    return Detection(name, 0, 0.9, image, (), None if in_image else Pose(R, t), {}, np.diag(sigma**2))


def sequences(count: int, frames: int, missing: float, in_image: bool, config: TrackingConfig) -> Score:
    """Sequences of three objects of one name that pass before each other. Each gives way to another at some time."""
    score = Score()
    targets = load_parameters(CONFIG / "excavator.yaml").targets[:1]
    camera, scene = pinhole_camera((320, 240), 60), SceneConfig(objects=(3, 3), size=(0.15, 0.4))
    for seed in range(count):
        rng = np.random.default_rng(seed)
        starts = [sample_scene(targets, camera, scene, rng) for _ in range(2)]
        n = min(len(s.objects) for s in starts)
        first, second = (moving_scenes(s, MotionConfig(0.6, 0.6), rng) for s in starts)
        change = rng.integers(frames // 4, frames, n)
        tracker = Tracker(config)
        score.begin()
        for index, old, new in zip(range(frames), first, second, strict=False):
            truths = [k if index < change[k] else n + k for k in range(n)]
            objects = {t: (old.objects + new.objects[:n])[t if t < n else len(old.objects) + t - n] for t in truths}
            seen = list(with_noise(objects, rng, missing, in_image))
            rng.shuffle(seen)
            result = FrameResult((320, 240), tuple(d for _, d in seen))
            named = tracker.update(START_NS + index * PERIOD_NS, result).detections
            found = {t: d for (t, _), d in zip(seen, named, strict=True)}
            false = found.pop(-1, None) is not None
            score.add(((t, found.get(t)) for t in truths), false)
    return score


def rendered(frames: int, params_file: Path, seed: int) -> Score:
    """One sequence through renderer, recogniser and tracker."""
    setup = load_parameters(params_file)
    recognizer, tracker, score = setup.build(), Tracker(TrackingConfig()), Score()
    camera = pinhole_camera((320, 240), 60)
    scene = SceneConfig(objects=(2, 3), size=(0.2, 0.4))
    score.begin()
    for frame in simulate_motion(setup.targets, camera, scene, MotionConfig(), SensorConfig(), seed, frames):
        result = tracker.update(frame.stamp_ns, recognizer.recognize(frame.labels, camera), camera.frame_id)
        left = list(result.detections)
        pairs: list[tuple[int, Detection | None]] = []
        for n, placed in enumerate(frame.scene.objects):
            there = placed.T_camera_object.position
            apart = [
                np.linalg.norm(d.pose.position - there) / there[2]
                if d.pose is not None and d.object == placed.target.name
                else np.inf
                for d in left
            ]
            best = int(np.argmin(apart)) if left else -1
            pairs.append((n, left.pop(best) if left and apart[best] < NEAR else None))
        score.add(pairs, len(left))
    return score


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sequences", type=int, default=50)
    parser.add_argument("--frames", type=int, default=150, help="of each sequence")
    parser.add_argument("--images", type=int, metavar="FRAMES", help="render and recognise so many frames instead")
    parser.add_argument("--params-file", type=Path, default=CONFIG / "aibo.yaml", help="with --images")
    parser.add_argument("--seed", type=int, default=0, help="with --images")
    parser.add_argument("--newcomer-odds", type=float, default=TrackingConfig().newcomer_odds)
    args = parser.parse_args()
    if args.images:
        print(f"rendered: {rendered(args.images, args.params_file, args.seed).line()}")
        return
    config = TrackingConfig(newcomer_odds=args.newcomer_odds)
    for in_image in (False, True):
        for missing in (0.0, 0.1, 0.3, 0.5):
            line = sequences(args.sequences, args.frames, missing, in_image, config).line()
            print(f"{'in the image' if in_image else 'in space'}, {missing:.0%} missed: {line}", flush=True)


if __name__ == "__main__":
    main()

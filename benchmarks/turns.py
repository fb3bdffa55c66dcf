"""Which of two mirrored turns a pose has, and which of two bends a joint: fits `expert.verdict.turn_odds` and
`bend_odds_colour`, and what of it counts over time in videos.

    python benchmarks/turns.py --worlds 120                  # stills and videos of random objects; an hour
    python benchmarks/turns.py --worlds 120 --save turns.npz
    python benchmarks/turns.py --load turns.npz              # fits again

A third of the worlds have objects of which all markers lie in one plane, a third flaps on hinges, the others random
trees. From labels, and from
colour images of the same scenes. Fitted on even-numbered worlds, told of odd ones; seeded.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from random_solids import (
    BODY,
    LABELS,
    OTHER,
    RIGHT,
    SHARES,
    SIZES,
    World,
    _marker,
    random_frames,
    random_outline,
    random_world,
)
from scipy.optimize import minimize
from tqdm import tqdm

from artrec_ros.core.base.config import ClassConfig, ImageConfig, RecognizerConfig, VerdictConfig
from artrec_ros.core.geometry.transforms import Array, Pose, rotvec_from_rotation
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import other_bends, turn_evidence
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.tracking.turns import combined
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.motion import MotionConfig, simulate_motion
from artrec_ros.simulation.sensor import palette
from artrec_ros.simulation.simulator import PERIOD_NS, SimulatedFrame, pinhole_camera

STILLS, SECONDS = 8, 3.0  # of each world
NEAR_RAD, NEAR_SHARE = np.radians(15), 0.1  # of the truth: turn, and place as a share of the range
BEND = 0.35  # of the way to the other bend: who is as near to the truth is right
SPARSE = 3  # videos are of every third image
COLOURED = ImageConfig(
    kind="colour",
    classes={
        f"class{label}": ClassConfig(label=label, rgb=tuple(int(v) for v in palette()[label][::-1]))
        for label in (*LABELS, OTHER, BODY)
    },
)
CORRELATIONS, MEMORIES_S = (0.0, 0.05, 0.1, 0.2, 0.4, 1.0), (0.3, 1.0, 3.0, 10.0)


class Recorder:
    """What the recogniser finds to speak for mirrored turns."""

    def __init__(self, near_rad: float = NEAR_RAD, near_share: float = NEAR_SHARE, *, mirrored: bool = True) -> None:
        """:param near_rad, near_share: of the truth is right; turn, and place as a share of the range.
        :param mirrored: whether mirrored turns are recorded."""
        self._near, self._mirrored = (near_rad, near_share), mirrored
        self._plain, self.rows = turn_evidence.evidence, list[tuple[str, Pose, Pose, float, float]]()
        vars(turn_evidence)["evidence"] = self._evidence
        self._plain_bends, self.bends = other_bends.bend_evidence, list[tuple[str, Pose, str, float, float, Any]]()
        vars(other_bends)["bend_evidence"] = self._bend_evidence

    def _evidence(
        self, finder: Any, frame: Any, poses: Any, mirrored: Any, component: int | None = None, **exchanged: bool
    ) -> turn_evidence.Evidence:
        found, name = self._plain(finder, frame, poses, mirrored, component, **exchanged), finder.target.name
        whole = component is None and not exchanged  # weights are of all that is known
        for n in range(len(poses) if self._mirrored and whole else 0):
            both = (Pose(p.R[n], p.t[n]) for p in (poses, mirrored))
            self.rows.append((name, *both, float(found.votes[n]), float(found.contours[n])))
        return found

    def _bend_evidence(self, finder: Any, frame: Any, poses: Any, bends: other_bends.Bends) -> turn_evidence.Evidence:
        found, names = self._plain_bends(finder, frame, poses, bends), finder.target.model.joint_names
        for n, (h, j) in enumerate(zip(bends.of.tolist(), bends.joint.tolist(), strict=True)):
            of, both = Pose(poses.R[h], poses.t[h]), (float(poses.q[h, j]), float(bends.q[n]))
            evidence = float(found.votes[n]), float(found.contours[n])
            self.bends.append((finder.target.name, of, names[j], *both, evidence))
        return found

    def of_bends(self, frame: SimulatedFrame) -> Iterator[tuple[bool, float, float]]:
        """Of the frame looked at last: of each joint with another bend one of which is right, as `of`."""
        for name, pose, joint, told, other, evidence in self.bends:
            true = [p for p in frame.scene.objects if p.target.name == name and self._is(pose, p.T_camera_object)]
            off = [abs(q - true[0].joints[joint]) < BEND * abs(told - other) for q in (told, other)] if true else [True]
            if sum(off) == 1 < len(off):
                yield off[1], *evidence

    def of(
        self, recognizer: Recognizer, frame: SimulatedFrame, *, colour: bool = False
    ) -> Iterator[tuple[bool, float, float]]:
        """Of each pose with a mirrored turn one of which is right: whether that is the mirrored one, and evidence."""
        self.rows.clear()
        self.bends.clear()
        recognizer.recognize(frame.colour if colour else frame.labels, frame.camera)
        for name, told, other, votes, contours in self.rows:
            right = [any(self._is(pose, p.T_camera_object) for p in frame.scene.objects if p.target.name == name)
                     for pose in (told, other)]  # fmt: skip
            if right[0] != right[1]:
                yield right[1], votes, contours

    def _is(self, pose: Pose, truth: Pose) -> bool:
        off = np.linalg.norm(pose.position - truth.position) / np.linalg.norm(truth.position)
        turned = np.linalg.norm(rotvec_from_rotation(pose.rotation @ truth.rotation.T))
        return bool(off < self._near[1] and turned < self._near[0])


def plates(seed: int) -> World:
    """An object of one to three markers in one plane, some on a board."""
    rng = np.random.default_rng([77, seed])
    count, size, out = int(rng.integers(1, 4)), rng.uniform(0.05, 0.12, 2), 0.004 * RIGHT[:, 2]
    board = Box(Pose(RIGHT, np.zeros(3)), np.array([*size * rng.uniform(1.1, 2, 2), 0.006]))
    first = _marker("m0", random_outline(size, rng), Pose(RIGHT, out))
    components = [Component("c0", (first,), True, None, None, (board,) * int(rng.random() < 0.7))]
    for n in range(1, count):
        side = rng.uniform(0.03, 0.07, 2)
        at = np.array([0.6 * (size[0] + side[0]) * (1 if n == 1 else -0.3), rng.uniform(-0.12, 0.03), 0.0])
        joint = Joint("c0", Pose(RIGHT, RIGHT @ at + out), np.array([0, 0, 1.0]), 0.0, 0.0, "fixed")
        marker = _marker("m", random_outline(side, rng), Pose(np.eye(3), np.array([0, 0, 0.001])))
        components.append(Component(f"c{n}", (marker,), False, (None, OTHER)[int(rng.random() < 0.4)], joint, ()))
    return World((Target("one", ObjectModel("one", tuple(components)), LABELS[0]),), ())


def hinges(seed: int) -> World:
    """A box with a marker on top, and one to four flaps on hinges around it, some with another one at their ends."""
    rng = np.random.default_rng([79, seed])
    size, top = rng.uniform(0.08, 0.16, 2), 0.02
    box = Box(Pose(np.eye(3), np.zeros(3)), np.array([*size * rng.uniform(1.05, 1.3, 2), 2 * top]))
    first = _marker("m", random_outline(size, rng), Pose(np.eye(3), np.array([0, 0, top + 0.001])))
    components, own, bodies = [Component("c0", (first,), True, None, None, (box,))], rng.random() < 0.7, rng.random()
    for turn in rng.permutation(4)[: int(rng.integers(1, 5))].tolist():
        out, length, width = size[turn % 2] * 0.65, rng.uniform(0.05, 0.12), rng.uniform(0.03, 0.08)
        place, parent = Pose.from_xyz_rpy((0, 0, 0), (0, 0, turn * np.pi / 2)), "c0"
        place = Pose(place.rotation, place.rotation @ (out, 0, 0))
        for _ in range(1 + int(rng.random() < 0.3)):
            name, low, high = f"c{len(components)}", rng.uniform(-1.2, -0.3), rng.uniform(0.3, 1.2)
            joint = Joint(parent, place, np.array([0, 1.0, 0]), float(low), float(high))
            flap = random_outline(np.array([length, width]), rng)
            marker = _marker("m", flap, Pose(np.eye(3), np.array([0.55 * length, 0, 0.004])))
            thin = Box(Pose(np.eye(3), np.array([0.55 * length, 0, 0])), np.array([1.05 * length, 1.1 * width, 0.006]))
            label = OTHER if own else None
            components.append(Component(name, (marker,), False, label, joint, (thin,) if bodies < 0.6 else ()))
            place, parent = Pose(np.eye(3), np.array([1.15 * length, 0, 0])), name
    return World((Target("one", ObjectModel("one", tuple(components)), LABELS[0]),), ())


def record(first: int, worlds: int, *, videos_too: bool = True) -> dict[str, Array]:
    """Of stills (n, 4), from labels and from colours: world, whether the mirrored turn is right, evidence of votes and
    contours, and the same of bends; of videos (m, 5): the same of turns, and the second."""
    recorder, stills, videos, colours, bends, coloured = Recorder(), *(list[tuple[float, ...]]() for _ in range(5))
    for world in tqdm(range(first, first + worlds), disable=None):
        made = (random_world, plates, hinges)[world // 2 % 3](world)
        recognizer, in_colour = (
            Recognizer(list(made.targets), RecognizerConfig(), Segmenter(image)) for image in (ImageConfig(), COLOURED)
        )
        for frame in random_frames(made, world, STILLS):
            stills += [(world, *row) for row in recorder.of(recognizer, frame)]
            bends += [(world, *row) for row in recorder.of_bends(frame)]
            colours += [(world, *row) for row in recorder.of(in_colour, frame, colour=True)]
            coloured += [(world, *row) for row in recorder.of_bends(frame)]
        for frame in _video(made, world) if videos_too else ():
            videos += [(world, *row, frame.index * PERIOD_NS / 1e9) for row in recorder.of(recognizer, frame)]
    kept = {"stills": stills, "colours": colours, "bends": bends, "coloured_bends": coloured, "videos": videos}
    return {name: np.array(rows, float) for name, rows in kept.items()}


def _video(made: World, seed: int) -> Iterator[SimulatedFrame]:
    """One object of a world that moves."""
    rng = np.random.default_rng([78, seed])
    size, least = SIZES[rng.choice(len(SIZES), p=SHARES)], float(np.exp(rng.uniform(np.log(0.06), np.log(0.3))))
    scene = SceneConfig(objects=(1, 1), size=(least, 1.5 * least))
    sensor = SensorConfig().scaled(float(rng.choice([0.0, 0.5, 1.0, 1.5])))
    motion = MotionConfig(speed=float(rng.uniform(0.02, 0.3)), turn=float(rng.uniform(0.1, 1.0)))
    frames = int(SECONDS * 1e9 / PERIOD_NS)
    camera = pinhole_camera(size, 60)
    yield from list(simulate_motion(made.targets[:1], camera, scene, motion, sensor, seed, frames))[::SPARSE]


def fitted(rows: Array, least: float | None = None) -> NDArray[np.float64]:
    """Weights of `Evidence.log_odds`, by the likelihood of stills. :param least: that evidence may have; None: any."""
    wrong, votes, contours = rows[:, 1] > 0, rows[:, 2], rows[:, 3]

    def loss(weights: Array) -> float:
        odds = turn_evidence.Evidence(votes, contours).log_odds(weights)
        return float(np.logaddexp(0, np.where(wrong, -odds, odds)).mean() + 1e-4 * weights @ weights)

    return np.asarray(minimize(loss, np.zeros(3), bounds=[(None, None), (least, None), (least, None)]).x)


def report(title: str, rows: Array, weights: Array) -> None:
    """How often the likelier turn is the right one, and whether its probability holds."""
    wrong, odds = rows[:, 1] > 0, turn_evidence.Evidence(rows[:, 2], rows[:, 3]).log_odds(weights)
    loss = np.logaddexp(0, np.where(wrong, -odds, odds)).mean()
    right, sure = (odds > 0) == wrong, 1 / (1 + np.exp(-np.abs(odds)))
    shares = f"right by votes {1 - wrong.mean():.3f}, now {right.mean():.3f}"
    print(f"{title}: {len(rows)} poses; {shares}; log-loss {loss:.3f}")
    for low, high in ((0.5, 0.7), (0.7, 0.9), (0.9, 0.98), (0.98, 1.0001)):
        here = (sure >= low) & (sure < high)
        if here.any():
            print(f"  told {sure[here].mean():.3f}: right {right[here].mean():.3f} of {here.sum()}")


def over_time(rows: Array, weights: Array, correlation: float, memory_s: float) -> tuple[float, float, float]:
    """Log-loss, share right and share right of those told above .9 of turns in videos, by all frames up to each."""
    odds = turn_evidence.Evidence(rows[:, 2], rows[:, 3]).log_odds(weights)
    for_truth = np.clip(np.where(rows[:, 1] > 0, odds, -odds), -3, 3)
    told = np.zeros(len(rows))
    for world in np.unique(rows[:, 0]):
        of = np.flatnonzero(rows[:, 0] == world)
        total = count = last_s = 0.0
        for n in of:
            left = np.exp(-(rows[n, 4] - last_s) / memory_s)
            total, count, last_s = total * left + for_truth[n], count * left + 1, rows[n, 4]
            told[n] = combined(total, count, correlation)
    sure = np.abs(told) > np.log(9)
    return float(np.logaddexp(0, -told).mean()), float((told > 0).mean()), float((told > 0)[sure].mean())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", type=int, default=120)
    parser.add_argument("--first", type=int, default=0, help="world that begins")
    parser.add_argument("--stills", action="store_true", help="no videos")
    parser.add_argument("--save", type=Path, help="keep what was recorded")
    parser.add_argument("--load", type=Path, nargs="+", help="fit what was kept")
    args = parser.parse_args()
    loaded = [dict(np.load(file)) for file in args.load or ()]
    kept = loaded or [record(args.first, args.worlds, videos_too=not args.stills)]
    if args.save:
        np.savez(args.save, **kept[0])
    shipped, labels = VerdictConfig(), VerdictConfig().turn_odds
    parts = {"coloured_bends": shipped.bend_odds_colour, "bends": labels}
    for name, odds in (parts | {"colours": shipped.turn_odds_colour, "stills": labels}).items():
        rows = np.concatenate([k[name] for k in kept])
        even, odd = rows[rows[:, 0] % 2 == 0], rows[rows[:, 0] % 2 == 1]
        weights = fitted(even)
        print(name, weights.round(2))
        report("fitted on", even, weights)
        report("held out", odd, weights)
        report("all, by the weights that are shipped", rows, np.array(odds))
    if not args.stills:
        report_videos(np.concatenate([k["videos"] for k in kept]), weights)


def report_videos(videos: Array, weights: Array) -> None:
    """What counts over time. :param weights: of labels."""
    for title, parity in (("fitted on", 0), ("held out", 1)):
        mine = videos[videos[:, 0] % 2 == parity]
        print(f"videos, {title}: {len(mine)} poses: log-loss, share right, share right of what is told above .9")
        for correlation, memory_s in ((1.0, 1e-6), *product(CORRELATIONS, MEMORIES_S)):
            figures = np.round(over_time(mine, weights, correlation, memory_s), 3)
            print(f"  correlation {correlation}, memory {memory_s} s:", figures)


if __name__ == "__main__":
    main()

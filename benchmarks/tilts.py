"""Which of two tilts a solid of one colour has: fits `expert.verdict.tilt_odds` and `tilt_odds_colour`.

    python benchmarks/tilts.py --worlds 40      # 5 minutes

Boxes and cylinders of random sizes, one or two a scene, alone or amid clutter, from labels and from colour images of
the same scenes. Of each told pose those tilted otherwise count of which just one of both is right. Fitted on
even-numbered worlds, told of odd ones; seeded.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

import numpy as np
from hidden_ends import frames
from random_solids import LABELS, World
from scipy.optimize import minimize
from tqdm import tqdm
from turns import COLOURED, report

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig, VerdictConfig
from artrec_ros.core.geometry.transforms import Array, Pose
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import other_turns
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.turn_evidence import Evidence, evidence
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.objects.solids import box_solid, cylinder_solid
from artrec_ros.simulation.simulator import SimulatedFrame

RIGHT_RAD, WRONG_RAD = 0.15, 0.25  # of the truth: corners are as far off as if turned by less, or by more
NEAR_SHARE = 0.1  # of the truth: place as a share of the range


class TiltRecorder:
    """What the recogniser finds to speak for other tilts."""

    def __init__(self) -> None:
        self._plain, self.rows = other_turns.tilted_rivals, list[tuple[Any, Poses, Poses, float, float]]()
        vars(other_turns)["tilted_rivals"] = self._rivals

    def _rivals(self, finder: Any, frame: Any, poses: Poses) -> Any:
        found = self._plain(finder, frame, poses)
        if len(found.of):
            speaks = evidence(finder, frame, poses[found.of], found.poses)
            for n, h in enumerate(found.of.tolist()):
                both = poses[h : h + 1], found.poses[n : n + 1]
                self.rows.append((finder.tilts, *both, float(speaks.votes[n]), float(speaks.contours[n])))
        return found

    def of(self, recognizer: Recognizer, image: np.ndarray, frame: SimulatedFrame) -> Iterator[tuple[float, ...]]:
        """Of each other tilt of which it is known which of both is right: whether that is this one, and evidence."""
        self.rows.clear()
        recognizer.recognize(image, frame.camera)
        truth = [Poses(T.rotation[None], T.position[None], np.zeros((1, 0))) for T in _places(frame)]
        for tilts, told, other, votes, contours in self.rows:
            near = [t for t in truth if np.linalg.norm(t.t - told.t) < NEAR_SHARE * np.linalg.norm(t.t)]
            if not near:
                continue
            right, wrong = (
                [bool(tilts.look_otherwise(one, near[0], rad)[0]) is is_wrong for one in (told, other)]
                for rad, is_wrong in ((RIGHT_RAD, False), (WRONG_RAD, True))
            )
            if right[0] != right[1] and wrong[0] != wrong[1] and right[0] == wrong[1]:
                yield float(right[1]), votes, contours


def _places(frame: SimulatedFrame) -> list[Pose]:
    return [one.T_camera_object for one in frame.scene.objects]


def solids(seed: int) -> World:
    """A box, or a cylinder, whose sides differ by up to three times."""
    rng = np.random.default_rng([82, seed])
    size = 0.04 * np.exp(rng.uniform(-0.55, 0.55, 3))
    if seed // 2 % 3:
        box = Box(Pose.identity(), size)
        markers, boxes = box_solid(box)
    else:
        markers, boxes = cylinder_solid(float(size[0] / 2), float(size[2]), Pose.identity())
    one = ObjectModel("solid", (Component("solid", markers, required=True, bodies=tuple(boxes)),))
    return World((Target("solid", one, LABELS[0]),), ())


def record(first: int, worlds: int) -> dict[str, Array]:
    """(n, 4) from labels and from colours: world, whether the other tilt is right, evidence of votes and contours."""
    recorder, kept = TiltRecorder(), {"labels": list[tuple[float, ...]](), "colours": list[tuple[float, ...]]()}
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        world = solids(number)
        plain, coloured = (
            Recognizer(list(world.targets), RecognizerConfig(), Segmenter(image)) for image in (ImageConfig(), COLOURED)
        )
        for frame in frames(world, number, hidden=0.0):
            kept["labels"] += [(number, *row) for row in recorder.of(plain, frame.labels, frame)]
            kept["colours"] += [(number, *row) for row in recorder.of(coloured, frame.colour, frame)]
    return {name: np.array(rows, float).reshape(-1, 4) for name, rows in kept.items()}


def fitted(rows: Array, begun: Array) -> Array:
    """Weights of least log-loss."""

    def loss(weights: Array) -> float:
        odds = Evidence(rows[:, 2], rows[:, 3]).log_odds(weights.tolist())
        return float(np.logaddexp(0, np.where(rows[:, 1] > 0, -odds, odds)).mean())

    return np.asarray(minimize(loss, begun).x)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", type=int, default=40)
    parser.add_argument("--first", type=int, default=0, help="world that begins")
    args = parser.parse_args()
    kept, config = record(args.first, args.worlds), VerdictConfig()
    for name, odds in (("labels", config.tilt_odds), ("colours", config.tilt_odds_colour)):
        even, odd = (kept[name][kept[name][:, 0] % 2 == parity] for parity in (0, 1))
        weights = fitted(even, np.array(odds))
        report(f"{name}, {np.round(weights, 2)}", odd, weights)
        report(f"{name}, as shipped {odds}", odd, np.array(odds))


if __name__ == "__main__":
    main()

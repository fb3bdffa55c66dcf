"""Fits the numbers of `core/base/config/covariance.py` to how fitted poses of random objects err.

    python benchmarks/covariance_fit.py --save found.npz [--first 0] [--worlds 320] [--scenes 2]    # half an hour
    python benchmarks/covariance_fit.py --load found.npz [more.npz ...]                            # at once

Worlds and scenes are those of `benchmarks/acceptance.py`: random objects, crowds, clutter, good and bad segmentation
(`benchmarks/random_solids.py`). Of each object found it is kept what each source of error makes of its covariance
(`core/pose/covariance.py`), and how far off it is. Objects off by more than 20 degrees or a tenth of their range are
mirrored turns or other objects' parts: they are counted apart.

The numbers make the errors in even-numbered worlds most likely under the normal distribution; tables are of
odd-numbered ones. What shifts all edges of an image (`shift_px`) no drawn one has: it is left out. Restarts begin a
few of the present deviations off: after a change of the method, save and fit twice.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from random_solids import random_frames, random_world
from scipy.optimize import minimize
from scipy.stats import chi2
from tqdm import tqdm

from artrec_ros.core.base.config import CovarianceConfig, ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.transforms import Array, Pose, rotvec_from_rotation
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import Detection
from artrec_ros.core.pose.covariance import deviations_without_image, pose_covariances, sources
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.restarts import scatter
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict import at_rest
from artrec_ros.simulation.simulator import SimulatedFrame

SHARES = ("spread_share", "seam_share", "stretch_share", "restart_share", "seam_gain")  # what is fitted
CHOICES = tuple((r, s) for r in (2, 3, 4) for s in (4, 8))  # compared: how far edges are looked for, stretches
MOST_RAD, MOST_SHARE = np.radians(20), 0.1  # what is farther off is something else
LIMITS = np.sqrt(chi2.ppf((0.5, 0.9), 1))


def choice(config: RecognizerConfig, reach_px: int, stretches: int) -> RecognizerConfig:
    return replace(config, covariance=replace(config.covariance, reach_px=reach_px, stretches=stretches))


class Recorder:
    """Stands in for `pose_covariances` and keeps what makes them up, by the place of the object."""

    def __init__(self) -> None:
        self.kept: dict[bytes, tuple[tuple[str, ...], Array, Array, float]] = {}
        at_rest.pose_covariances = self

    def __call__(
        self,
        model: SpatialModel,
        frame: ImageFrame,
        poses: Poses,
        use: np.ndarray,
        config: RecognizerConfig,
        *,
        facing: bool = False,
    ) -> Array:
        known = deviations_without_image(model, poses, config)
        tables = [self._parts(model, frame, poses, use, known, choice(config, *c)) for c in CHOICES]
        seams_px = model.seams_px(frame.field)[use.argmax(axis=1)]
        for h, t in enumerate(poses.t):
            parts = np.stack([table[h] for table in tables])
            self.kept[t.tobytes()] = model.model.joint_names, poses.q[h], parts, float(seams_px[h])
        return pose_covariances(model, frame, poses, use, config, facing=facing)

    @staticmethod
    def _parts(
        model: SpatialModel, frame: ImageFrame, poses: Poses, use: np.ndarray, known: Array, config: RecognizerConfig
    ) -> Array:
        """(H, 1 + sources, 6+J, 6+J) the known part, then of each source per unit of its share."""
        found = sources(model, frame, poses, use, known, config)
        again = scatter(model, frame, poses, use, found.covariance(config.covariance), known, config)
        return np.stack([found.known, found.spread, found.seam, found.stretch, again], axis=1)


@dataclass(frozen=True)
class Errors:
    """Of n objects and k joints; C `CHOICES`, S sources, what is known without an image before them.

    :param world, seam_px: (n,) seam_px: half the seam about their class. :param error: (n, 6) as of
        `Detection.pose_covariance`. :param parts: (n, C, S, 6, 6) what makes up the covariance.
    :param joint_world, joint_seam_px, joint_error: (k,). :param joint_parts: (k, C, S) of the squared deviation.
    :param off: (1,) how many more were off by far.
    """

    world: Array
    seam_px: Array
    range_m: Array
    error: Array
    parts: Array
    joint_world: Array
    joint_seam_px: Array
    joint_error: Array
    joint_parts: Array
    off: Array

    def of(self, world: np.ndarray, joint: np.ndarray) -> Errors:
        """Some of them. :param world, joint: (n,), (k,) bool."""
        rows = {
            name: value if name == "off" else value[joint if name.startswith("joint") else world]
            for name, value in vars(self).items()
        }
        return Errors(**rows)


def record(first: int, worlds: int, scenes: int) -> Errors:
    recorder, off = Recorder(), 0
    rows: list[tuple[float, float, float, Array, Array]] = []
    joints: list[tuple[float, float, float, Array]] = []
    for world in tqdm(range(first, first + worlds), disable=None):
        for detection, frame in found_in(world, scenes):
            assert detection.pose is not None
            names, q, parts, seam_px = recorder.kept[detection.pose.position.tobytes()]
            truth = nearest(detection, frame)
            error = None if truth is None else error_of(detection.pose, truth[0])
            if truth is None or error is None:
                off += 1
                continue
            range_m = float(np.linalg.norm(truth[0].position))
            rows.append((world, seam_px, range_m, error, parts[:, :, :6, :6].astype(np.float32)))
            told = [j for j, name in enumerate(names) if name in detection.joints]
            joints += [(world, seam_px, q[j] - truth[1][names[j]], parts[:, :, 6 + j, 6 + j]) for j in told]
    columns = [np.array(c, np.float64) for c in zip(*rows, strict=True)]
    of_joints = [np.array(c, np.float64) for c in zip(*joints, strict=True)]
    return Errors(*(*columns, *of_joints, np.array([off])))


def found_in(world: int, scenes: int) -> Iterator[tuple[Detection, SimulatedFrame]]:
    made = random_world(world)
    recognizer = Recognizer(list(made.targets), RecognizerConfig(), Segmenter(ImageConfig()))
    for frame in random_frames(made, world, scenes):
        for detection in recognizer.recognize(frame.labels, frame.camera).detections:
            if detection.pose_covariance is not None and detection.pose_from == "fit":
                yield detection, frame


def nearest(detection: Detection, frame: SimulatedFrame) -> tuple[Pose, dict[str, float]] | None:
    """The pose and the joints of the nearest object of that name."""
    here = [p for p in frame.scene.objects if p.target.name == detection.object]
    if not here:
        return None
    told = detection.pose
    assert told is not None
    off = [float(np.linalg.norm(p.T_camera_object.position - told.position)) for p in here]
    placed = here[int(np.argmin(off))]
    return placed.T_camera_object, placed.joints


def error_of(pose: Pose, truth: Pose) -> Array | None:
    """(6,) along the camera's axes and about them; None where it is something else that was found."""
    shift, turn = pose.position - truth.position, rotvec_from_rotation(pose.rotation @ truth.rotation.T)
    far = np.linalg.norm(shift) > MOST_SHARE * np.linalg.norm(truth.position) or np.linalg.norm(turn) > MOST_RAD
    return None if far else np.concatenate([shift, turn])


def counted(shares: Array, seam_px: Array) -> Array:
    """(n, S) how much of each part counts. :param seam_px: (n,)."""
    gain = 1 + shares[-1] * seam_px
    return np.column_stack([np.ones(len(gain)), gain[:, None] * shares[:-1] ** 2])


def covariances(shares: Array, errors: Errors, number: int) -> Array:
    """(n, 6, 6) under some shares. :param number: of `CHOICES`."""
    return np.einsum("ns,nsij->nij", counted(shares, errors.seam_px), errors.parts[:, number])


def squared(error: Array, C: Array) -> Array:
    return np.einsum("ni,ni->n", error, np.linalg.solve(C, error[..., None])[..., 0])


def misfit(shares: Array, errors: Errors, number: int) -> float:
    """Mean negative log-likelihood, but for a constant."""
    scale = np.array([1e3] * 3 + [1e2] * 3)  # millimetres and hundredths: numbers near one
    C, e = covariances(shares, errors, number) * np.outer(scale, scale), errors.error * scale
    return float(np.mean(np.linalg.slogdet(C)[1] + squared(e, C)) / 2)


def fitted(errors: Errors, number: int) -> Array:
    """(S,) the shares."""
    found = minimize(
        lambda x: misfit(np.exp(x), errors, number),
        np.log(np.full(len(SHARES), 0.3)),
        method="L-BFGS-B",
        bounds=[(-4, 2)] * len(SHARES),
    )
    return np.exp(found.x)


def report(title: str, shares: Array, errors: Errors, number: int) -> None:
    """Prints shares of truths within the 50 % and the 90 % regions."""
    C = covariances(shares, errors, number)
    part = {"pose": slice(0, 6), "position": slice(0, 3), "rotation": slice(3, 6)}
    print(f"{title}: {len(C)} poses, {int(errors.off[0])} in all off by more")
    within = {n: squared(errors.error[:, s], C[:, s, s])[:, None] for n, s in part.items()}
    inside = {n: d < chi2.ppf((0.5, 0.9), part[n].stop - part[n].start) for n, d in within.items()}
    parts = counted(shares, errors.joint_seam_px) * errors.joint_parts[:, number]
    deviation = np.sqrt(parts.sum(axis=1))
    inside["joints"] = np.abs(errors.joint_error / deviation)[:, None] < LIMITS
    seams = errors.seam_px > np.median(errors.seam_px)
    turn, range_m = np.sqrt(np.trace(C[:, 3:, 3:], axis1=1, axis2=2)), np.sqrt(np.trace(C[:, :3, :3], axis1=1, axis2=2))
    unsure = turn > np.median(turn)
    for name, rows in (("wider seams", seams), ("narrower", ~seams), ("less sure", unsure), ("surer", ~unsure)):
        inside[f"pose, {name}"] = inside["pose"][rows]
    for name, held in inside.items():
        half, most = held.mean(axis=0)
        print(f"  {name:20} within 50 %: {half:.3f}   within 90 %: {most:.3f}   of {len(held)}")
    share = np.median(range_m / errors.range_m)
    print(f"  median deviation {np.degrees(np.median(turn)):.2f} deg, {share:.2%} of the range")


def load(files: Sequence[Path]) -> Errors:
    found = [np.load(f) for f in files]
    joined = {name: np.concatenate([f[name] for f in found]) for name in Errors.__annotations__}
    return replace(Errors(**joined), off=np.array([sum(int(f["off"][0]) for f in found)]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0, help="number of the first world")
    parser.add_argument("--worlds", type=int, default=320)
    parser.add_argument("--scenes", type=int, default=2, help="of each world")
    parser.add_argument("--save", type=Path, metavar="FILE.npz")
    parser.add_argument("--load", type=Path, nargs="+", metavar="FILE.npz")
    args = parser.parse_args()
    errors = load(args.load) if args.load else record(args.first, args.worlds, args.scenes)
    if args.save:
        np.savez_compressed(args.save, **vars(errors))
    even, odd = (errors.of(errors.world % 2 == k, errors.joint_world % 2 == k) for k in (0, 1))
    now = CovarianceConfig()
    used = CHOICES.index((now.reach_px, now.stretches))
    for number, (reach_px, stretches) in enumerate(CHOICES):
        shares = fitted(even, number)
        print(f"reach {reach_px} px, {stretches} stretches: ", end="")
        print(", ".join(f"{n} {v:.3f}" for n, v in zip(SHARES, shares, strict=True)), end="; misfit fitted ")
        print(f"{misfit(shares, even, number):.3f}, held out {misfit(shares, odd, number):.3f}")
    present = np.array([getattr(now, name) for name in SHARES])
    for title, shares in (("as it is", present), ("fitted", fitted(even, used))):
        report(f"{title}, even-numbered worlds", shares, even, used)
        report(f"{title}, odd-numbered worlds", shares, odd, used)


if __name__ == "__main__":
    main()

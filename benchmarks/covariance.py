"""Whether poses are as sure as they say: of the truths, how many lie within 50 % and 90 % regions of the covariance.

    python benchmarks/covariance.py --frames 40 --save poses.npz     # renders, recognises, a second or so a frame
    python benchmarks/covariance.py --load poses.npz                 # prints the same again
    python benchmarks/covariance.py --image-plane                    # of poses by size

Scenes of the shipped spatial objects in two resolutions, with and without disturbances; seeded. Detections that are
off by more than 20 degrees or a tenth of the range are mirrored turns or other objects' parts: they are counted apart.
Of poses by size it is 45 degrees, which no tilt explains that is found, and 0.4 of the range.
"""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

import numpy as np
from scipy.stats import chi2
from tqdm import tqdm

from artrec_ros.core.geometry.transforms import Array, Pose
from artrec_ros.core.model.found import Detection
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.simulator import SimulatedFrame, pinhole_camera, simulate

CONFIG = Path(__file__).parents[1] / "config"
SETS = (  # parameter file, image size, disturbances, apparent size of the objects
    ("excavator", (320, 240), 1.0, (0.2, 0.6)),
    ("excavator", (640, 480), 0.0, (0.1, 0.5)),
    ("aibo", (320, 240), 1.0, (0.2, 0.6)),
    ("aibo", (640, 480), 0.5, (0.1, 0.5)),
)
MOST = {True: (np.radians(20), 0.1), False: (np.radians(45), 0.4)}  # of fits, and of poses by size
PARTS = {"pose": slice(0, 6), "position": slice(0, 3), "rotation": slice(3, 6)}


def run(
    name: str, size: tuple[int, int], noise: float, apparent: tuple[float, float], frames: int, seed: int, fits: bool
) -> Array:
    """(n, 43): range, error (6) and covariance (36) of each recognised object. :param fits: in space."""
    setup = load_parameters(CONFIG / f"{name}.yaml")
    setup = dataclasses.replace(setup, recognizer=dataclasses.replace(setup.recognizer, whole_object=fits))
    recognizer, camera = setup.build(), pinhole_camera(size, 60)
    scene, sensor = SceneConfig(objects=(1, 2), size=apparent), SensorConfig().scaled(noise)
    rows: list[Array] = []
    scenes = simulate(setup.targets, camera, scene, sensor, seed, frames)
    for frame in tqdm(scenes, total=frames, desc=f"{name} {size[0]}", disable=None):
        for detection in recognizer.recognize(frame.labels, camera).detections:
            truth = _nearest(detection, frame)
            if truth is not None:
                rows.append(_row(detection, truth))
    return np.array(rows).reshape(-1, 43)


def _nearest(detection: Detection, frame: SimulatedFrame) -> Pose | None:
    here = [p.T_camera_object for p in frame.scene.objects if p.target.name == detection.object]
    if not here or detection.pose is None:
        return None
    at = detection.pose.position
    return min(here, key=lambda T: float(np.linalg.norm(T.position - at)))


def _row(detection: Detection, truth: Pose) -> Array:
    assert detection.pose is not None and detection.pose_covariance is not None
    shift = detection.pose.position - truth.position
    turn = _rotation_vector(detection.pose.rotation @ truth.rotation.T)  # about the camera's axes
    return np.concatenate([[truth.position[2]], shift, turn, detection.pose_covariance.ravel()])


def _rotation_vector(R: Array) -> Array:
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    angle = np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))
    return axis * (1.0 if angle < 1e-6 else angle / np.sin(angle))


def report(name: str, rows: Array, fits: bool) -> None:
    """Prints the shares of truths within regions, each for itself and all together."""
    most_rad, most_share = MOST[fits]
    range_m, error, covariance = rows[:, 0], rows[:, 1:7], rows[:, 7:].reshape(-1, 6, 6)
    good = (np.linalg.norm(error[:, 3:], axis=1) < most_rad) & (
        np.linalg.norm(error[:, :3], axis=1) < most_share * range_m
    )
    print(f"{name}: {good.sum()} poses, {(~good).sum()} off by more")
    for part, index in PARTS.items():
        e, C = error[good][:, index], covariance[good][:, index, index]
        distance = np.sum(e * np.linalg.solve(C, e[..., None])[..., 0], axis=1)
        inside = [np.mean(distance < chi2.ppf(p, e.shape[1])) for p in (0.5, 0.9)]
        noise = [np.sqrt(p * (1 - p) / max(good.sum(), 1)) for p in (0.5, 0.9)]
        mean = distance.mean() / e.shape[1]
        print(
            f"  {part:8}  within 50 %: {inside[0]:.2f} ± {noise[0]:.2f}  within 90 %: {inside[1]:.2f} ± {noise[1]:.2f}"
            f"  mean squared error / expected: {mean:.2f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=40, help="of each of the four sets")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--image-plane", action="store_true", help="recognise in the image plane; with --load, too")
    parser.add_argument("--save", type=Path, metavar="FILE.npz")
    parser.add_argument("--load", type=Path, metavar="FILE.npz")
    args = parser.parse_args()
    fits = not args.image_plane
    if args.load:
        found = dict(np.load(args.load))
    else:
        found = {f"{s[0]} {s[1][0]}x{s[1][1]} noise {s[2]}": run(*s, args.frames, args.seed, fits) for s in SETS}
    if args.save:
        np.savez(args.save, **found)
    for name, rows in found.items():
        report(name, rows, fits)
    report("all", np.concatenate(list(found.values())), fits)


if __name__ == "__main__":
    main()

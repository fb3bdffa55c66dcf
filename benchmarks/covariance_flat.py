"""Fits `expert.covariance.flat_edge_px`, how well outlines tell sizes in the image plane, to poses by size.

    python benchmarks/covariance_flat.py [--objects 60] [--scenes 6]      # some minutes

Each object is one random flat marker (`benchmarks/random_solids.py`), 8 to 80 px across, tilted out of the image plane
by anything up to `expert.covariance.flat_tilt_deg`, before a wall, segmented exactly or badly. Fitted to even-numbered
objects by the normal likelihood of how far their poses are off; the table is of odd-numbered ones. Seeded.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from covariance_fit import squared
from random_solids import UP, random_outline
from scipy.stats import chi2
from tqdm import tqdm

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.transforms import Array, Pose, rotation_from_rotvec, rotvec_from_rotation
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import Detection
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.by_size import SizePlacer
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.simulation.config import SensorConfig
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import PlacedObject, Scene
from artrec_ros.simulation.simulator import pinhole_camera, render_frame
from artrec_ros.simulation.surfaces import Surface

CAMERA, FACING = pinhole_camera((320, 240), 60), np.diag([1.0, -1.0, -1.0])
LABEL, WALL, SIZES_PX = 3, 1, (8.0, 80.0)
EDGES_PX = (0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0)
MOST_RAD, MOST_SHARE = np.radians(45), 0.4  # what is farther off is something else, as in covariance.py


def flat_object(rng: np.random.Generator) -> Target:
    outline, radius = random_outline(rng.uniform(0.05, 0.1, 2), rng)
    tail, head = (np.array([x, 0.0]) for x in (outline[:, 0].min(), outline[:, 0].max()))
    marker = Marker("face", outline, tail, head, radius, Pose(UP, np.zeros(3)))
    return Target("flat", ObjectModel("flat", (Component("plate", (marker,), required=True),)), LABEL)


def scene(target: Target, config: RecognizerConfig, rng: np.random.Generator) -> Scene:
    """The object before a wall, anywhere in the image."""
    size_px = np.exp(rng.uniform(*np.log(SIZES_PX)))
    depth = CAMERA.focal_px * np.sqrt(target.model.required.markers[0].area) / size_px
    pixel = rng.uniform(0.2, 0.8, 2) * CAMERA.size
    position = depth * (np.linalg.inv(CAMERA.matrix) @ np.append(pixel, 1.0))
    cosine, way = rng.uniform(np.cos(np.radians(config.covariance.flat_tilt_deg)), 1), rng.uniform(-np.pi, np.pi)
    tilt = rotation_from_rotvec(np.arccos(cosine) * np.array([np.cos(way), np.sin(way), 0.0]))
    R = tilt @ FACING @ rotation_from_rotvec([0.0, 0.0, rng.uniform(-np.pi, np.pi)])
    corners = 3 * depth * np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], float)
    wall = Surface(corners, np.array([0.0, 0.0, -1.0]), WALL)
    return Scene((PlacedObject(target, Pose(R, position), {}),), (wall,), None)


def found(
    objects: int, scenes: int, config: RecognizerConfig
) -> Iterator[tuple[int, Target, Detection, Pose, ImageFrame]]:
    """Of each scene the object's number and the best detection, the true pose, the image."""
    for n in tqdm(range(objects), disable=None):
        rng = np.random.default_rng([21, n])
        target = flat_object(rng)
        recognizer = Recognizer([target], config, Segmenter(ImageConfig()))
        for _ in range(scenes):
            drawn, sensor = scene(target, config, rng), SensorConfig().scaled(float(rng.choice([0.0, 0.5, 1.0, 1.5])))
            frame = render_frame(0, Renderer(CAMERA), drawn, sensor, rng)
            image = ImageFrame(LabelField(frame.labels), CAMERA)
            for detection in recognizer.recognize(frame.labels, CAMERA).detections[:1]:
                yield n, target, detection, drawn.objects[0].T_camera_object, image


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--objects", type=int, default=60)
    parser.add_argument("--scenes", type=int, default=6, help="of each object")
    args = parser.parse_args()
    config = RecognizerConfig(whole_object=False)
    numbers: list[int] = []
    errors: list[Array] = []
    told: dict[float, list[Array]] = {edge: [] for edge in EDGES_PX}
    for n, target, detection, truth, image in found(args.objects, args.scenes, config):
        assert detection.pose is not None
        shift = detection.pose.position - truth.position
        turn = rotvec_from_rotation(detection.pose.rotation @ truth.rotation.T)
        if np.linalg.norm(turn) > MOST_RAD or np.linalg.norm(shift) > MOST_SHARE * truth.position[2]:
            continue
        numbers.append(n)
        errors.append(np.concatenate([shift, turn]))
        for edge, rows in told.items():
            c = replace(config, covariance=replace(config.covariance, flat_edge_px=edge))
            (placed,) = SizePlacer([target], c).placed([replace(detection, pose=None)], image)
            assert placed.pose_covariance is not None
            rows.append(placed.pose_covariance)
    even, error = np.array(numbers) % 2 == 0, np.array(errors)
    print(f"{len(error)} poses\nedge px   misfit fitted, held out   held out: within 50 %, 90 %; of place; of rotation")
    for edge, rows in told.items():
        C = np.array(rows)
        fits = [np.mean(_misfit(error[k], C[k])) for k in (even, ~even)]
        print(f"{edge:7.2f}   {fits[0]:13.3f}   {fits[1]:8.3f}", end="       ")
        for part in (slice(0, 6), slice(0, 3), slice(3, 6)):
            d = squared(error[~even][:, part], C[~even][:, part, part])
            print(" ".join(f"{np.mean(d < chi2.ppf(p, part.stop - part.start)):.2f}" for p in (0.5, 0.9)), end="  ")
        print()


def _misfit(error: Array, C: Array) -> Array:
    scale = np.array([1e2] * 3 + [1e1] * 3)  # numbers near one
    C, e = C * np.outer(scale, scale), error * scale
    return np.asarray((np.linalg.slogdet(C)[1] + squared(e, C)) / 2)


if __name__ == "__main__":
    main()

"""How large a marker must be in the image: recognition and errors over size, slant and blur. docs/printing.md has them.

    python benchmarks/marker_sizes.py                # some minutes on one core
    python benchmarks/marker_sizes.py --frames 200   # narrower intervals

Size is the root of a marker's area, face on: a square's side. Labels are those of `artrec simulate`: light, blur,
sensor noise, speckle, a colour segmenter; up to three things of the markers' colours that belong to nothing are in
view. Seeded.

Flat: the pair of squares of config/vss.yaml, found in the image plane, without calibration. In space: the toy
excavator of config/excavator.yaml, its base's side marker being measured; views from the side, turned at random.

Colours: how many pixels of printed colours get their own class, by the package's colour table, where the light is 0.4
to 1.2 times the usual, its colour varies (each channel by a log-normal factor) and the sensor has noise.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from artrec_ros.core.base.config import ClassConfig, ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Array, Pose, rotation_from_rotvec, wrap_angle
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import Detection
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.parameters.parameter_file import Setup, load_parameters
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import PlacedObject, Scene, sample_distractors, sample_scene
from artrec_ros.simulation.simulator import pinhole_camera, render_frame

CONFIG = Path(__file__).parents[1] / "config"
SIZES_PX = (6, 8, 10, 12, 16, 24, 40, 60)
SLANTS_DEG = (0, 15, 30, 45)
BLURS_PX = (0.0, 0.6, 1.2, 2.0)
USUAL_BLUR_PX = SensorConfig().blur_px
IMAGE, VIEW_DEG = (480, 360), 60.0
TEAM, ACCENT = 2, 3  # labels: blue, red
ACCENT_AT = (0.0372, -0.0372, 0.0)  # where the squares of config/constraints/vss.yaml touch
INKS = {  # r, g, b of a print in the usual light
    "red": (200, 30, 40), "orange": (240, 120, 30), "yellow": (235, 215, 40), "green": (40, 150, 60),
    "cyan": (40, 190, 200), "blue": (30, 70, 190), "violet": (120, 60, 160), "magenta": (200, 40, 140),
    "white": (225, 225, 225), "black": (30, 30, 30),
}  # fmt: skip
INK_SETS = (
    tuple(INKS),
    ("red", "yellow", "green", "blue", "white", "black"),
)
TINTS = (0.0, 0.1, 0.2)  # sigma of the logarithm of each channel's gain
INK_LIGHT, INK_NOISE, INK_PIXELS = (0.4, 1.2), 0.03, 20000
NEAR = 0.5  # of the marker's size: a detection so near to the truth is on it
NEAR_SHARE, NEAR_DEG = 0.1, 20.0  # in space: of the range; of the rotation


@dataclass(frozen=True)
class Row:
    """What was counted in some frames, of one object each.

    :param offsets: of those found: pixels (flat), shares of the range (space). :param turns_deg: errors of direction.
    """

    frames: int
    right: int
    false: int
    offsets: tuple[float, ...]
    turns_deg: tuple[float, ...]

    @property
    def line(self) -> str:
        found = len(self.offsets)
        errors = f"{np.median(self.offsets):9.4f} {np.median(self.turns_deg):6.2f}" if found else "        -      -"
        return f"{found / self.frames:5.2f} {self.right / self.frames:5.2f} {self.false / self.frames:5.2f} {errors}"


def flat_target(setup: Setup) -> Target:
    """The pair of squares as it lies on a flat roof: the shipped object has no places, a scene needs them."""
    target = setup.targets[0]
    places = {"team": Pose.identity(), "accent": Pose(np.eye(3), np.array(ACCENT_AT))}
    labels = {"team": None, "accent": ACCENT}
    components = []
    for c in target.model.components:
        markers = tuple(replace(m, T_component_marker=places[c.name]) for m in c.markers)
        components.append(replace(c, label=labels[c.name], markers=markers))
    return replace(target, label=TEAM, model=replace(target.model, components=tuple(components)))


def flat_scenes(
    target: Target, camera: Camera, size_px: float, slant_deg: float, rngs: list[np.random.Generator]
) -> Iterator[Scene]:
    """The pair near the image's centre, turned at random, tilted about a random axis of its plane."""
    side = area_root(target, "team")
    depth = camera.matrix[0, 0] * side / size_px
    for rng in rngs:
        facing = np.diag([1.0, -1.0, -1.0])  # the marker's z towards the camera
        axis = rng.uniform(0, 2 * np.pi)
        tilt = rotation_from_rotvec(np.radians(slant_deg) * np.array([np.cos(axis), np.sin(axis), 0.0]))
        R = tilt @ facing @ rotation_from_rotvec([0.0, 0.0, rng.uniform(-np.pi, np.pi)])
        at = depth * np.array([*rng.uniform(-0.15, 0.15, 2), 1.0])
        placed = PlacedObject(target, Pose(R, at), {})
        yield Scene((placed,), tuple(sample_distractors([target], [placed], camera, SceneConfig(), rng)), None)


def area_root(target: Target, component: str) -> float:
    """Metres: the root of the area of that component's first marker."""
    x, y = next(c for c in target.model.components if c.name == component).markers[0].outline.T
    return float(np.sqrt(abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2))


def flat_row(target: Target, size_px: float, slant_deg: float, blur_px: float, frames: int) -> Row:
    recognizer, camera = Recognizer([target], RecognizerConfig(), Segmenter(ImageConfig())), view()
    renderer, sensor = Renderer(camera), replace(SensorConfig(), blur_px=blur_px)
    rngs = generators(frames, size_px, slant_deg, blur_px)
    right, false = 0, 0
    offsets: list[float] = []
    turns: list[float] = []
    for scene, rng in zip(flat_scenes(target, camera, size_px, slant_deg, rngs), rngs, strict=True):
        labels = render_frame(0, renderer, scene, sensor, rng).labels
        true = centres(scene.objects[0], camera)
        on = recognizer.recognize(labels, None).detections
        best = min(on, key=lambda d: offset(d, true), default=None)
        hit = best is not None and offset(best, true) <= max(NEAR * size_px, 2.0)
        false += len(on) - hit
        if best is None or not hit:
            continue
        offsets.append(offset(best, true))
        found = {c.component: np.array([c.x, c.y]) for c in best.components}
        if "accent" in found and np.linalg.norm(found["accent"] - true["accent"]) <= max(NEAR * size_px, 2.0):
            right += 1
        if "accent" in found:
            turns.append(float(abs(np.degrees(wrap_angle(direction(found) - direction(true))))))
    return Row(frames, right, false, tuple(offsets), tuple(turns or [np.nan]))


def centres(placed: PlacedObject, camera: Camera) -> dict[str, Array]:
    """component -> (2,) pixels, the image of its marker's centre."""
    points = {}
    for component in placed.target.model.components:
        (marker,) = component.markers
        assert marker.T_component_marker is not None
        T = placed.T_camera_object @ marker.T_component_marker
        points[component.name] = project(camera, T.apply(np.append(marker.centroid, 0.0)[None]))[0]
    return points


def offset(detection: Detection, true: dict[str, Array]) -> float:
    return float(np.hypot(*(np.array([detection.image.x, detection.image.y]) - true["team"])))


def direction(points: dict[str, Array]) -> float:
    dx, dy = points["accent"] - points["team"]
    return float(np.arctan2(dy, dx))


def space_row(setup: Setup, size_px: float, blur_px: float, frames: int) -> Row:
    """One excavator a frame. Right: rotation and every joint told within `NEAR_DEG` besides."""
    recognizer, camera = setup.build(), view()
    (target,) = setup.targets
    renderer, sensor = Renderer(camera), replace(SensorConfig(), blur_px=blur_px)
    config = SceneConfig(facing=1.0)
    right, false = 0, 0
    offsets: list[float] = []
    turns: list[float] = []
    for rng in generators(frames, size_px, blur_px):
        scene = at_size(sample_scene([target], camera, config, rng), target, camera, size_px, rng)
        (placed,) = scene.objects
        found = recognizer.recognize(render_frame(0, renderer, scene, sensor, rng).labels, camera).detections
        here = [d for d in found if d.pose is not None and range_error(d.pose, placed) <= NEAR_SHARE]
        false += len(found) - min(len(here), 1)
        if not here:
            continue
        best = min(here, key=lambda d: float(range_error(d.pose, placed)) if d.pose else np.inf)
        assert best.pose is not None
        cosine = (np.trace(best.pose.rotation @ placed.T_camera_object.rotation.T) - 1) / 2
        turn = float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
        joints = [float(abs(np.degrees(wrap_angle(q - placed.joints[name])))) for name, q in best.joints.items()]
        right += max([turn, *joints]) <= NEAR_DEG
        offsets.append(range_error(best.pose, placed))
        turns.append(turn)
    return Row(frames, right, false, tuple(offsets), tuple(turns))


def at_size(scene: Scene, target: Target, camera: Camera, size_px: float, rng: np.random.Generator) -> Scene:
    """The scene's object moved to where its base's marker, face on, has that size, near the image's centre."""
    (placed,) = scene.objects
    depth = camera.matrix[0, 0] * area_root(target, target.model.required.name) / size_px
    position = depth * np.array([*rng.uniform(-0.05, 0.05, 2), 1.0])
    moved = replace(placed, T_camera_object=Pose(placed.T_camera_object.rotation, position))
    way, floor = position - placed.T_camera_object.position, scene.floor
    if floor is not None:
        floor = replace(floor, offset=floor.offset + float(floor.normal @ way))
    return Scene((moved,), tuple(sample_distractors([target], [moved], camera, SceneConfig(), rng)), floor)


def range_error(pose: Pose, placed: PlacedObject) -> float:
    there = placed.T_camera_object.position
    return float(np.linalg.norm(pose.position - there) / np.linalg.norm(there))


def view() -> Camera:
    return pinhole_camera(IMAGE, VIEW_DEG)


def generators(frames: int, *values: float) -> list[np.random.Generator]:
    seed = np.random.SeedSequence([round(10 * v) for v in values])
    return [np.random.default_rng(child) for child in seed.spawn(frames)]


def colour_rows(inks: tuple[str, ...], tint: float) -> Array:
    """(n, n + 1) shares: of pixels of each ink (rows), those that get no class (first column) or each ink's."""
    classes = {name: ClassConfig(label=i + 1, rgb=INKS[name]) for i, name in enumerate(inks)}
    segmenter, rng = Segmenter(ImageConfig(kind="colour", classes=classes)), np.random.default_rng(0)
    rows = []
    for name in inks:
        least, most = np.log(INK_LIGHT)
        gain = np.exp(rng.uniform(least, most, (INK_PIXELS, 1)) + rng.normal(0, tint, (INK_PIXELS, 3)))
        seen = np.array(INKS[name][::-1]) * gain + rng.normal(0, 255 * INK_NOISE, (INK_PIXELS, 3))
        labels = segmenter.labels(np.clip(np.rint(seen), 0, 255).astype(np.uint8)[None])
        rows.append(np.bincount(labels.ravel(), minlength=len(inks) + 1) / INK_PIXELS)
    return np.array(rows)


def print_colours() -> None:
    for inks in INK_SETS:
        for tint in TINTS:
            print(f"of {len(inks)} colours, tint {tint}: own class (none), and what takes more than 2 %")
            for i, row in enumerate(colour_rows(inks, tint)):
                others = {inks[k]: round(row[k + 1], 2) for k in np.argsort(-row[1:]) if k != i and row[k + 1] > 0.02}
                print(
                    f"  {inks[i]:8} {row[i + 1]:.2f} ({row[0]:.2f})  {', '.join(f'{n} {v}' for n, v in others.items())}"
                )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=40, help="of each row")
    parser.add_argument("--sizes", type=float, nargs="+", default=SIZES_PX, metavar="PX")
    parser.add_argument("--only", choices=("flat", "space", "colours"), help="one part only")
    args = parser.parse_args()
    if args.only in (None, "colours"):
        print_colours()
    head = "found right false    offset turn deg (medians)"
    if args.only in (None, "flat"):
        target = flat_target(load_parameters(CONFIG / "vss.yaml"))
        print(f"flat, offset in px\nsize slant blur  {head}")
        cases = [(s, USUAL_BLUR_PX) for s in SLANTS_DEG] + [(0, b) for b in BLURS_PX if b != USUAL_BLUR_PX]
        for slant, blur in cases:
            for size in args.sizes:
                row = flat_row(target, size, slant, blur, args.frames)
                print(f"{size:4g} {slant:5g} {blur:4g}  {row.line}", flush=True)
    if args.only in (None, "space"):
        setup = load_parameters(CONFIG / "excavator.yaml")
        print(f"in space, offset in shares of the range\nsize blur  {head}")
        for blur in (USUAL_BLUR_PX, BLURS_PX[-1]):
            for size in args.sizes:
                print(f"{size:4g} {blur:4g}  {space_row(setup, size, blur, args.frames).line}", flush=True)


if __name__ == "__main__":
    main()

"""Coloured markers beside AprilTag, ArUco and STag in the same scenes, over distance, slant, blur: found, errors, time.

    pip install pupil-apriltags stag-python
    python benchmarks/beside_tags.py                # some minutes on one core
    python benchmarks/beside_tags.py --frames 100   # narrower intervals

One flat marker of 64 cm2 on a white card, seen by a camera of 640x480 pixels with 60 degrees of view: a tag's black
square of 8 cm, or a one-coloured outline of the same area. Same places, same renderer, same light, lens and sensor
(`artrec simulate`'s); up to three things of the marker's own colour that belong to nothing are in view. Seeded.

AprilTag is 36h11 by pupil-apriltags, without decimation. ArUco is OpenCV's 4x4_50 with corners refined to a fraction of
a pixel. STag is its first marker of HD21, by stag-python, drawn here. Poses of both by IPPE. Ours is segmented from the
colour image and fitted in space.

Found: a pose within 10 % of the range, and of the right number. Turned: of those found, the rotation is off by more
than 20 degrees; of a small flat marker the mirrored turn looks alike. False: what else was found, a frame.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from artrec_ros.core.base.config import ClassConfig, ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.transforms import Array, Pose, rotation_from_rotvec
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.render import Renderer, Rendering
from artrec_ros.simulation.scene import PlacedObject, Scene, sample_distractors
from artrec_ros.simulation.sensor import colour_image, palette
from artrec_ros.simulation.simulator import pinhole_camera
from artrec_ros.simulation.surfaces import Surface

SIDE_M, CARD_M = 0.08, 0.13
DISTANCES_M = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0)
SLANTS_DEG = (20.0, 40.0, 60.0, 70.0)
BLURS_PX = (1.0, 2.0, 3.0)
USUAL = SensorConfig()
AT_M = 1.0  # slants and blurs
BLACK, GREEN, RED, WHITE = 0, 1, 3, 5  # of the simulator's palette
SQUARE = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
WALL_M = 9.0  # the wall behind everything
HOUSE = np.array([[-0.05, -0.035], [0.05, -0.035], [0.05, 0.01], [0.012, 0.045], [-0.05, 0.01]])
NUMBER = 7
STAG_HD, STAG_WORD, STAG_NUMBER = 21, 157678901735884, 0
STAG_CELLS, STAG_DISC, STAG_CODE = 200, 0.4, 0.35  # radii as shares of the side
STAG_PLACES = (  # of a quadrant's bits: radius in diameters of the code's circle, and angle
    (0.088363, 0.785398), (0.206936, 0.459276), (0.206936, 1.111521), (0.313672, 0.200580), (0.327493, 0.591688),
    (0.327493, 0.979109), (0.313672, 1.370217), (0.437422, 0.145725), (0.437227, 0.433363), (0.430628, 0.785398),
    (0.437227, 1.137433), (0.437422, 1.425071),
)  # fmt: skip
NEAR_SHARE, TURNED_DEG = 0.1, 20.0
CAMERA = pinhole_camera((640, 480), 60.0)


@dataclass(frozen=True)
class Seen:
    """A marker that was found. :param number: None: it bears none."""

    pose: Pose
    number: int | None = None


Detect = Callable[[NDArray[np.uint8]], list[Seen]]


@dataclass(frozen=True)
class Rival:
    """:param bitmap: the tag's cells, True black, its border included; None: the coloured outline."""

    name: str
    detect: Detect
    bitmap: NDArray[np.bool_] | None
    label: int
    number: int | None = NUMBER


@dataclass
class Tally:
    frames: int = 0
    false: int = 0
    offsets: list[float] = field(default_factory=list)
    turns: list[float] = field(default_factory=list)
    ms: list[float] = field(default_factory=list)

    @property
    def line(self) -> str:
        found = len(self.offsets)
        kept = [t for t in self.turns if t <= TURNED_DEG]
        errors = f"{100 * np.median(self.offsets):6.2f} {np.median(kept):6.2f}" if kept else "     –      –"
        turned = f"{1 - len(kept) / found:5.2f}" if found else "    –"
        return f"{found / self.frames:5.2f} {turned} {self.false / self.frames:5.2f} {errors} {np.median(self.ms):7.1f}"


def house() -> Array:
    """An outline that no turn brings back to itself, of the tag's area."""
    x, y = HOUSE.T
    area = abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2
    outline = HOUSE * (SIDE_M / np.sqrt(area))
    return outline - (outline.min(axis=0) + outline.max(axis=0)) / 2


def target() -> Target:
    marker = Marker("house", house(), np.array([-0.03, 0.0]), np.array([0.03, 0.0]), T_component_marker=Pose.identity())
    return Target("card", ObjectModel("card", (Component("plate", (marker,), required=True),)), RED)


def ours() -> Rival:
    rgb = tuple(int(v) for v in palette()[RED][::-1])
    image = ImageConfig(kind="colour", classes={"red": ClassConfig(label=RED, rgb=rgb)})
    recognizer = Recognizer([target()], RecognizerConfig(), Segmenter(image))

    def detect(picture: NDArray[np.uint8]) -> list[Seen]:
        return [Seen(d.pose) for d in recognizer.recognize(picture, CAMERA).detections if d.pose is not None]

    return Rival("artrec_ros", detect, None, RED)


def apriltag() -> Rival:
    import pupil_apriltags

    detector = pupil_apriltags.Detector(families="tag36h11", quad_decimate=1.0)
    K = CAMERA.matrix
    intrinsics = (K[0, 0], K[1, 1], K[0, 2] + 0.5, K[1, 2] + 0.5)  # it counts from a pixel's corner

    def detect(picture: NDArray[np.uint8]) -> list[Seen]:
        grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        found = detector.detect(grey, estimate_tag_pose=True, camera_params=intrinsics, tag_size=SIDE_M)
        return [Seen(Pose(to_marker(t.pose_R), t.pose_t[:, 0]), t.tag_id) for t in found]

    return Rival("AprilTag 36h11", detect, drawn(cv2.aruco.DICT_APRILTAG_36H11, 8), BLACK)


def aruco() -> Rival:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), parameters)

    def detect(picture: NDArray[np.uint8]) -> list[Seen]:
        quads, numbers, _ = detector.detectMarkers(picture)
        return placed_by_corners(quads, numbers)

    return Rival("ArUco 4x4_50", detect, drawn(cv2.aruco.DICT_4X4_50, 6), BLACK)


def stag() -> Rival:
    import stag as library

    def detect(picture: NDArray[np.uint8]) -> list[Seen]:
        quads, numbers, _ = library.detectMarkers(picture, STAG_HD)
        return placed_by_corners(quads, numbers)

    return Rival("STag HD21", detect, stag_marker(), BLACK, STAG_NUMBER)


def placed_by_corners(quads: Sequence[NDArray], numbers: NDArray | None) -> list[Seen]:
    """Corners (1, 4, 2) from the upper left one on, clockwise."""
    half, seen = SIDE_M / 2, []
    corners = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
    for quad, number in zip(quads, () if numbers is None else numbers.ravel(), strict=True):
        _, turn, place = cv2.solvePnP(corners, quad[0], CAMERA.matrix, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
        seen.append(Seen(Pose(rotation_from_rotvec(turn[:, 0]), place[:, 0]), int(number)))
    return seen


def stag_marker() -> NDArray[np.bool_]:
    """A black square with a white disc, in it 48 places for bits, here filled up to half way to their neighbours.

    Places, radii and code word are those of the format (Benligiray, Topal, Akinlar: STag, 2019).
    """
    radii, angles = np.array(STAG_PLACES).T
    turns = np.repeat(np.arange(4) * np.pi / 2, len(radii))
    radii, angles = STAG_CODE * 2 * np.tile(radii, 4), np.tile(angles, 4) + turns
    places = 0.5 + np.column_stack([np.cos(angles), -np.sin(angles)]) * radii[:, None]
    centres = (np.arange(STAG_CELLS) + 0.5) / STAG_CELLS
    points = np.stack(np.meshgrid(centres, centres), axis=-1)
    nearest = np.linalg.norm(points[:, :, None] - places, axis=-1).argmin(axis=-1)
    bits = np.array([STAG_WORD >> i & 1 for i in range(48)], bool)
    away = np.linalg.norm(points - 0.5, axis=-1)
    return (away > STAG_DISC) | ((away <= STAG_CODE) & bits[nearest])


def to_marker(R: Array) -> Array:
    """AprilTag's frame has y down and z into the tag; a marker's y is up, its z out of it. OpenCV draws tags on their
    heads."""
    return R @ np.diag([-1.0, 1.0, -1.0])


def drawn(dictionary: int, cells: int) -> NDArray[np.bool_]:
    """(cells, cells) of tag `NUMBER`, True black."""
    return cv2.aruco.generateImageMarker(cv2.aruco.getPredefinedDictionary(dictionary), NUMBER, cells) == 0


def places(distance_m: float, slant_deg: float, rngs: Sequence[np.random.Generator]) -> Iterator[Pose]:
    """Poses of the marker near the image's centre, turned at random, tilted about a random axis of its plane."""
    for rng in rngs:
        axis = rng.uniform(0, 2 * np.pi)
        tilt = rotation_from_rotvec(np.radians(slant_deg) * np.array([np.cos(axis), np.sin(axis), 0.0]))
        R = tilt @ np.diag([1.0, -1.0, -1.0]) @ rotation_from_rotvec([0.0, 0.0, rng.uniform(-np.pi, np.pi)])
        yield Pose(R, distance_m * np.array([*rng.uniform(-0.15, 0.15, 2), 1.0]))


def picture(
    rival: Rival, pose: Pose, renderer: Renderer, sensor: SensorConfig, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """What the camera gives of the card at that place."""
    placed = PlacedObject(target(), pose, {})
    things = sample_distractors([placed.target], [placed], CAMERA, SceneConfig(), rng)
    behind = [Surface(WALL_M * 2 * SQUARE + (0, 0, WALL_M), np.array([0.0, 0.0, -1.0]), GREEN)]
    behind += [replace(thing, label=rival.label) for thing in things]
    card = Surface(pose.apply(CARD_M / 2 * SQUARE), pose.rotation[:, 2], WHITE)
    rendering = renderer.render(Scene((placed,) if rival.bitmap is None else (), (card, *behind), None))
    if rival.bitmap is not None:
        rendering = with_tag(rendering, rival.bitmap, pose, renderer)
    return colour_image(rendering, sensor, rng)


def with_tag(rendering: Rendering, bitmap: NDArray[np.bool_], pose: Pose, renderer: Renderer) -> Rendering:
    """The tag's black cells on the card, each sample point by where its line of sight meets it."""
    card, ink = 0, len(rendering.surfaces)  # the card is the first that was drawn
    index = rendering.index.copy()
    rows, columns = np.nonzero(index == card)
    rays = np.column_stack([renderer._rays[rows, columns], np.ones(len(rows))])
    normal = pose.rotation[:, 2]
    on_card = rays * (normal @ pose.position / (rays @ normal))[:, None]
    xy = (on_card - pose.position) @ pose.rotation[:, :2]
    cell = np.floor((xy * (1, -1) / SIDE_M + 0.5) * len(bitmap)).astype(int)  # rows run down, the marker's y up
    inside = ((cell >= 0) & (cell < len(bitmap))).all(axis=1)
    black = np.zeros(len(cell), bool)
    black[inside] = bitmap[cell[inside, 1], cell[inside, 0]]
    index[rows[black], columns[black]] = ink
    surfaces = (*rendering.surfaces, replace(rendering.surfaces[card], label=BLACK))
    return replace(rendering, surfaces=surfaces, objects=(*rendering.objects, -1), index=index)


def row(rival: Rival, distance_m: float, slant_deg: float, blur_px: float, frames: int) -> Tally:
    """Frame i shows the same place to all rivals."""
    seeds = np.random.SeedSequence([round(100 * v) for v in (distance_m, slant_deg, blur_px)]).spawn(frames)
    rngs = [np.random.default_rng(seed) for seed in seeds]
    renderer, sensor, tally = Renderer(CAMERA), replace(USUAL, blur_px=blur_px), Tally()
    for pose, rng in zip(places(distance_m, slant_deg, rngs), rngs, strict=True):
        image = picture(rival, pose, renderer, sensor, rng)
        began = time.process_time()
        seen = rival.detect(image)
        tally.ms.append(1e3 * (time.process_time() - began))
        here = [s for s in seen if off(s.pose, pose) <= NEAR_SHARE and s.number in (None, rival.number)]
        tally.frames += 1
        tally.false += len(seen) - min(len(here), 1)
        if here:
            best = min(here, key=lambda s: off(s.pose, pose))
            tally.offsets.append(off(best.pose, pose))
            cosine = (np.trace(best.pose.rotation @ pose.rotation.T) - 1) / 2
            tally.turns.append(float(np.degrees(np.arccos(np.clip(cosine, -1, 1)))))
    return tally


def off(pose: Pose, true: Pose) -> float:
    return float(np.linalg.norm(pose.position - true.position) / np.linalg.norm(true.position))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=40, help="of each row")
    known = {"artrec_ros": ours, "AprilTag": apriltag, "ArUco": aruco, "STag": stag}
    parser.add_argument("--only", nargs="+", choices=list(known), default=list(known), help="these alone")
    parser.add_argument("--pictures", metavar="DIR", help="write a picture of each rival there, and no table")
    args = parser.parse_args()
    rivals = [known[name]() for name in args.only]
    if args.pictures:
        for rival in rivals:
            rng = np.random.default_rng(1)
            (pose,) = places(0.5, 30.0, [rng])
            image = picture(rival, pose, Renderer(CAMERA), USUAL, rng)
            cv2.imwrite(f"{args.pictures}/{rival.name.split()[0]}.png", image)
        return
    cases = [(z, 0.0, USUAL.blur_px) for z in DISTANCES_M] + [(AT_M, s, USUAL.blur_px) for s in SLANTS_DEG]
    cases += [(AT_M, 0.0, b) for b in BLURS_PX]
    print("medians: position in % of the range, rotation in degrees without what is turned, ms of CPU")
    print(f"{'':16} side px  m slant blur  found turned false  pos %    deg      ms")
    for distance, slant, blur in cases:
        side = CAMERA.focal_px * SIDE_M / distance
        for rival in rivals:
            tally = row(rival, distance, slant, blur, args.frames)
            print(f"{rival.name:16} {side:6.0f} {distance:4.1f} {slant:4.0f} {blur:4.1f}  {tally.line}", flush=True)


if __name__ == "__main__":
    main()

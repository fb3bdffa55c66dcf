"""Twelve robots seen from above, in colour: right, false, direction and time over size, blur and touching.

    python benchmarks/overhead.py                       # some minutes on one core; docs/overhead.md has the table
    python benchmarks/overhead.py --sizes 14 --blurs 0 --keep FOLDER     # one size; its pictures stay in FOLDER
    python benchmarks/overhead.py --write FOLDER        # only pictures and coco.json, as docs/overhead.md begins with

The robots are those of config/objects/mirosot.yaml: a square, half of it in the team's colour, two small triangles that
tell which one it is. Two teams of six; each occurs once. Size is the square's side in pixels, blur the lens' sigma.
Each size and blur is a room of its own: inks, floor, lamp, its tint and fall-off, noise and JPEG quality are drawn by
chance. In each, `artrec learn-colours` learns from three marked frames, and others are recognised. Right: the robot's
own team and name, a direction within 15 degrees, a place within a third of its side. Seeded.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import itertools
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from annotate_mirosot import OBJECT, TEAMS, axes
from coco import CocoWriter
from scipy.optimize import linear_sum_assignment
from tqdm import tqdm

from artrec_ros.core.geometry.transforms import Array, wrap_angle
from artrec_ros.core.model.found import Detection
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.tools.main import main as artrec

SIZES_PX, BLURS_PX = (8.0, 10.0, 14.0, 20.0), (0.0, 1.0, 2.0)
IMAGE, SIDE_M, FINE = (640, 480), 0.075, 4  # FINE: sample points along a pixel's side
MARKED = 3  # frames
NEAR, STRAIGHT = 1 / 3, np.radians(15)
TRIES = 2000
LEAST, WIDER = 0.4, 1.25  # recognizer.min_probability (its default), and limits of the scale
INKS = {  # r, g, b
    "yellow": (230, 210, 50), "blue": (40, 90, 200), "green": (40, 150, 60), "red": (200, 40, 45),
    "violet": (150, 70, 180),
}  # fmt: skip
FLOORS = ((120, 95, 70), (110, 110, 112), (35, 36, 38), (165, 150, 130), (60, 70, 80))  # wood, greys, black, sand
COLOURS = {"g": "green", "r": "red", "v": "violet"}
PARAMETERS = """\
/**:
  ros__parameters:
    objects: [yellow, blue]
    yellow: {object_file: robot.yaml, label: 1}
    blue: {object_file: robot.yaml, label: 2}
    image:
      kind: colour
      classes: [yellow, blue, green, red, violet]
      yellow: {label: 1}
      blue: {label: 2}
      green: {label: 3}
      red: {label: 4}
      violet: {label: 5}
"""


@dataclass(frozen=True)
class Robot:
    """:param x, y: the square's centre, pixels. :param deg: its direction in the image."""

    team: str
    pair: str
    x: float
    y: float
    deg: float

    def place(self, half_px: float) -> Array:
        """(2,) the centroid of the team's triangle. :param half_px: half of the square's diagonal."""
        angle = np.radians(self.deg)
        return np.array([self.x, self.y]) + half_px / 3 * np.array([np.cos(angle), np.sin(angle)])


@dataclass(frozen=True)
class Room:
    """What stays the same from frame to frame."""

    size_px: float
    blur_px: float
    inks: dict[str, Array]
    floor: Array
    light: Array  # (H, W, 3) gain
    noise: float  # of 255
    quality: int
    border: float  # the body's side over the square's

    @classmethod
    def random(cls, size_px: float, blur_px: float, rng: np.random.Generator) -> Room:
        width, height = IMAGE
        inks = {name: np.clip(np.array(rgb) + rng.normal(0, 8, 3), 5, 250) for name, rgb in INKS.items()}
        way = rng.uniform(0, 2 * np.pi)
        x, y = np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height))
        slope = 1 + rng.uniform(0, 0.25) * (np.cos(way) * x + np.sin(way) * y)
        corners = 1 - rng.uniform(0, 0.15) * (x**2 + y**2)
        lamp = rng.uniform(0.6, 1.05) * np.exp(rng.normal(0, 0.06, 3))
        floor = np.array(FLOORS[rng.integers(len(FLOORS))], float)
        light = (slope * corners)[..., None] * lamp
        grain, quality = rng.uniform(1.5, 4), int(rng.integers(80, 96))
        return cls(size_px, blur_px, inks, floor, light, grain, quality, rng.uniform(1.0, 1.15))

    @property
    def half_px(self) -> float:
        return self.size_px / np.sqrt(2)

    def picture(self, robots: Sequence[Robot], rng: np.random.Generator) -> Array:
        """(H, W, 3) BGR: light, lens, sensor and JPEG."""
        width, height = IMAGE
        fine = self._floor(rng)
        for robot in robots:
            self._draw(fine, robot)
        shown = cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA) * self.light * rng.uniform(0.95, 1.05)
        if self.blur_px:
            shown = cv2.GaussianBlur(shown, (0, 0), self.blur_px)
        noisy = np.clip(np.rint(shown + rng.normal(0, self.noise, shown.shape)), 0, 255).astype(np.uint8)
        packed = cv2.imencode(".jpg", noisy[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, self.quality])[1]
        return np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR))

    def _floor(self, rng: np.random.Generator) -> Array:
        """Its grain, and white lines on it."""
        width, height = IMAGE
        grain = cv2.resize(rng.normal(1, 0.05, (30, 12)).astype(np.float32), (width, height))
        coarse = np.clip(self.floor * grain[..., None], 0, 255).astype(np.uint8)
        fine = cv2.resize(coarse, (FINE * width, FINE * height), interpolation=cv2.INTER_LINEAR)
        for _ in range(3):
            tail, head = (rng.uniform(0, 1, (2, 2)) * IMAGE * FINE).astype(int).tolist()
            cv2.line(fine, tail, head, (215, 215, 215), int(FINE * self.size_px / 5))
        return fine

    def _draw(self, fine: Array, robot: Robot) -> None:
        angle = np.radians(robot.deg)
        ahead, left = np.array([np.cos(angle), np.sin(angle)]), np.array([np.sin(angle), -np.cos(angle)])
        centre = np.array([robot.x, robot.y])
        front, back = centre + self.half_px * ahead, centre - self.half_px * ahead
        port, starboard = centre + self.half_px * left, centre - self.half_px * left
        _fill(fine, centre + self.border * (np.array([front, port, back, starboard]) - centre), np.full(3, 25.0))
        colours = [self.inks[TEAMS[robot.team]], *(self.inks[COLOURS[c]] for c in robot.pair)]
        triangles = ((front, port, starboard), (centre, port, back), (centre, starboard, back))
        for triangle, colour in zip(triangles, colours, strict=True):
            _fill(fine, np.array(triangle), colour)

    def truth(self, robot: Robot) -> dict[str, object]:
        """As `annotate_mirosot.axes` reads it."""
        return {"x": robot.x, "y": robot.y, "deg": robot.deg, "half": self.half_px}


def _fill(fine: Array, corners_px: Array, colour: Array) -> None:
    """A pixel's centre has whole numbers; `fine` has FINE of them a pixel."""
    points = (corners_px + 0.5) * FINE - 0.5
    cv2.fillPoly(fine, [np.rint(points * 16).astype(np.int32)], tuple(map(float, colour)), cv2.LINE_AA, 4)


def robots_of(room: Room, touching: bool, rng: np.random.Generator) -> list[Robot]:
    """All twelve; touching ones stand side by side in groups of about four."""
    names = [(team, pair) for team in TEAMS for pair in map("".join, itertools.permutations(COLOURS, 2))]
    side, room_px = room.size_px * room.border, np.array(IMAGE) - 4 * room.size_px
    placed: list[Robot] = []
    rng.shuffle(names)
    for n, (team, pair) in enumerate(names):
        for _ in range(TRIES):
            deg, at = rng.uniform(-180, 180), 2 * room.size_px + rng.uniform(0, 1, 2) * room_px
            beside = touching and n % 4 > 0
            if beside:
                other = placed[rng.integers(n - n % 4, n)]
                way = np.radians(other.deg + 45 + 90 * rng.integers(4))
                across = np.array([-np.sin(way), np.cos(way)]) * rng.uniform(-0.4, 0.4) * side
                at = np.array([other.x, other.y]) + (side + 0.3) * np.array([np.cos(way), np.sin(way)]) + across
                deg = other.deg + 90 * rng.integers(4)
            new = Robot(team, pair, float(at[0]), float(at[1]), float(deg))
            if not any(_overlap(new, old, side, 0.0 if beside else 0.5 * side) for old in placed):
                placed.append(new)
                break
        else:
            raise RuntimeError(f"no room for {len(names)} robots of {room.size_px:g} px")
    return placed


def _overlap(a: Robot, b: Robot, side: float, gap: float) -> bool:
    boxes = [((r.x, r.y), (side + gap, side + gap), r.deg + 45) for r in (a, b)]
    return cv2.rotatedRectangleIntersection(*boxes)[0] != cv2.INTERSECT_NONE


def robot_file() -> str:
    """The shipped object with the sixth pair of colours."""
    return OBJECT.read_text(encoding="utf-8").replace("identities: ", "identities:\n  rv: {left: r, right: v}", 1)


def write_pictures(folder: Path, room: Room, rng: np.random.Generator, frames: int = MARKED) -> list[list[Robot]]:
    """pictures/ and coco.json, in which the first three are marked. Every other one has touching robots."""
    (folder / "pictures").mkdir(parents=True)
    model = load_object(OBJECT)
    half_m = float(np.abs(model.required.markers[0].outline).max())
    markers = [f"{c.name}/{m.name}" for c in model.components for m in c.markers]
    writer = CocoWriter("robots", list(TEAMS.values()), markers)
    scenes = [robots_of(room, n % 2 == 1, rng) for n in range(frames)]
    for n, robots in enumerate(scenes):
        name = f"{n:04d}.png"
        cv2.imwrite(str(folder / "pictures" / name), room.picture(robots, rng))
        if n < MARKED:
            image = writer.add_image(name, *IMAGE)
            for robot in robots:
                marked = axes(room.truth(robot), half_m)
                writer.add_object(image, TEAMS[robot.team], marked, {"identity": robot.pair})
    writer.write(folder / "coco.json")
    return scenes


def learn(folder: Path, room: Room, least: float, rng: np.random.Generator) -> None:
    """Writes object, parameters and marked pictures; learns the colours. :param least: recognizer.min_probability."""
    write_pictures(folder, room, rng)
    (folder / "robot.yaml").write_text(robot_file(), encoding="utf-8")
    scale = room.size_px / SIDE_M
    limits = f"min_scale: {scale / WIDER:.1f}, max_scale: {WIDER * scale:.1f}, min_probability: {least}"
    (folder / "robots.yaml").write_text(f"{PARAMETERS}    recognizer: {{{limits}}}\n", encoding="utf-8")
    files = {"--annotations": "coco.json", "--params-file": "robots.yaml", "--images": "pictures", "-o": "colours.yaml"}
    options = [text for option, name in files.items() for text in (option, str(folder / name))]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as told:
        if artrec(["learn-colours", *options]):
            raise RuntimeError(told.getvalue())


@dataclass
class Score:
    robots: int = 0
    right: int = 0
    found: int = 0
    wrong: int = 0
    unknown: int = 0
    false: int = 0
    errors: list[float] = field(default_factory=list)
    ms: list[float] = field(default_factory=list)

    def add(self, room: Room, robots: Sequence[Robot], detections: Sequence[Detection]) -> None:
        """Each detection belongs to one robot of its team at most."""
        cost = np.full((len(robots), len(detections)), np.inf)
        for i, robot in enumerate(robots):
            place = robot.place(room.half_px)
            for j, d in enumerate(detections):
                if d.object == TEAMS[robot.team]:
                    cost[i, j] = np.hypot(d.image.x - place[0], d.image.y - place[1])
        pairs = zip(*linear_sum_assignment(np.minimum(cost, 1e6)), strict=True)
        hits = [(robots[i], detections[j]) for i, j in pairs if cost[i, j] <= NEAR * room.size_px]
        self.robots, self.found = self.robots + len(robots), self.found + len(hits)
        self.false += len(detections) - len(hits)
        for robot, d in hits:
            name = d.identity.name if d.identity else None
            error = abs(wrap_angle(d.image.theta - np.radians(robot.deg)))
            self.errors.append(float(np.degrees(error)))
            self.unknown, self.wrong = self.unknown + (name is None), self.wrong + (name not in (None, robot.pair))
            self.right += name == robot.pair and error <= STRAIGHT

    @property
    def line(self) -> str:
        rates = f"{self.right / self.robots:.3f} | {self.found / self.robots:.3f} | {self.wrong} | {self.unknown}"
        middle = f"{np.median(self.errors):.1f}" if self.errors else "–"
        return f"{self.robots} | {rates} | {self.false} | {middle} | {np.median(self.ms):.0f}"


def measure(room: Room, folder: Path, frames: int, least: float, seed: Sequence[int]) -> Iterator[tuple[bool, Score]]:
    """Apart, then touching."""
    learn(folder, room, least, np.random.default_rng([*seed, 1]))
    recognizer = load_parameters(folder / "robots.yaml", folder / "colours.yaml").build(calibrated=False)
    for touching in (False, True):
        rng, score = np.random.default_rng([*seed, 2, touching]), Score()
        for n in range(frames):
            robots = robots_of(room, touching, rng)
            picture = room.picture(robots, rng)
            cv2.imwrite(str(folder / f"{'touching' if touching else 'apart'}_{n}.png"), picture)
            start = time.process_time()
            result = recognizer.recognize(picture)
            score.ms.append(1e3 * (time.process_time() - start))
            score.add(room, robots, result.detections)
        yield touching, score


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=float, nargs="+", default=SIZES_PX, metavar="PX")
    parser.add_argument("--blurs", type=float, nargs="+", default=BLURS_PX, metavar="PX")
    parser.add_argument("--frames", type=int, default=5, help="of twelve robots, apart and touching")
    parser.add_argument("--min-probability", type=float, default=LEAST, help="of the recogniser (%(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where pictures and files are to stay")
    parser.add_argument("--write", type=Path, metavar="FOLDER", help="write pictures and coco.json there, no more")
    args = parser.parse_args()
    cv2.setNumThreads(1)
    if args.write:
        rng = np.random.default_rng(args.seed)
        write_pictures(args.write, Room.random(args.sizes[0], args.blurs[0], rng), rng, MARKED + args.frames)
        return
    print("| side, px | blur, px | | robots | right | found | wrong name | no name | false | direction, deg | CPU ms |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    with contextlib.ExitStack() as stack:
        top = args.keep or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        rooms = list(itertools.product(args.sizes, args.blurs))
        for size, blur in tqdm(rooms, desc="rooms", disable=None):
            seed = (args.seed, round(10 * size), round(10 * blur))
            room = Room.random(size, blur, np.random.default_rng(seed))
            for touching, score in measure(room, top / f"{size:g}_{blur:g}", args.frames, args.min_probability, seed):
                how = "touching" if touching else "apart"
                print(f"| {size:g} | {blur:g} | {how} | {score.line} |", flush=True)


if __name__ == "__main__":
    main()

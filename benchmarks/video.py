"""What memory between frames and threads bring, on recorded sequences.

    python benchmarks/video.py SHARED_DATA [--frames 300] [--markdown FILE]

Each sequence is recognised in one process frame by frame, in their order: each frame alone with one thread, with memory
and one thread, and with memory and all threads; then, with memory, its frames shuffled, and every fourth and eighth
frame alone; and, alone and with memory, as a camera sees them that is turned a little otherwise in each. Prints
milliseconds of wall clock (mean, 99 %), the mean over that of cv2.aruco looking for tags in the pictures, the share of
the objects that single frames show which are found at the same place, and others, in each frame. The order of shuffled
frames and the turns are seeded; the machine is to be quiet.
"""

from __future__ import annotations

import argparse
import dataclasses
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from live_share import CONFIG, SCENES, Scene, read_frames
from tqdm import tqdm

from artrec_ros.core.memory.memory import Memory
from artrec_ros.core.model.found import Detection
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.parameters.parameter_file import Setup, load_parameters
from artrec_ros.io.sources.frames import Frame

SEED, STEP_NS = 17, 33_333_333
SHAKE_RAD = 0.01  # about each axis, standard deviation: from frame to frame some 8 pixels of 640, as in a walker's hand
ALONE = "each alone, one thread"
COLUMNS = "sequence", "frames", "as", "mean ms", "99 %", "times ArUco", "of single frames' objects", "others a frame"
HEADER = f"| {' | '.join(COLUMNS)} |\n{'| --- ' * len(COLUMNS)}|"


@dataclass(frozen=True)
class Run:
    """Milliseconds and objects of each frame, by the frame's number."""

    ms: list[float]
    found: dict[int, tuple[Detection, ...]]


def run(recognizer: Recognizer, frames: Sequence[tuple[int, Frame]], stamps_ns: Sequence[int]) -> Run:
    """:param frames: with their numbers, in the order in which they come."""
    memory: Memory | None = None
    ms, found = [], {}
    for (number, frame), stamp_ns in zip(frames, stamps_ns, strict=True):
        assert frame.image is not None
        begun = time.perf_counter()
        result, memory = recognizer.follow(frame.image, frame.camera, stamp_ns, memory)
        ms.append(1e3 * (time.perf_counter() - begun))
        found[number] = result.detections
    return Run(ms, found)


def shaken(frames: Sequence[Frame]) -> list[Frame]:
    """The same frames of a camera that is turned by a random angle in each; what comes into view is nothing."""
    rng, out = np.random.default_rng(SEED), []
    for frame in frames:
        assert frame.image is not None and frame.camera is not None
        R, K = cv2.Rodrigues(rng.normal(0, SHAKE_RAD, 3))[0], frame.camera.matrix
        how = cv2.INTER_NEAREST if frame.image.ndim == 2 else cv2.INTER_LINEAR  # between two classes there is none
        image = cv2.warpPerspective(frame.image, K @ R @ np.linalg.inv(K), frame.image.shape[1::-1], flags=how)
        out.append(dataclasses.replace(frame, image=image))
    return out


def agreement(found: Run, alone: Run) -> tuple[float, float]:
    """The share of single frames' objects that are found within half their size, and others in each frame."""
    both = mine = its = 0
    for number, detections in found.found.items():
        left = list(detections)
        mine, its = mine + len(left), its + len(alone.found[number])
        for d in alone.found[number]:
            near = [e for e in left if e.object == d.object and _off(d, e) < _size(d) / 2]
            if near:
                both += 1
                left.remove(min(near, key=lambda e: _off(d, e)))
    return both / max(its, 1), (mine - both) / max(len(found.found), 1)


def _off(a: Detection, b: Detection) -> float:
    return float(np.hypot(a.image.x - b.image.x, a.image.y - b.image.y))


def _size(d: Detection) -> float:
    """Of the component's outline, pixels."""
    return float(np.ptp(d.components[0].contour, axis=0).max()) if d.components else 0.0


def aruco_ms(frames: Sequence[Frame]) -> float:
    """Mean time that a detector of tags takes for the same pictures."""
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50))
    times = []
    for frame in frames:
        image = np.asarray(frame.image)
        begun = time.perf_counter()
        detector.detectMarkers(image)
        times.append(1e3 * (time.perf_counter() - begun))
    return float(np.mean(times))


def rows(scene: Scene, data: Path, most: int) -> list[str]:
    """The table's rows of a sequence."""
    setup, frames = load_parameters(CONFIG / f"{scene.parameters}.yaml"), read_frames(scene, data)[:most]
    numbered, stamps = list(enumerate(frames)), [f.stamp_ns for f in frames]
    shuffled = [numbered[n] for n in np.random.default_rng(SEED).permutation(len(frames))]
    every = {n: (numbered[::n], stamps[::n]) for n in (4, 8)}
    shaky = list(enumerate(shaken(frames)))
    ways: dict[str, Callable[[], Run]] = {
        ALONE: lambda: run(_build(setup, memory=False, threads=1), numbered, stamps),
        "memory, one thread": lambda: run(_build(setup, threads=1), numbered, stamps),
        "memory, all threads": lambda: run(_build(setup), numbered, stamps),
        "shuffled": lambda: run(_build(setup), shuffled, [k * STEP_NS for k in range(len(frames))]),
        **{f"every {n}th frame": lambda n=n: run(_build(setup), *every[n]) for n in every},  # type: ignore[misc]
        f"shaken, {ALONE}": lambda: run(_build(setup, memory=False, threads=1), shaky, stamps),
        "shaken, memory, one thread": lambda: run(_build(setup, threads=1), shaky, stamps),
    }
    rival, alone, out = aruco_ms(frames), None, []
    for way, start in tqdm(ways.items(), desc=scene.name, leave=False):
        result = start()
        alone = result if alone is None or way.endswith(ALONE) else alone
        same, others = agreement(result, alone)
        mean, most_ms = np.mean(result.ms), np.percentile(result.ms, 99)
        cells = scene.name, len(result.ms), way, f"{mean:.1f}", f"{most_ms:.1f}", f"{mean / rival:.1f}"
        out.append(f"| {' | '.join(map(str, (*cells, f'{same:.3f}', f'{others:.3f}')))} |")
    return out


def _build(setup: Setup, **options: object) -> Recognizer:
    config = dataclasses.replace(setup.recognizer, time_budget_ms=600000.0, **options)  # type: ignore[arg-type]
    return dataclasses.replace(setup, recognizer=config).build(calibrated=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, help="folder of the sequences")
    parser.add_argument("--frames", type=int, default=300, help="at most so many of each")
    parser.add_argument("--markdown", type=Path, help="write the table here, too")
    args = parser.parse_args()
    cv2.setNumThreads(1)
    table = [HEADER]
    for scene in SCENES[:4]:
        table += (found := rows(scene, args.data, args.frames))
        print("\n".join(found), flush=True)
    if args.markdown:
        args.markdown.write_text("\n".join(table) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

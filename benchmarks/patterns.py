"""Patterns of equal markers among clutter of their class: is the right one told, and nothing else?

    python benchmarks/patterns.py [--patterns 36] [--scenes 6] [--first 1000]

Each pattern (`benchmarks/random_patterns.py`) is a target of its own. A scene is right when one object is told, each of
its markers lies on one of the pattern's, and none of these is left over: within a third of a marker's size across the
view and 5 % along it. How the pattern is turned is asked as far as its markers tell. In a scene of none, nothing must
be told.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict

import numpy as np
from random_patterns import pattern_frames, random_pattern, same_places
from tqdm import tqdm

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.recognizer import Recognizer


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=1000, help="number of the first pattern")
    parser.add_argument("--patterns", type=int, default=36)
    parser.add_argument("--scenes", type=int, default=6, help="of each pattern")
    args = parser.parse_args()
    tally: dict[str, list[tuple[bool, bool, int, float]]] = defaultdict(list)
    for number in tqdm(range(args.first, args.first + args.patterns), desc="patterns", disable=None):
        pattern = random_pattern(number)
        recognizer = Recognizer([pattern.target], RecognizerConfig(), Segmenter(ImageConfig()))
        for frame in pattern_frames(pattern, number, args.scenes):
            start = time.process_time()
            poses = [d.pose for d in recognizer.recognize(frame.labels, frame.camera).detections if d.pose]
            cpu_ms = 1e3 * (time.process_time() - start)
            there = [t.placed.T_camera_object for t in frame.truths]
            hits = sum(same_places(pattern.target.model, p, t) for t in there for p in poses)
            found = hits > 0 or not there
            row = (found and len(poses) == len(there), found, len(poses) - min(hits, 1), cpu_ms)
            for key in ("all", pattern.kind, pattern.shape):
                tally[key].append(row)
    print("patterns   scenes  right  found  false a scene  CPU ms")
    for key, rows in tally.items():
        right, found, false, ms = np.array(rows, float).T
        rates = f"{right.mean():.3f}  {found.mean():.3f}  {false.mean():13.3f}"
        print(f"{key:10} {len(rows):6d}  {rates}  {np.median(ms):6.1f}")


if __name__ == "__main__":
    main()

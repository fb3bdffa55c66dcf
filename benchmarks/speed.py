"""Time a frame takes, by image size and number of objects, beside other methods on the same image in the same run.

    python benchmarks/speed.py [--markdown FILE] [--no-space] [--sizes 640x480] [--counts 2]

Scenes are simulated quadrupeds of config/aibo.yaml, soccer robots of config/vss.yaml seen from above, and label noise
at every pixel; all seeded, all run warm.
`plane` has no calibration and groups in the image plane; `space` has, and fits whole objects. With one thread the
clock counts CPU time, with two wall-clock time, which other work on the machine disturbs.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from pathlib import Path

import numpy as np
from shipped import CONFIG
from speed_runs import Bench, Times, noise, overhead_scenes, scenes
from speed_table import Row, to_markdown, to_text

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.io.parameters.parameter_file import Setup, load_parameters

SIZES = ("208x160", "640x480", "1280x720")
COUNTS = (1, 2, 4, 8)
SEED = 7
NOISE_BUDGET_MS = 100.0


def run_row(kind: str, bench: Bench, size: tuple[int, int], objects: int, space: bool) -> Row:
    tags, found = bench.aruco(np.random.default_rng(SEED))
    return Row(
        kind,
        size,
        objects,
        floor=bench.floor(),
        plane=bench.plane(),
        plane_two_threads=bench.plane(threads=2),
        paper=bench.plane(profile="paper"),
        hough=bench.hough(),
        aruco=tags,
        tags_found=found,
        space=bench.space() if space else None,
        space_two_threads=bench.space(threads=2) if space else None,
    )


def run_noise(setup: Setup, size: tuple[int, int]) -> tuple[Times, Times, Times]:
    """(floor, plane, plane with a small budget)."""
    bench = Bench([noise(size, SEED)], setup)
    return bench.floor(), bench.plane(), bench.plane(time_budget_ms=NOISE_BUDGET_MS)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--markdown", type=Path, help="write the tables to this file as well")
    parser.add_argument("--no-space", action="store_true", help="leave out fits of whole objects")
    parser.add_argument("--sizes", nargs="+", default=SIZES, metavar="WxH")
    parser.add_argument("--counts", nargs="+", type=int, default=COUNTS, metavar="N")
    args = parser.parse_args()
    legged = load_parameters(CONFIG / "aibo.yaml")
    overhead = dataclasses.replace(load_parameters(CONFIG / "vss.yaml"), image=ImageConfig())  # of label images
    rows, noises = [], {}
    sizes = [(int(width), int(height)) for width, height in (text.split("x") for text in args.sizes)]
    for kind, setup, make in (("legged", legged, scenes), ("overhead", overhead, overhead_scenes)):
        for size in sizes:
            for count in args.counts:
                bench = Bench(list(make(setup, size, count, SEED)), setup)
                rows.append(run_row(kind, bench, size, count, kind == "legged" and not args.no_space))
                print(f"{kind}, {size[0]}x{size[1]}, {count} objects: done", file=sys.stderr)
    for size in sizes:
        noises[size] = run_noise(legged, size)
    print(to_text(rows, noises, NOISE_BUDGET_MS))
    if args.markdown:
        args.markdown.write_text(to_markdown(rows, noises, NOISE_BUDGET_MS), encoding="utf-8")


if __name__ == "__main__":
    main()

"""Rows of numbers that a benchmark works out of made-up worlds, and keeps: working them out takes long."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from artrec_ros.core.geometry.transforms import Array


def rows_of(
    description: str | None,
    columns: Sequence[str],
    watch: Callable[[int, int, int], Array],
    worlds: int,
    scenes: int,
) -> dict[str, Array]:
    """What the command line asks for, by column: (n,) each.

    :param watch: makes rows (n, columns) of worlds: the number of the first, how many, and scenes of each.
    :param worlds, scenes: by default.
    """
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--save", type=Path)
    parser.add_argument("--load", type=Path, nargs="+")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--worlds", type=int, default=worlds)
    parser.add_argument("--scenes", type=int, default=scenes)
    args = parser.parse_args()
    if args.load:
        values = np.concatenate([np.load(path)["rows"] for path in args.load])
    else:
        values = watch(args.first, args.worlds, args.scenes)
    if args.save:
        np.savez_compressed(args.save, rows=values)
    return dict(zip(columns, values.T, strict=True))

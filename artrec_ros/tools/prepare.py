"""`artrec prepare`: compiles ahead, so that the first start does not."""

from __future__ import annotations

import argparse
import time
from typing import Any

from ..core.base import kernel_cache
from ..core.base.errors import ArtrecError
from ..core.warm_up import get_ready, parts_needed
from ..core.warm_up_pieces import PLANE, SPACE
from ..io.parameters.parameter_file import load_parameters
from .getting_ready import progress
from .options.paths import path


def add_parser(subparsers: Any) -> None:
    p = subparsers.add_parser(
        "prepare",
        help="compile ahead what recognition needs",
        description="Compiles what recognition needs, unless that was done: with a container's image, or on a robot "
        "before it counts. The result holds for this version, Python and kind of CPU; NUMBA_CACHE_DIR names a folder "
        "for it, else it lies beside the package or, where that cannot be written, under ~/.cache.",
    )
    p.add_argument(
        "--params-file", type=path, action="append", default=[],
        help="only what this file's objects need in images of a calibrated camera (default: everything)",
    )  # fmt: skip
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Compile, and say how long it took and where the results lie.

    :raises ArtrecError: they cannot be kept.
    """
    parts: tuple[str, ...] = (SPACE, PLANE)
    if args.params_file:
        setup = load_parameters(*args.params_file)
        parts = parts_needed(setup.targets, setup.recognizer, calibrated=True)
    there, began = all(map(kernel_cache.is_noted, parts)), time.monotonic()
    if not there and kernel_cache.writable() is None:
        raise ArtrecError(kernel_cache.problem())
    with progress() as told:
        get_ready(parts, told)
    folders = [folder for folder in kernel_cache.folders() if all((folder / f"{p}.ready").exists() for p in parts)]
    if not folders:
        raise ArtrecError(kernel_cache.problem() or "internal error: the results are not where they should be")
    took = "was done before; it lies" if there else f"compiled in {time.monotonic() - began:.0f} s, kept"
    print(f"ready: {took} in {folders[0]}")
    return 0

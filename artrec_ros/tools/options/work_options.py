"""Options of commands that work through sources: which images are read, and who does the work."""

from __future__ import annotations

import argparse
import dataclasses
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ...core.warm_up import is_kept
from ...io.bags.reader import STORAGES
from ...io.base.bars import say
from ...io.images.cameras import load_camera
from ...io.parameters.parameter_file import Setup
from ...io.sources.bag_source import BagSource
from ...io.sources.opening import SourceOptions, Sources
from ..replaying.engines import Engine, InlineEngine
from ..replaying.processes import ProcessEngine
from ..replaying.work import Order
from .paths import path

_MOST_SECONDS, _RATES_HZ = 1e9, (1e-3, 1e6)  # what stamps in nanoseconds can hold
_MOST_PER_CORE = 16  # workers


def add_sources(p: argparse.ArgumentParser) -> None:
    """What is worked through."""
    p.add_argument(
        "sources", metavar="SOURCE", nargs="+", type=path, help="bag (rosbag2, ROS 1), folder of images or video"
    )


def add_source_options(p: argparse.ArgumentParser) -> None:
    """Which images of a source are read, and how."""
    p.add_argument("--topic", help="image topic (else the only one, or the only one that fits image.kind)")
    p.add_argument("--camera-info-topic", help="calibration topic (else camera_info beside the image topic)")
    p.add_argument("--camera-info", type=path, metavar="FILE", help="calibration file, instead of a topic")
    p.add_argument("--start-offset", type=seconds, default=0.0, metavar="S", help="skip S seconds of each source")
    p.add_argument("--playback-duration", type=seconds, metavar="S", help="read S seconds of each source")
    p.add_argument("-s", "--storage", choices=sorted(STORAGES), help="read only bag files of this kind")
    p.add_argument(
        "--rate",
        type=rate,
        default=30.0,
        metavar="HZ",
        help="rate of folders, and videos that tell none (default: 30)",
    )


def add_worker_options(p: argparse.ArgumentParser) -> None:
    group = p.add_mutually_exclusive_group()
    group.add_argument(
        "-j", "--jobs", type=jobs, default=1, metavar="N|all",
        help="worker processes; all: one for each core (default: 1: frames are timed undisturbed)",
    )  # fmt: skip
    group.add_argument(
        "--scheduler", metavar="ADDRESS",
        help="work on the cluster of this Dask scheduler; all paths must be the same there",
    )  # fmt: skip


def engine_of(args: argparse.Namespace) -> Engine:
    """Where the options say that work is done. Ask once code is ready: where it cannot be kept, workers would be at
    the compiler for longer than at most work, and without a word."""
    if args.scheduler:
        from ..replaying.cluster import ClusterEngine

        return ClusterEngine(args.scheduler)
    if args.jobs > 1 and not is_kept():
        say(f"warning: no {args.jobs} workers: each would compile anew what cannot be kept; this process works alone")
        return InlineEngine()
    return InlineEngine() if args.jobs == 1 else ProcessEngine(args.jobs)


def source_options(args: argparse.Namespace, setup: Setup) -> SourceOptions:
    return SourceOptions(
        topic=args.topic,
        image_kind=setup.image.kind,
        camera_info_topic=args.camera_info_topic,
        camera=load_camera(args.camera_info, rectified=setup.image.rectified) if args.camera_info else None,
        rectified=setup.image.rectified,
        start_offset_s=args.start_offset,
        playback_duration_s=args.playback_duration,
        storage=args.storage,
        rate_hz=args.rate,
    )


def order_of(setup: Setup, paths: Sequence[Path], sources: Sources, options: SourceOptions) -> Order:
    """For the workers: absolute paths, chosen topics."""
    chosen = [
        dataclasses.replace(options, topic=part.topic) if isinstance(part, BagSource) else options
        for part in sources.parts
    ]
    calibrated = any(part.calibrated for part in sources.parts)
    return Order(setup, tuple(path.absolute() for path in paths), tuple(chosen), calibrated)


def number(text: str, accept: Callable[[float], bool], what: str) -> float:
    """An option's finite number. :param what: it would be, for the message.

    :raises ArgumentTypeError: it is none, or not one to accept.
    """
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not (np.isfinite(value) and accept(value)):
        raise argparse.ArgumentTypeError(f"'{text}' is no {what}")
    return value


def seconds(text: str) -> float:
    return number(text, lambda v: 0 <= v <= _MOST_SECONDS, "number of seconds")


def rate(text: str) -> float:
    return number(text, lambda v: _RATES_HZ[0] <= v <= _RATES_HZ[1], "rate in Hz")


def jobs(text: str) -> int:
    """Worker processes; `all`: one for each core. :raises ArgumentTypeError: what it is, and would be."""
    cores = (len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()) or 1
    if text == "all":
        return cores
    found = int(number(text, lambda v: v >= 1 and v == int(v), "number of workers; 'all' is a word for it"))
    if found > _MOST_PER_CORE * cores:
        raise argparse.ArgumentTypeError(
            f"'{text}': more than {_MOST_PER_CORE * cores} workers would only wait for each other on {cores} cores; "
            "'all' takes one for each"
        )
    return found

"""`artrec replay`: runs the recogniser over bags and folders of images; needs no ROS graph."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..core.base.errors import SourceError
from ..core.tracking.tracker import Tracker
from ..core.ways import SPACE, remembers, way_of
from ..io.bags.reader import STORAGES
from ..io.base.bars import bar, say
from ..io.parameters.parameter_file import Setup, load_parameters
from ..io.parameters.unread import unread
from ..io.sources.frames import once
from ..io.sources.opening import SourceOptions, Sources, open_sources
from .getting_ready import get_setup_ready
from .inspecting.oddities import oddities
from .interrupting import interruptible
from .main import INTERRUPTED
from .options.outputs import OF_RECORDING, check_not_read, check_output
from .options.paths import path
from .options.work_options import (
    add_source_options,
    add_sources,
    add_worker_options,
    engine_of,
    number,
    order_of,
    source_options,
)
from .replaying.folder import ReplayFolder, counted, places
from .replaying.joining import Join
from .replaying.pictures import PictureOptions, Pictures
from .replaying.plan import plan_of
from .replaying.rerun_file import RerunFile
from .replaying.running import Running
from .replaying.summary import Summary
from .replaying.work import Order

_EPILOG = """\
In folders of images the stamp is the frame's number over --rate, unless every name is a number of 16 digits or more:
that is its stamp in nanoseconds.

The same command again goes on with a replay that was interrupted, and leaves a finished one as it is. However many
workers there are, results are the same but for their timing; with --no-timing they are the same to the byte. (Frames
that recognizer.time_budget_ms cuts short depend on the machine; the summary counts them.)
"""


def add_parser(subparsers: Any) -> None:
    p = subparsers.add_parser(
        "replay", help="recognise objects in bags, folders of images or videos", description=__doc__, epilog=_EPILOG
    )
    add_sources(p)
    p.add_argument(
        "--params-file", required=True, type=path, action="append",
        help="the node's ROS parameter file; may be given again: later ones go before",
    )  # fmt: skip
    p.add_argument("-o", "--output", required=True, type=path, metavar="DIR", help="where the results go")
    p.add_argument("--overwrite", action="store_true", help="replace results that are in DIR already")
    add_source_options(p)
    add_worker_options(p)
    p.add_argument("--images", type=_image_count, metavar="all|none|N", help="overlay pictures (default: all)")
    p.add_argument("--labels", action="store_true", help="show each overlay beside the class image recognised from")
    p.add_argument("--no-video", action="store_true", help="write no video.mp4")
    p.add_argument(
        "--output-bag", nargs="?", const="mcap", choices=sorted(STORAGES), metavar="STORAGE",
        help="write DIR/bag_0, bag_1, ..., one for each source: its images and the node's topics (mcap)",
    )  # fmt: skip
    p.add_argument(
        "--rerun", type=_recording_path, metavar="FILE.rrd",
        help="write a recording for the Rerun viewer: images, classes, poses, joints, what was turned down (rerun-sdk)",
    )  # fmt: skip
    p.add_argument("--no-timing", action="store_true", help="leave timing_ms empty")
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Exit code 0: done; 1: no frame could be used; 130: interrupted."""
    inputs = [*args.sources, *args.params_file, *filter(None, [args.camera_info])]
    for place in places(args.output):
        check_not_read(place, inputs)
    setup = load_parameters(*args.params_file)
    options = source_options(args, setup)
    pictures = PictureOptions(args.images, not args.no_video, args.output_bag)
    recording = args.rerun and RerunFile(args.rerun, setup.image, setup.targets, len(args.sources))
    if args.rerun:
        check_output(args.rerun, inputs, OF_RECORDING)
    tell = once(say)
    with open_sources(args.sources, options, tell, keep_going=True) as sources:
        calibrated = sources.calibrated
        for line in unread(setup, calibrated):
            say(line)
        for line in (line for t in setup.targets for line in oddities(t)):
            say(f"warning: {line}")
        for line in setup.lacks(sources.starts_calibrated()):
            say(f"warning: {line}")
        in_space = [t for t in setup.targets if way_of(t, setup.recognizer, calibrated=True) == SPACE]
        if True not in calibrated and not all(t.model.is_flat for t in in_space):  # flat ones are found without
            say(
                "warning: images have no calibration that is theirs, so no poses in space; --camera-info FILE gives "
                "one, be it a guess"
            )
        plan = plan_of(setup, args.sources, _plan_options(args, options))
        with ReplayFolder(args.output, plan, setup.to_yaml(), args.overwrite) as folder:
            if folder.lost:
                say(folder.lost)
            if folder.finished:
                return _tell(folder.summary(), args.output, "done before; --overwrite does it again; results are")
            order = order_of(setup, args.sources, sources, options)
            order = dataclasses.replace(order, with_classes=args.labels)
            get_setup_ready(setup, calibrated)
            summary = _replay(args, order, sources, folder, pictures, recording, tell)
    if 0 < summary.frames == summary.frames_without_objects:
        why = f"artrec inspect {args.params_file[0]} {args.sources[0]}"
        say(f"nothing was found: 'rejected' in {args.output / 'detections.jsonl'} may tell why, or {why}")
    done = "interrupted; the same command goes on; what was done so far is" if summary.interrupted else "results"
    return _tell(summary, args.output, done)


def _plan_options(args: argparse.Namespace, options: SourceOptions) -> dict[str, Any]:
    """What results depend on besides sources and parameters."""
    given = {f.name: getattr(options, f.name) for f in dataclasses.fields(options)}
    if (camera := options.camera) is not None:
        K, bent = camera.matrix.ravel().tolist(), camera.distortion.tolist()
        given["camera"] = {"frame_id": camera.frame_id, "size": list(camera.size), "K": K, "D": bent}
    outputs = {"images": args.images, "video": not args.no_video, "output_bag": args.output_bag, "labels": args.labels}
    outputs["rerun"] = args.rerun and str(args.rerun.resolve())
    return {**given, **outputs, "timing": not args.no_timing}


def _replay(
    args: argparse.Namespace,
    order: Order,
    sources: Sources,
    folder: ReplayFolder,
    options: PictureOptions,
    recording: RerunFile | None,
    tell: Callable[[str], None],
) -> Summary:
    summaries = [Summary() for _ in range(1 + len(sources.parts))]
    named = list(zip(map(str, args.sources), sources.parts, strict=True))
    targets = order.setup.targets
    try:
        with (
            engine_of(args) as engine,
            Pictures(folder.path, options, sources.parts, targets, folder.check, recording) as pictures,
            bar(total=sources.count, unit="frame") as shown,
        ):
            take = counted(summaries, folder, not args.no_timing, shown.update)
            setup = order.setup
            join = Join(Tracker(setup.tracking, setup.targets, setup.recognizer))
            running = Running(
                order.packed(), named, engine, folder.journal, folder.known, join, pictures, take, tell,
                chained=remembers(targets, order.setup.recognizer, sources.calibrated),
            )  # fmt: skip
            with interruptible(running.stop) as interrupted:
                running.run()
        summaries[0].interrupted, summaries[0].problems = bool(interrupted), sources.problems
        folder.finish(_content(args, order.setup, summaries), done=not interrupted)
    except OSError as error:
        folder.check()
        raise SourceError(
            f"{folder.path}: cannot be written: {error.strerror or error}; the {summaries[0].frames} frames done so "
            "far are whole: make room, and the same command goes on"
        ) from error
    return summaries[0]


def _content(args: argparse.Namespace, setup: Setup, summaries: list[Summary]) -> dict[str, Any]:
    """summary.json."""
    looked_for = {t.name: {"label": t.label, "required": t.model.required.name} for t in setup.targets}
    each = [
        {"source": str(path), "frames": s.frames, "frames_with_error": s.errors.total(), "objects": dict(s.objects)}
        for path, s in zip(args.sources, summaries[1:], strict=True)
    ]
    sources = [str(path) for path in args.sources]
    return {"sources": sources, "looked_for": looked_for, **summaries[0].to_dict(), "per_source": each}


def _tell(summary: Summary, folder: Path, what: str) -> int:
    for line in summary.lines():
        print(line)
    for line in summary.failures():
        say(line)
    nothing = summary.unusable_only or not summary.frames
    if nothing and not (summary.interrupted and not summary.frames):  # else the user knows why there is none
        say(f"artrec: {f'none of {summary.frames} frames could be used' if summary.frames else 'there was no frame'}")
    print(f"{'why is told' if summary.unusable_only else what} in {folder}")
    return INTERRUPTED if summary.interrupted else int(nothing)


def _recording_path(text: str) -> Path:
    if not text.endswith(".rrd"):
        raise argparse.ArgumentTypeError(f"'{text}': the viewer knows its recordings by their ending: name it FILE.rrd")
    return Path(text)


def _image_count(text: str) -> int | None:
    if text in ("all", "none"):
        return None if text == "all" else 0
    return int(number(text, lambda v: v >= 0 and v == int(v), "number of pictures; 'all' and 'none' are words for it"))

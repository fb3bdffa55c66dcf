"""`artrec replay`: runs the recogniser over bags and folders of images; needs no ROS graph."""

from __future__ import annotations

import argparse
import json
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np
from tqdm import tqdm

from ..core.datatypes import Camera, FrameResult
from ..core.drawing import draw_error, draw_result
from ..core.errors import ImageError, SourceError
from ..core.tracking import Tracker
from ..io.bags import STORAGES
from ..io.cameras import load_camera
from ..io.parameters import load_parameters
from ..io.results import DETECTIONS_FILE, SUMMARY_FILE, FrameRecord
from ..io.sources import Frame, SourceOptions, Sources, open_sources
from ..io.video import VideoWriter
from .summary import Summary

PARAMETERS_FILE, VIDEO_FILE, FRAMES_FOLDER = "parameters.yaml", "video.mp4", "frames"


class Recognises(Protocol):
    """What the replay needs of a recogniser."""

    def recognize(self, image: Any, camera: Camera | None = None) -> FrameResult: ...


class ResultFolder:
    """The files of a replay, written frame by frame: an interrupted replay leaves what it has. A context manager."""

    def __init__(self, folder: Path, object_names: list[str], images: int | None, video: bool) -> None:
        """:param images: how many overlay pictures to write, from the first frame on; None: all."""
        self.folder, self._names, self._images = folder, object_names, images
        self._stack = ExitStack()
        self._stream = self._stack.enter_context((folder / DETECTIONS_FILE).open("w", encoding="utf-8"))
        self._video = self._stack.enter_context(VideoWriter(folder / VIDEO_FILE)) if video else None
        self._count = 0
        self._size = (640, 480)

    def __enter__(self) -> ResultFolder:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def add(self, frame: Frame, result: FrameResult | None, record: FrameRecord) -> None:
        self._stream.write(record.to_json() + "\n")
        self._stream.flush()
        save = self._images is None or self._count < self._images
        if save or self._video:
            self._add_picture(self._picture(frame, result, record), frame.stamp_ns, save)
        self._count += 1

    def _picture(self, frame: Frame, result: FrameResult | None, record: FrameRecord) -> Any:
        if frame.image is None or result is None:
            return draw_error(self._size, f"{frame.name}: {record.error}")
        picture = draw_result(frame.image, result, self._names, frame.camera)
        self._size = (picture.shape[1], picture.shape[0])
        return picture

    def _add_picture(self, picture: Any, stamp_ns: int, save: bool) -> None:
        if self._video:
            self._video.add(stamp_ns, picture)
        path = self.folder / FRAMES_FOLDER / f"{self._count:06d}.png"
        if save and not cv2.imwrite(str(path), picture, [cv2.IMWRITE_PNG_COMPRESSION, 3]):
            raise SourceError(f"{path}: cannot be written")


def replay(
    frames: Iterator[Frame], recognizer: Recognises, tracker: Tracker, results: ResultFolder, summary: Summary
) -> None:
    """Recognises frame by frame. A frame that cannot be used is recorded with its error, and the next one follows."""
    for frame in frames:
        result, error = None, frame.error
        if frame.image is not None:
            try:
                result = recognizer.recognize(frame.image, frame.camera)
            except ImageError as problem:
                error = str(problem)
        if result is None:
            record = FrameRecord(frame.stamp_ns, frame.name, error=error)
        else:
            frame_id = frame.camera.frame_id if frame.camera else ""
            result = tracker.update(frame.stamp_ns, result, frame_id)
            record = FrameRecord.of(frame.stamp_ns, frame.name, result, frame_id)
        results.add(frame, result, record)
        summary.add(record)


def add_parser(subparsers: Any) -> None:
    p = subparsers.add_parser(
        "replay", help="recognise objects in bags or folders of images", description=__doc__,
        epilog="In folders of images the stamp is the frame's number over --rate, unless every name is a number of 16 "
        "digits or more: that is its stamp in nanoseconds.",
    )  # fmt: skip
    p.add_argument("sources", metavar="SOURCE", nargs="+", type=Path, help="bag (rosbag2, ROS 1) or folder of images")
    p.add_argument(
        "--params-file", required=True, type=Path, action="append",
        help="the node's ROS parameter file; may be given again: later ones go before",
    )  # fmt: skip
    p.add_argument("-o", "--output", required=True, type=Path, metavar="DIR", help="where the results go")
    p.add_argument("--overwrite", action="store_true", help="replace results that are in DIR already")
    p.add_argument("--topic", help="image topic (else the only one, or the only one that fits image.kind)")
    p.add_argument("--camera-info-topic", help="calibration topic (else camera_info beside the image topic)")
    p.add_argument("--camera-info", type=Path, metavar="FILE", help="calibration file, instead of a topic")
    p.add_argument("--start-offset", type=_seconds, default=0.0, metavar="S", help="skip S seconds of each source")
    p.add_argument("--playback-duration", type=_seconds, metavar="S", help="read S seconds of each source")
    p.add_argument("-s", "--storage", choices=sorted(STORAGES), help="read only bag files of this kind")
    p.add_argument("--rate", type=_rate, default=30.0, metavar="HZ", help="rate of image folders (default: 30)")
    p.add_argument("--images", type=_image_count, metavar="all|none|N", help="overlay pictures (default: all)")
    p.add_argument("--no-video", action="store_true", help="write no video.mp4")
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Exit code 0: done; 1: interrupted, or no frame could be used."""
    setup = load_parameters(*args.params_file)
    options = SourceOptions(
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
    summary = Summary()
    with open_sources(args.sources, options, _say) as sources:
        prepare_folder(args.output, args.overwrite)
        (args.output / PARAMETERS_FILE).write_text(setup.to_yaml(), encoding="utf-8")
        names = [target.name for target in setup.targets]
        with ResultFolder(args.output, names, args.images, not args.no_video) as results, _interruptible(summary):
            replay(_progress(sources), setup.build(), Tracker(setup.tracking), results, summary)
        summary.problems = sources.problems
    looked_for = {t.name: {"label": t.label, "required": t.model.required.name} for t in setup.targets}
    content = {"sources": [str(s) for s in args.sources], "looked_for": looked_for, **summary.to_dict()}
    (args.output / SUMMARY_FILE).write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    for line in summary.lines():
        print(line)
    print(f"{'interrupted; what was done so far is' if summary.interrupted else 'results'} in {args.output}")
    return int(summary.interrupted or summary.frames == summary.errors.total())


def prepare_folder(folder: Path, overwrite: bool) -> None:
    """Makes the folder ready for results; of an older replay only what a replay writes is removed.

    :raises SourceError: if results are there and `overwrite` is not given, or the folder cannot be written.
    """
    if (folder / DETECTIONS_FILE).exists() and not overwrite:
        raise SourceError(f"{folder}: holds results already; choose another folder, or --overwrite")
    try:
        (folder / FRAMES_FOLDER).mkdir(parents=True, exist_ok=True)
        for name in (DETECTIONS_FILE, SUMMARY_FILE, PARAMETERS_FILE, VIDEO_FILE):
            (folder / name).unlink(missing_ok=True)
        for picture in (folder / FRAMES_FOLDER).glob("[0-9]*.png"):
            picture.unlink()
    except OSError as error:
        raise SourceError(f"{folder}: cannot be written: {error.strerror}") from error


def _say(line: str) -> None:
    tqdm.write(line, file=sys.stderr)


def _progress(sources: Sources) -> Iterator[Frame]:
    return iter(tqdm(sources, total=sources.count, unit="frame", disable=not sys.stderr.isatty()))


@contextmanager
def _interruptible(summary: Summary) -> Iterator[None]:
    """SIGINT and SIGTERM end the replay between two steps, and the summary says so."""
    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    except KeyboardInterrupt:
        summary.interrupted = True
    finally:
        signal.signal(signal.SIGTERM, previous)


def _number(text: str, accept: Callable[[float], bool], what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not (np.isfinite(value) and accept(value)):
        raise argparse.ArgumentTypeError(f"'{text}' is no {what}")
    return value


def _seconds(text: str) -> float:
    return _number(text, lambda v: v >= 0, "number of seconds")


def _rate(text: str) -> float:
    return _number(text, lambda v: v > 0, "rate in Hz")


def _image_count(text: str) -> int | None:
    if text in ("all", "none"):
        return None if text == "all" else 0
    return int(_number(text, lambda v: v >= 0 and v == int(v), "number of pictures; 'all' and 'none' are words for it"))

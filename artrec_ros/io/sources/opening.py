"""What is replayed: bags, folders of images and videos, one after the other, as a sequence of frames."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

from ...core.base.errors import ImageError, SourceError, UnreadableError
from ..bags.metadata import BAG_SUFFIXES, is_storage
from ..bags.reader import Bag
from ..bags.topics import Report
from ..images.decoding import IMAGE_SUFFIXES, read_image
from ..images.folders import LOSSY, images_of, is_lossy, passed_over
from ..images.video import VIDEO_SUFFIXES
from .bag_source import BagSource
from .frames import Frame, Part, Source, SourceOptions, UnreadSource, fitting, once
from .kinds import check_kind
from .video_source import VideoSource

_STAMP_DIGITS = 16  # a stem of at least so many digits is a time in nanoseconds,
_LAST_NS = (2**31 - 1) * 10**9  # up to the last one that builtin_interfaces/Time holds

_STILL = ".gif"  # a folder's may be single images


def stamps_by_name(files: Sequence[Path]) -> list[int]:
    """Stamps (ns) of images whose names are such; none where one of them is not."""
    stems = [p.stem for p in files]
    stamps = [int(stem) for stem in stems if stem.isdecimal() and len(stem) >= _STAMP_DIGITS]
    return stamps if len(stamps) == len(stems) and max(stamps, default=0) <= _LAST_NS else []


class FolderSource(Source):
    """The images of a folder in natural order ('2.png' before '10.png').

    :ivar files: stamp (ns) and path of each.
    """

    def __init__(self, folder: Path, options: SourceOptions, report: Report = lambda _: None) -> None:
        files = sorted(images_of(folder), key=_natural)
        if not files:
            bags, images = ", ".join(BAG_SUFFIXES), ", ".join(IMAGE_SUFFIXES)
            raise SourceError(f"{folder}: neither a bag ({bags}) nor images ({images}){_instead(folder)}")
        stamps = stamps_by_name(files) or [round(i * 1e9 / options.rate_hz) for i in range(len(files))]
        start_ns, stop_ns = options.span_ns(stamps[0])
        self.files = [
            (t, p) for t, p in zip(stamps, files, strict=True) if start_ns <= t and (stop_ns is None or t < stop_ns)
        ]
        self._lossy = options.image_kind == "labels" and any(is_lossy(p) for _, p in self.files)
        self._folder, self._camera, self._report = folder, options.camera, once(report)
        self.count, self.calibrated = len(self.files), options.camera is not None
        self._why_none = options.why_none((stamps[-1] - stamps[0]) * 1e-9)

    def __iter__(self) -> Iterator[Frame]:
        self._tell()
        return self.read(Part(0, self.count))

    def parts(self, size: int) -> Iterator[Part]:
        self._tell()
        return (Part(first, min(size, self.count - first)) for first in range(0, self.count, size))

    def _tell(self) -> None:
        """Said by whoever reads all, not by each worker."""
        if self._why_none:
            self._report(f"{self._folder}: {self._why_none}")
        if self._lossy:
            self._report(f"{self._folder}: {LOSSY}")
        if others := passed_over(self._folder):
            self._report(f"{self._folder}: passed over: {others}; images are {', '.join(IMAGE_SUFFIXES)}")

    def read(self, part: Part) -> Iterator[Frame]:
        for stamp_ns, path in self.files[part.first : part.first + part.count]:
            try:
                image = read_image(path)
            except ImageError as error:
                yield Frame(stamp_ns, _printable(path.name), error=_printable(str(error)))
                continue
            camera = fitting(self._camera, image, self._report, "--camera-info")
            yield Frame(stamp_ns, _printable(path.name), image, camera)


def _printable(text: str) -> str:
    """Text of a file's name, whose bytes need not be UTF-8."""
    return os.fsencode(text).decode("utf-8", "backslashreplace")


def _instead(folder: Path) -> str:
    """What to do instead, where bags or images lie one level below, or videos or other files in a folder."""
    kinds = (*BAG_SUFFIXES, *IMAGE_SUFFIXES)
    holders = sorted({str(p.parent) for p in folder.glob("*/*") if p.suffix.lower() in kinds})
    if holders:
        return f"; look in {' or '.join(holders[:3])}"
    videos = sorted(p for p in folder.iterdir() if p.suffix.lower() in VIDEO_SUFFIXES and p.suffix.lower() != _STILL)
    if videos:
        return f"; give a video in it by its name: {videos[0]}"
    others = passed_over(folder)
    return f"; it holds {others}" if others else ""


class Sources:
    """Several sources, one after the other. A context manager; iterate it once.

    :ivar parts: the sources. :ivar count: frames to expect at most.
    """

    def __init__(self, paths: Sequence[Path], options: SourceOptions, report: Report, keep_going: bool) -> None:
        self._stack = ExitStack()
        unread = list[UnreadableError]()
        try:
            self.parts = [self._open_or_pass(path, options, report, unread) for path in paths]
            if unread and not (keep_going and len(unread) < len(self.parts)):
                raise unread[0]
        except BaseException:
            self._stack.close()
            raise
        for error in unread:
            report(f"{error}; the other sources are read")
        self.count = sum(part.count for part in self.parts)

    def __enter__(self) -> Sources:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def __iter__(self) -> Iterator[Frame]:
        for part in self.parts:
            yield from part

    @property
    def problems(self) -> list[str]:
        return [line for part in self.parts for line in part.problems]

    @property
    def calibrated(self) -> set[bool]:
        """Whether there are calibrations, of all that can be read."""
        return {part.calibrated for part in self._readable}

    def starts_calibrated(self) -> bool:
        """Whether a calibration holds for the first frame of each."""
        return all(part.starts_calibrated() for part in self._readable)

    @property
    def _readable(self) -> list[Source]:
        return [part for part in self.parts if not isinstance(part, UnreadSource)]

    def _open_or_pass(
        self, path: Path, options: SourceOptions, report: Report, unread: list[UnreadableError]
    ) -> Source:
        """:param unread: gets the errors of those that are damaged."""
        try:
            return self._open(path, options, report)
        except UnreadableError as error:
            unread.append(error)
            return UnreadSource(str(error))

    def _open(self, path: Path, options: SourceOptions, report: Report) -> Source:
        check_kind(path)
        if path.is_dir() and not holds_bag(path):
            return FolderSource(path, options, report)
        if path.suffix.lower() in VIDEO_SUFFIXES and not path.is_dir():
            video = VideoSource(path, options, report)
            self._stack.callback(video.close)
            return video
        return BagSource(self._stack.enter_context(Bag(path, options.storage)), options, report)


def open_sources(
    paths: Sequence[Path],
    options: SourceOptions | None = None,
    report: Report | None = None,
    *,
    keep_going: bool = False,
) -> Sources:
    """Opens bags, folders of images and videos.

    :param report: called with one line for whatever the user should know but that stops nothing.
    :param keep_going: a damaged source is one of the problems, and has no frames, where there are others that are not.
    :raises SourceError: a path that is none, an image topic that is missing or cannot be told.
    """
    return Sources(paths, options or SourceOptions(), report or (lambda _: None), keep_going)


def holds_bag(folder: Path) -> bool:
    """Whether a folder is a bag, not one of images."""
    return any(p.name == "metadata.yaml" or is_storage(p) for p in folder.iterdir())


def _natural(path: Path) -> list[tuple[int, int | str]]:
    """Sort key: digits by value, the rest by character."""
    return [(0, int(part)) if part.isdecimal() else (1, part) for part in re.split(r"(\d+)", path.name)]

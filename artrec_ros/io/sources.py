"""What is replayed: bags and folders of images, one after the other, as a sequence of frames."""

from __future__ import annotations

import dataclasses
import re
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from ..core.datatypes import Camera
from ..core.errors import ConfigError, ImageError, SourceError
from .bags import BAG_SUFFIXES, Bag
from .images import IMAGE_SUFFIXES, Image, read_image
from .recovery import RawMessage
from .topics import Report, camera_info_topic, camera_of, choose_topic, decode_message, listed, stamp_of

STAMP_DIGITS = 16  # a stem of at least so many digits is a time in nanoseconds


@dataclass(frozen=True)
class Frame:
    """One image of a source, or the reason (`error`) why there is none.

    :param stamp_ns: the image header's stamp. :param name: the bag's topic, or the file's name.
    """

    stamp_ns: int
    name: str
    image: Image | None = field(default=None, repr=False, compare=False)
    camera: Camera | None = field(default=None, compare=False)
    error: str | None = None


@dataclass(frozen=True)
class SourceOptions:
    """How sources are read.

    :param topic: the image topic; None: the only one there is, or the only one that fits `image_kind`.
    :param image_kind: what the images should hold: 'labels' (one channel), 'palette' or 'colour' (three).
    :param camera_info_topic: None: the one beside the image topic.
    :param camera: the calibration to use whatever the source says.
    :param rectified: images are rectified: of a calibration in the source, P holds.
    :param start_offset_s, playback_duration_s: the part of each source to read, seconds.
    :param storage: 'mcap' or 'sqlite3': read only such files of a folder.
    :param rate_hz: of image folders, whose stamps are counted at this rate from 0, unless every file name
        is a number of 16 digits or more: that is taken for its stamp in nanoseconds.
    """

    topic: str | None = None
    image_kind: str | None = None
    camera_info_topic: str | None = None
    camera: Camera | None = None
    rectified: bool = False
    start_offset_s: float = 0.0
    playback_duration_s: float | None = None
    storage: str | None = None
    rate_hz: float = 30.0

    def span_ns(self, first_ns: int) -> tuple[int, int | None]:
        """Start (inclusive) and stop (exclusive) for a source that begins at `first_ns`."""
        start = first_ns + round(self.start_offset_s * 1e9)
        return start, None if self.playback_duration_s is None else start + round(self.playback_duration_s * 1e9)


class Source(ABC):
    """One bag or folder. Iterate it once; `count` is how many frames to expect at most."""

    count: int

    @abstractmethod
    def __iter__(self) -> Iterator[Frame]: ...

    @property
    def problems(self) -> list[str]:
        """One line for everything of the source that could not be read, complete after the iteration."""
        return []


class BagSource(Source):
    """The images of one topic of a bag, each with the newest calibration before it."""

    def __init__(self, bag: Bag, options: SourceOptions, report: Report) -> None:
        self._bag, self._options = bag, options
        self._report = _once(report)
        self.topic = choose_topic(bag, options.topic, options.image_kind, report)
        self._info_topic = options.camera_info_topic or camera_info_topic(self.topic)
        self.count = bag.topics[self.topic].count
        if options.camera_info_topic and options.camera_info_topic not in bag.topics:
            raise SourceError(f"{bag.path}: no topic '{options.camera_info_topic}'. {listed(bag)}")

    @property
    def problems(self) -> list[str]:
        return self._bag.problems

    def __iter__(self) -> Iterator[Frame]:
        bag, options = self._bag, self._options
        camera = options.camera
        follow_infos = camera is None and self._info_topic in bag.topics
        if follow_infos:  # images may come before the first calibration, which holds for them just as well
            camera = next((self._camera(m) for m in bag.messages([self._info_topic])), None)
        elif camera is None:
            self._report(f"{bag.path}: no topic '{self._info_topic}': without calibration there are no metric poses")
        start_ns, stop_ns = options.span_ns(bag.start_ns)
        names = [self.topic, self._info_topic] if follow_infos else [self.topic]
        for message in bag.messages(names, start_ns, stop_ns):
            if message.topic == self.topic:
                yield self._frame(message, camera)
            else:
                camera = self._camera(message)

    def _frame(self, message: RawMessage, camera: Camera | None) -> Frame:
        stamp_ns = message.log_ns
        try:
            content = self._bag.parse(message)
            stamp_ns = stamp_of(content, message.log_ns)
            image = decode_message(content)
        except ImageError as error:
            return Frame(stamp_ns, self.topic, error=str(error))
        return Frame(stamp_ns, self.topic, image, self._fitting(camera, image, content.header.frame_id))

    def _fitting(self, camera: Camera | None, image: Image, frame_id: str) -> Camera | None:
        """The camera if it is one for such images, with the image's frame."""
        height, width = image.shape[:2]
        if camera is None or camera.size == (width, height):
            return camera and dataclasses.replace(camera, frame_id=frame_id or camera.frame_id)
        self._report(
            f"{self._info_topic}: calibrated for {camera.size[0]}x{camera.size[1]} pixels, but images have "
            f"{width}x{height}: no metric poses"
        )
        return None

    def _camera(self, message: RawMessage) -> Camera | None:
        try:
            return camera_of(self._bag.parse(message), self._options.rectified)
        except (ImageError, ConfigError) as error:
            self._report(f"{self._info_topic}: {error}: no metric poses")
            return None


class FolderSource(Source):
    """The images of a folder in natural order ('2.png' before '10.png')."""

    def __init__(self, folder: Path, options: SourceOptions) -> None:
        files = sorted((p for p in folder.iterdir() if p.suffix.lower() in IMAGE_SUFFIXES), key=_natural)
        if not files:
            bags, images = ", ".join(BAG_SUFFIXES), ", ".join(IMAGE_SUFFIXES)
            raise SourceError(f"{folder}: neither a bag ({bags}) nor images ({images})")
        named = all(p.stem.isdecimal() and len(p.stem) >= STAMP_DIGITS for p in files)
        stamps = [int(p.stem) if named else round(i * 1e9 / options.rate_hz) for i, p in enumerate(files)]
        start_ns, stop_ns = options.span_ns(stamps[0])
        self._files = [
            (t, p) for t, p in zip(stamps, files, strict=True) if start_ns <= t and (stop_ns is None or t < stop_ns)
        ]
        self._camera = options.camera
        self.count = len(self._files)

    def __iter__(self) -> Iterator[Frame]:
        for stamp_ns, path in self._files:
            try:
                yield Frame(stamp_ns, path.name, read_image(path), self._camera)
            except ImageError as error:
                yield Frame(stamp_ns, path.name, error=str(error))


class Sources:
    """Several sources, one after the other. A context manager; iterate it once.

    :ivar count: frames to expect at most.
    """

    def __init__(self, paths: Sequence[Path], options: SourceOptions, report: Report) -> None:
        self._stack = ExitStack()
        try:
            self.parts = [self._open(path, options, report) for path in paths]
        except BaseException:
            self._stack.close()
            raise
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

    def _open(self, path: Path, options: SourceOptions, report: Report) -> Source:
        if path.is_dir() and not _holds_bag(path):
            return FolderSource(path, options)
        return BagSource(self._stack.enter_context(Bag(path, options.storage)), options, report)


def open_sources(paths: Sequence[Path], options: SourceOptions | None = None, report: Report | None = None) -> Sources:
    """Opens bags and folders of images.

    :param report: called with one line for whatever the user should know but that stops nothing.
    :raises SourceError: a path that is neither, an image topic that is missing or cannot be told.
    """
    return Sources(paths, options or SourceOptions(), report or (lambda _: None))


def _holds_bag(folder: Path) -> bool:
    files = [p.name for p in folder.iterdir()]
    return any(n == "metadata.yaml" or n.removesuffix(".zstd").endswith(BAG_SUFFIXES) for n in files)


def _natural(path: Path) -> list[tuple[int, int | str]]:
    """Sort key: digits by value, the rest by character."""
    return [(0, int(part)) if part.isdecimal() else (1, part) for part in re.split(r"(\d+)", path.name)]


def _once(report: Report) -> Report:
    """`report` for lines that would repeat with every frame."""
    said: set[str] = set()

    def report_once(line: str) -> None:
        if line not in said:
            said.add(line)
            report(line)

    return report_once

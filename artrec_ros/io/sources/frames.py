"""What sources of images give: frames, read from the start or in parts."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field

from ...core.geometry.camera import Camera
from ..bags.topics import Report
from ..images.decoding import Image


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

    def why_none(self, lasts_s: float) -> str:
        """Why nothing of a source that lasts so long is read; empty: some of it may be."""
        if self.start_offset_s <= lasts_s:
            return ""
        return f"nothing of it is read: it lasts {lasts_s:.2f} s, --start-offset is {self.start_offset_s:g}"

    def span_ns(self, first_ns: int) -> tuple[int, int | None]:
        """Start (inclusive) and stop (exclusive) for a source that begins at `first_ns`."""
        start = first_ns + round(self.start_offset_s * 1e9)
        return start, None if self.playback_duration_s is None else start + round(self.playback_duration_s * 1e9)


@dataclass(frozen=True)
class Part:
    """Frames of a source that follow each other.

    :param first: the number of the first one; `count`: how many they are.
    :param from_ns: bags: where to begin to read, by the time of recording; None: at the start.
    :param skip: bags: how many images come from there on before the first one; videos: from the start.
    :param cameras: bags: the calibration of each; empty: there is none in the bag, or it is not asked for.
    """

    first: int
    count: int
    from_ns: int | None = None
    skip: int = 0
    cameras: tuple[Camera | None, ...] = ()


class Source(ABC):
    """One bag, folder or video.

    :ivar count: frames to expect at most. :ivar calibrated: whether a calibration is there.
    """

    count: int
    calibrated: bool

    @abstractmethod
    def __iter__(self) -> Iterator[Frame]: ...

    @abstractmethod
    def parts(self, size: int) -> Iterator[Part]:
        """All frames in parts of this size, the last one smaller; images are not decoded for that."""

    @abstractmethod
    def read(self, part: Part) -> Iterator[Frame]:
        """The frames of a part, as they are in the iteration of all."""

    def starts_calibrated(self) -> bool:
        """Whether a calibration holds for the first frame: one that is there may be for images of another size."""
        if not self.calibrated:
            return False
        frames = (frame for part in self.parts(1) for frame in self.read(part))
        first = next(frames, None)
        return first is None or first.image is None or first.camera is not None

    @property
    def problems(self) -> list[str]:
        """One line for everything of the source that could not be read, complete after an iteration of all."""
        return []


class UnreadSource(Source):
    """One that cannot be read, in the place that it has among others."""

    count, calibrated = 0, False

    def __init__(self, why: str) -> None:
        self._why = why

    def __iter__(self) -> Iterator[Frame]:
        return iter(())

    def parts(self, size: int) -> Iterator[Part]:
        return iter(())

    def read(self, part: Part) -> Iterator[Frame]:
        return iter(())

    @property
    def problems(self) -> list[str]:
        return [self._why]


def fitting(camera: Camera | None, image: Image, report: Report, whence: str, frame_id: str = "") -> Camera | None:
    """The camera if it is one for images of this size, with the image's frame; else none, which is told.

    :param whence: where the calibration is from.
    """
    height, width = image.shape[:2]
    if camera is None or camera.size == (width, height):
        return camera and dataclasses.replace(camera, frame_id=frame_id or camera.frame_id)
    report(
        f"{whence}: calibrated for {camera.size[0]}x{camera.size[1]} pixels, but images have {width}x{height}"
        f"{_way_out(camera.size, (width, height))}"
    )
    return None


def _way_out(calibrated: tuple[int, int], size: tuple[int, int]) -> str:
    """Of a calibration for images of another size (width, height)."""
    if calibrated == size[::-1]:
        return " (are its width and height exchanged?): no metric poses"
    by, down = size[0] / calibrated[0], size[1] / calibrated[1]
    scaled = f", or fx, fy, cx, cy of this one times {by:.6g} where they were scaled" if by == down else ""
    return f": no metric poses; give a calibration of that size{scaled}"


def once(report: Report) -> Report:
    """`report` for lines that would repeat with every frame."""
    said: set[str] = set()

    def report_once(line: str) -> None:
        if line not in said:
            said.add(line)
            report(line)

    return report_once

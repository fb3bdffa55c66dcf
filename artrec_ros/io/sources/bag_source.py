"""The images of a bag's topic, with their calibrations."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from itertools import chain, islice

from ...core.base.errors import ConfigError, ImageError
from ...core.geometry.camera import Camera
from ..bags.infos import Info, of_another
from ..bags.reader import Bag
from ..bags.recovery import RawMessage
from ..bags.topics import Report, camera_of, choose_info_topic, choose_topic, decode_message
from .frames import Frame, Part, Source, SourceOptions, fitting, once
from .look_ahead import AHEAD_NS, Held, LookAhead


class BagSource(Source):
    """The images of one topic of a bag, each with the calibration of its stamp, else the newest before it.

    :ivar topic, info_topic: of the images and of their calibration, which need not be there.
    """

    def __init__(self, bag: Bag, options: SourceOptions, report: Report) -> None:
        self.bag, self._options = bag, options
        self._report = once(report)
        self.topic = choose_topic(bag, options.topic, options.image_kind, report)
        self.info_topic, self._has_infos = choose_info_topic(bag, options.camera_info_topic, self.topic)
        self.count = bag.topics[self.topic].count
        self.calibrated = options.camera is not None or self._has_infos
        self._last: tuple[bytes, Camera | None] | None = None  # calibration: what its message tells, and what it is
        self._others: dict[str, None] = {}  # lines about calibrations that were used though they are another camera's

    @property
    def problems(self) -> list[str]:
        return [*self.bag.problems, *self._others]

    @property
    def _follows_infos(self) -> bool:
        return self._options.camera is None and self._has_infos

    def __iter__(self) -> Iterator[Frame]:
        self._tell()
        for message, camera in self._images():
            yield self._frame(message, camera)

    def parts(self, size: int) -> Iterator[Part]:
        """Whoever cuts the bag into parts reads its calibrations, and hands on to each what its images have: which one
        that is may be told by what lies behind a part."""
        self._tell()
        part, cameras, same_time, last_ns = Part(0, 0), list[Camera | None](), 0, None
        for number, (message, camera) in enumerate(self._images(whole=False)):
            same_time = same_time + 1 if message.log_ns == last_ns else 0
            last_ns = message.log_ns
            if number % size == 0:
                yield from self._filled(part, cameras)
                seeks, cameras = self.bag.in_order, []
                part = Part(number, 0, last_ns if seeks else None, same_time if seeks else number)
            cameras.append(camera)
        yield from self._filled(part, cameras)

    def _filled(self, part: Part, cameras: Sequence[Camera | None]) -> Iterator[Part]:
        if cameras:
            given = tuple(cameras) if self._follows_infos else ()
            yield dataclasses.replace(part, count=len(cameras), cameras=given)

    def _tell(self) -> None:
        """Said by whoever reads all, not by each worker."""
        if line := self._options.why_none(max(0, self.bag.end_ns - self.bag.start_ns) * 1e-9):
            self._report(f"{self.bag.path}: {line}")

    def read(self, part: Part) -> Iterator[Frame]:
        start_ns, stop_ns = self._span_ns
        messages = self.bag.messages([self.topic], start_ns if part.from_ns is None else part.from_ns, stop_ns)
        cameras = part.cameras or [self._options.camera] * part.count
        for message, camera in zip(islice(messages, part.skip, part.skip + part.count), cameras, strict=False):
            yield self._frame(message, camera)

    def messages(self) -> Iterator[RawMessage]:
        """The images and calibrations as they were recorded, calibrations from shortly before to shortly behind it."""
        start_ns, stop_ns = self._span_ns
        if start_ns is not None:
            yield from self.bag.messages([self.info_topic], max(0, start_ns - AHEAD_NS), start_ns)
        yield from self.bag.messages([self.topic, self.info_topic], start_ns, stop_ns)
        if stop_ns is not None:
            yield from self.bag.messages([self.info_topic], stop_ns, stop_ns + AHEAD_NS)

    @property
    def _span_ns(self) -> tuple[int | None, int | None]:
        """What is asked for of the bag; without bounds, so that all is counted, where that is all of it."""
        start_ns, stop_ns = self._options.span_ns(self.bag.start_ns)
        return start_ns if self._options.start_offset_s else None, stop_ns

    def _images(self, whole: bool = True) -> Iterator[tuple[RawMessage, Camera | None]]:
        """Messages of images, not decoded, each with its calibration. :param whole: with their bytes."""
        if self._follows_infos:
            for held in self._with_infos(whole):
                self._note_other(held)
                yield held.message, None if held.info is None else held.info.content
            return
        if self._options.camera is None:
            self._report(
                f"{self.bag.path}: no topic '{self.info_topic}': without calibration there are no metric poses"
            )
        for message in self.bag.messages([self.topic], *self._span_ns):
            yield message, self._options.camera

    def _with_infos(self, whole: bool) -> Iterator[Held[Camera | None]]:
        ahead = LookAhead[Camera | None]()
        # the bag's first one goes before all: images may come before it, and it holds for them just as well
        for message in chain(islice(self.bag.messages([self.info_topic]), 1), self.messages()):
            if message.topic == self.info_topic:
                yield from ahead.add_info(self._info(message), message.log_ns)
            else:
                head = self.bag.head(message)
                kept = message if whole else message._replace(data=b"")
                yield from ahead.add_image(kept, head.stamp_ns, head.frame_id)
        yield from ahead.rest()

    def _note_other(self, held: Held[Camera | None]) -> None:
        info = held.info
        if info is not None and not info.rank(held.stamp_ns, held.frame_id).fits:
            line = of_another(info.frame_id, held.frame_id, self.info_topic)
            self._others[f"{self.bag.path}: {line}"] = None

    def _frame(self, message: RawMessage, camera: Camera | None) -> Frame:
        stamp_ns = self.bag.head(message).stamp_ns
        try:
            content = self.bag.parse(message)
            image = decode_message(content)
        except ImageError as error:
            return Frame(stamp_ns, self.topic, error=str(error))
        whence = "--camera-info" if self._options.camera is not None else self.info_topic
        camera = fitting(camera, image, self._report, whence, content.header.frame_id)
        return Frame(stamp_ns, self.topic, image, camera)

    def _info(self, message: RawMessage) -> Info[Camera | None]:
        """The calibration, made anew only where it is another one than that before: parts of a source name many."""
        head = self.bag.head(message)
        told = message.data[head.end :]
        if self._last is None or self._last[0] != told:
            self._last = told, self._camera(message)
        return Info(head.stamp_ns, head.frame_id, self._last[1])

    def _camera(self, message: RawMessage) -> Camera | None:
        try:
            return camera_of(self.bag.parse(message), self._options.rectified)
        except (ImageError, ConfigError) as error:
            self._report(f"{self.info_topic}: {error}: no metric poses")
            return None

"""The images of a bag's topic, with their calibrations."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from itertools import islice

from ...core.base.errors import ConfigError, ImageError
from ...core.geometry.camera import Camera
from ..bags.reader import Bag
from ..bags.recovery import RawMessage
from ..bags.topics import Report, camera_of, choose_info_topic, choose_topic, decode_message, stamp_of
from .frames import Frame, Part, Source, SourceOptions, fitting, once


class BagSource(Source):
    """The images of one topic of a bag, each with the newest calibration before it.

    :ivar topic, info_topic: of the images and of their calibration, which need not be there.
    """

    def __init__(self, bag: Bag, options: SourceOptions, report: Report) -> None:
        self.bag, self._options = bag, options
        self._report = once(report)
        self.topic = choose_topic(bag, options.topic, options.image_kind, report)
        self.info_topic, self._has_infos = choose_info_topic(bag, options.camera_info_topic, self.topic)
        self.count = bag.topics[self.topic].count
        self.calibrated = options.camera is not None or self._has_infos

    @property
    def problems(self) -> list[str]:
        return self.bag.problems

    @property
    def _follows_infos(self) -> bool:
        return self._options.camera is None and self._has_infos

    def __iter__(self) -> Iterator[Frame]:
        self._tell()
        for message, camera in self._images(None, self._first_camera()):
            yield self._frame(message, camera)

    def parts(self, size: int) -> Iterator[Part]:
        self._tell()
        first, begun, same_time, last_ns = 0, None, 0, None
        number = -1
        for number, (message, camera) in enumerate(self._images(None, self._first_camera())):
            same_time = same_time + 1 if message.log_ns == last_ns else 0
            last_ns = message.log_ns
            if number % size == 0:
                if begun is not None:
                    yield dataclasses.replace(begun, count=size)
                first, seeks = number, self.bag.in_order
                begun = Part(first, 0, last_ns if seeks else None, same_time if seeks else number, camera)
        if begun is not None:
            yield dataclasses.replace(begun, count=number + 1 - first)

    def _tell(self) -> None:
        """Said by whoever reads all, not by each worker."""
        if line := self._options.why_none(max(0, self.bag.end_ns - self.bag.start_ns) * 1e-9):
            self._report(f"{self.bag.path}: {line}")

    def read(self, part: Part) -> Iterator[Frame]:
        images = self._images(part.from_ns, part.camera)
        for message, camera in islice(images, part.skip, part.skip + part.count):
            yield self._frame(message, camera)

    def messages(self) -> Iterator[RawMessage]:
        """The images and calibrations as they were recorded."""
        return self.bag.messages([self.topic, self.info_topic], *self._span_ns)

    @property
    def _span_ns(self) -> tuple[int | None, int | None]:
        """What is asked for of the bag; without bounds, so that all is counted, where that is all of it."""
        start_ns, stop_ns = self._options.span_ns(self.bag.start_ns)
        return start_ns if self._options.start_offset_s else None, stop_ns

    def _first_camera(self) -> Camera | None:
        """Images may come before the first calibration, which holds for them just as well."""
        if self._follows_infos:
            return next((self._camera(m) for m in self.bag.messages([self.info_topic])), None)
        if self._options.camera is None:
            self._report(
                f"{self.bag.path}: no topic '{self.info_topic}': without calibration there are no metric poses"
            )
        return self._options.camera

    def _images(self, from_ns: int | None, camera: Camera | None) -> Iterator[tuple[RawMessage, Camera | None]]:
        """Messages of images, not decoded, each with the calibration that holds then."""
        start_ns, stop_ns = self._span_ns
        names = [self.topic, self.info_topic] if self._follows_infos else [self.topic]
        for message in self.bag.messages(names, start_ns if from_ns is None else from_ns, stop_ns):
            if message.topic == self.topic:
                yield message, camera
            else:
                camera = self._camera(message)

    def _frame(self, message: RawMessage, camera: Camera | None) -> Frame:
        stamp_ns = message.log_ns
        try:
            content = self.bag.parse(message)
            stamp_ns = stamp_of(content, message.log_ns)
            image = decode_message(content)
        except ImageError as error:
            return Frame(stamp_ns, self.topic, error=str(error))
        whence = "--camera-info" if self._options.camera is not None else self.info_topic
        camera = fitting(camera, image, self._report, whence, content.header.frame_id)
        return Frame(stamp_ns, self.topic, image, camera)

    def _camera(self, message: RawMessage) -> Camera | None:
        try:
            return camera_of(self.bag.parse(message), self._options.rectified)
        except (ImageError, ConfigError) as error:
            self._report(f"{self.info_topic}: {error}: no metric poses")
            return None

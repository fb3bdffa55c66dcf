"""What a worker does: recognise and draw frames of a part of a source. What a frame tells the next
one is handed from job to job: it does not matter which worker has it."""

from __future__ import annotations

import pickle
import threading
import uuid
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.base.errors import ImageError, SourceError
from ...core.drawing import class_picture, draw_error, draw_result
from ...core.image.segmentation import Segmenter
from ...core.memory.memory import Memory
from ...io.parameters.parameter_file import Setup
from ...io.results.journal import Recognised
from ...io.sources.frames import Frame, Part, Source, SourceOptions
from ...io.sources.opening import open_sources
from .raw_frames import RawFrame

_ERROR_SIZE_PX = (640, 480)


@dataclass(frozen=True)
class Order:
    """What all workers of a replay are told: they read the sources themselves.

    :param options: of each source, its topic chosen. :param calibrated: there is a calibration for some of them.
    :param with_classes: overlays stand beside the class images.
    """

    setup: Setup
    sources: tuple[Path, ...]
    options: tuple[SourceOptions, ...]
    calibrated: bool = True
    with_classes: bool = False

    def packed(self) -> bytes:
        """For `work`; no two are the same: each run has workers of its own."""
        return pickle.dumps((uuid.uuid4().hex, self))


@dataclass(frozen=True)
class Seen:
    """A recognised frame. :param place: in its part. :param notes: lines for the user."""

    place: int
    frame: Recognised
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Drawn:
    """An overlay. :param place: of the frame in its part. :param png: for a file. :param picture: for a video, bag.

    :param raw: the frame without it, for a recording.
    """

    place: int
    png: bytes | None
    picture: NDArray[np.uint8] | None = field(repr=False)
    raw: RawFrame | None = None


@dataclass(frozen=True)
class Wanted:
    """A frame that is to be drawn, as a file (`png`) or as it is (`plain`), or is wanted without drawing (`raw`)."""

    place: int
    frame: Recognised
    png: bool
    plain: bool
    raw: bool = False


class Worker:
    """Holds a recogniser, and the source that it read last."""

    def __init__(self, order: Order) -> None:
        self._order = order
        self._recognizer = order.setup.build(calibrated=order.calibrated)
        self._segmenter = Segmenter(order.setup.image)
        self._names = [target.name for target in order.setup.targets]
        self._stack = ExitStack()
        self._open: tuple[int, Source] | None = None
        self._notes: list[str] = []

    def recognise(
        self, source: int, part: Part, places: Collection[int], memory: Memory | None = None
    ) -> Iterator[Seen]:
        """The frames of a part that have these places in it.

        :param memory: that the frame before the first one left.
        """
        for place, frame in enumerate(self._read(source, part)):
            if place in places:
                recognised = self._recognised(frame, memory)
                memory = recognised.memory
                yield Seen(place, recognised, self._taken_notes())

    def _recognised(self, frame: Frame, memory: Memory | None) -> Recognised:
        frame_id = frame.camera.frame_id if frame.camera else ""
        if frame.image is None:
            return Recognised(frame.stamp_ns, frame.name, error=frame.error, memory=memory)
        try:
            result, left = self._recognizer.follow(frame.image, frame.camera, frame.stamp_ns, memory)
        except ImageError as error:
            return Recognised(frame.stamp_ns, frame.name, error=str(error), memory=memory)
        return Recognised(frame.stamp_ns, frame.name, result, frame_id, memory=left)

    def draw(self, source: int, part: Part, wanted: Sequence[Wanted]) -> Iterator[Drawn]:
        """Overlays of these frames of a part."""
        by_place = {w.place: w for w in wanted}
        for place, frame in enumerate(self._read(source, part)):
            if place in by_place:
                yield self._drawn(frame, by_place[place])

    def _drawn(self, frame: Frame, wanted: Wanted) -> Drawn:
        seen = wanted.frame
        raw = RawFrame.of(frame, self._segmenter) if wanted.raw and seen.result is not None else None
        if not (wanted.png or wanted.plain):
            return Drawn(wanted.place, None, None, raw)
        if frame.image is None or seen.result is None:
            picture = draw_error(_ERROR_SIZE_PX, f"{frame.name}: {seen.error}")
        else:
            picture = draw_result(frame.image, seen.result, self._names, frame.camera)
            if self._order.with_classes:
                classes = class_picture(self._segmenter.labels(frame.image), self._order.setup.image.named_labels)
                size = (picture.shape[1], picture.shape[0])
                picture = np.hstack([picture, cv2.resize(classes, size, interpolation=cv2.INTER_NEAREST)])
        png = None
        if wanted.png:
            png = cv2.imencode(".png", picture, [cv2.IMWRITE_PNG_COMPRESSION, 3])[1].tobytes()
        return Drawn(wanted.place, png, picture if wanted.plain else None, raw)

    def _read(self, source: int, part: Part) -> Iterator[Frame]:
        if self._open is None or self._open[0] != source:
            self._stack.close()
            paths, options = [self._order.sources[source]], self._order.options[source]
            opened = self._stack.enter_context(open_sources(paths, options, self._notes.append))
            self._open = source, opened.parts[0]
        count = 0
        for frame in self._open[1].read(part):
            count += 1
            yield frame
        if count != part.count:
            raise SourceError(f"{self._order.sources[source]}: it changed while it was read; replay it again")

    def _taken_notes(self) -> tuple[str, ...]:
        notes = tuple(self._notes)
        self._notes.clear()
        return notes


_held = threading.local()


def work(order: bytes, task: str, *arguments: Any) -> Iterator[Any]:
    """`Worker.recognise` or `Worker.draw`, by a worker that is made once in each thread.

    :param order: a packed `Order`. :param task: the method's name.
    """
    if getattr(_held, "order", None) != order:
        _held.worker, _held.order = Worker(pickle.loads(order)[1]), order
    yield from getattr(_held.worker, task)(*arguments)

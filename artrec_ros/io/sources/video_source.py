"""The frames of a video file."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import cv2

from ...core.base.errors import SourceError
from ..bags.topics import Report
from ..images.decoding import Image
from .frames import Frame, Part, Source, SourceOptions, fitting, once

_ENOUGH = 0.95  # of the frames that a file announces, which may be an estimate
_AT_ONCE = 3  # readings that go on: of what is recognised, of what is drawn, and of what is copied


class _Decoder:
    """A video file from its first frame on. :ivar number: how many frames are behind it."""

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise SourceError(f"{path}: there is no such file")
        self._video = cv2.VideoCapture(str(path.absolute()))  # 'http:x/v.mp4' would be a protocol
        if not self._video.isOpened():
            raise SourceError(f"{path}: cannot be read as a video by this OpenCV")
        self.number = 0
        self.announced = int(self._video.get(cv2.CAP_PROP_FRAME_COUNT))
        self.rate_hz = float(self._video.get(cv2.CAP_PROP_FPS))

    def decoded(self, first: int = 0) -> Iterator[tuple[int, float]]:
        """Number and time (milliseconds; 0: the file does not tell) of each frame from one on, once it is decoded."""
        while self._video.grab():
            self.number += 1
            if self.number > first:
                yield self.number - 1, self._video.get(cv2.CAP_PROP_POS_MSEC)

    def image(self) -> Image | None:
        """Of the frame that was decoded last."""
        return self._video.retrieve()[1]

    def close(self) -> None:
        self._video.release()


class VideoSource(Source):
    """Frames in their order, named by the file and their number, with the times that the file says, from 0 on.

    What lies between key frames cannot be sought for sure: to come to a frame, those before it are decoded.
    """

    def __init__(self, path: Path, options: SourceOptions, report: Report = lambda _: None) -> None:
        first = _Decoder(path)
        self._decoders = [first]
        if options.image_kind == "labels":
            raise SourceError(
                f"{path}: a video holds colours, and class images are wanted (image.kind: labels): give images or a "
                "bag, or learn colours from frames of it (image.kind: colour)"
            )
        self.path, self._options, self._report = path, options, once(report)
        self._rate_hz = first.rate_hz or options.rate_hz
        self._announced = self._seen = max(0, first.announced)
        count = self._announced or sum(1 for _ in first.decoded())  # what browsers record does not tell it
        start, stop = (None if ns is None else round(ns * 1e-9 * self._rate_hz) for ns in options.span_ns(0))
        self.count = len(range(count)[start:stop])
        self.calibrated = options.camera is not None

    def close(self) -> None:
        for decoder in self._decoders:
            decoder.close()

    @property
    def problems(self) -> list[str]:
        if self._seen >= _ENOUGH * self._announced:
            return []
        return [f"{self.path}: it ends after {self._seen} of the {self._announced} frames that it announces"]

    def __iter__(self) -> Iterator[Frame]:
        decoder = _Decoder(self.path)
        for number, stamp_ns in self._within(decoder):
            yield self._frame(decoder, number, stamp_ns)

    def parts(self, size: int) -> Iterator[Part]:
        part = Part(0, 0)
        for place, (number, _) in enumerate(self._within(_Decoder(self.path))):
            if part.count in (0, size):
                yield from [part] if part.count else []
                part = Part(place, 0, skip=number)
            part = dataclasses.replace(part, count=part.count + 1)
        yield from [part] if part.count else []

    def read(self, part: Part) -> Iterator[Frame]:
        """Parts that follow one another are decoded in one go, also where each is read twice."""
        decoder = max((d for d in self._decoders if d.number <= part.skip), key=lambda d: d.number, default=None)
        if decoder is None:
            decoder = _Decoder(self.path)
        else:
            self._decoders.remove(decoder)
        self._decoders.append(decoder)  # the one that was used last comes last
        for old in self._decoders[:-_AT_ONCE]:
            old.close()
        del self._decoders[:-_AT_ONCE]
        for number, told_ms in islice(decoder.decoded(part.skip), part.count):
            yield self._frame(decoder, number, self._stamp_ns(number, told_ms))

    def sample(self, most: int) -> list[Image]:
        """A few of its images, evenly over all of it."""
        decoder, every = _Decoder(self.path), max(1, self.count // most)
        chosen = (decoder.image() for number, _ in decoder.decoded() if number % every == 0)
        return [image for image in islice(chosen, most) if image is not None]

    def _within(self, decoder: _Decoder) -> Iterator[tuple[int, int]]:
        """Numbers and stamps (ns) of what is asked for of it."""
        start_ns, stop_ns = self._options.span_ns(0)
        stamp_ns = 0
        for number, told_ms in decoder.decoded():
            stamp_ns = self._stamp_ns(number, told_ms)
            if stop_ns is not None and stamp_ns >= stop_ns:
                return
            if stamp_ns >= start_ns:
                yield number, stamp_ns
        self._seen = decoder.number
        if line := self._options.why_none(stamp_ns * 1e-9):  # how long it lasts is known now
            self._report(f"{self.path}: {line}")

    def _stamp_ns(self, number: int, told_ms: float) -> int:
        return round(told_ms * 1e6) if told_ms > 0 else round(number * 1e9 / self._rate_hz)

    def _frame(self, decoder: _Decoder, number: int, stamp_ns: int) -> Frame:
        name, image = f"{self.path.stem}_{number:06d}", decoder.image()
        if image is None:
            return Frame(stamp_ns, name, error="this frame of the video cannot be decoded")
        return Frame(stamp_ns, name, image, fitting(self._options.camera, image, self._report, "--camera-info"))

"""The frames of a video file."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import cv2

from ...core.base.errors import SourceError, UnreadableError
from ..bags.topics import Report
from ..base.bars import bar
from ..base.yaml_files import size_of_file
from ..images.decoding import Image
from .frames import Frame, Part, Source, SourceOptions, fitting, once

_ENOUGH = 0.95  # of the frames that a file announces, which may be an estimate
_AT_ONCE = 3  # readings that go on: of what is recognised, of what is drawn, and of what is copied
_MOST_LOST = 100  # frames in a row; behind the end trying so often takes no time
_INDEXED_LAST = (".mp4", ".mov", ".m4v", ".3gp")
UNDECODABLE = "this frame of the video cannot be decoded"


class _Decoder:
    """A video file from its first frame on.

    OpenCV says of a damaged frame what it says at the end: nothing comes. Nor does the announced count, which may be an
    estimate, tell the two apart: so the next frames are tried, and one that comes shows that those before it were lost.

    :ivar number: how many frames are behind it, lost ones included. :ivar is_whole: the one given last is not lost.
    """

    def __init__(self, path: Path) -> None:
        size = size_of_file(path, SourceError)
        self._video = cv2.VideoCapture(str(path.absolute()))  # 'http:x/v.mp4' would be a protocol
        if not self._video.isOpened():
            raise UnreadableError(f"{path}: cannot be read as a video by this OpenCV{_way_out(path, size)}")
        self.number = 0
        self.announced = int(self._video.get(cv2.CAP_PROP_FRAME_COUNT))
        self.rate_hz = float(self._video.get(cv2.CAP_PROP_FPS))
        self._held: deque[tuple[float, bool]] = deque()  # times of lost frames, and of the one behind them
        self.is_whole = False
        self._told_ms = -1000 / self.rate_hz if self.rate_hz > 0 else 0.0  # of the frame before

    def decoded(self, first: int = 0) -> Iterator[tuple[int, float]]:
        """Number and time (milliseconds; 0: the file does not tell) of each frame from one on, once it is decoded."""
        while self._held or self._hold():
            told_ms, self.is_whole = self._held.popleft()
            self.number += 1
            if self.number > first:
                yield self.number - 1, told_ms

    def image(self) -> Image | None:
        """Of the frame that was decoded last; None: it is lost."""
        return self._video.retrieve()[1] if self.is_whole else None

    def _hold(self) -> bool:
        """Decode the next frame that can be; False: there is none."""
        failed = next((n for n in range(_MOST_LOST + 1) if self._video.grab()), None)
        if failed is None:
            return False
        told_ms = self._video.get(cv2.CAP_PROP_POS_MSEC)
        self._held.extend((lost_ms, False) for lost_ms in self._lost_ms(failed, told_ms))
        self._held.append((told_ms, True))
        self._told_ms = told_ms
        return True

    def _lost_ms(self, failed: int, told_ms: float) -> list[float]:
        """Times of lost frames, no more than time allows: where frames are coded in another order than shown, a packet
        that is damaged is not that of the next one, which comes all the same."""
        if told_ms <= 0 or self.rate_hz <= 0:
            return [0.0] * failed
        gap_ms = told_ms - self._told_ms
        lost = min(failed, max(0, round(gap_ms * 1e-3 * self.rate_hz) - 1))
        return [self._told_ms + gap_ms * (n + 1) / (lost + 1) for n in range(lost)]

    def close(self) -> None:
        self._video.release()


def _way_out(path: Path, size: int) -> str:
    """What to do about a file that is no video to OpenCV."""
    if not size:
        return ": it is empty; record it again"
    unfinished = ", was not finished (its index is written last)" if path.suffix.lower() in _INDEXED_LAST else ""
    return f": it is damaged{unfinished}, or holds no picture; convert it (ffmpeg -i IN OUT.mp4), or record it again"


@dataclass(frozen=True)
class Survey:
    """What a video holds. :param count: frames. :param lost: names of those that cannot be decoded."""

    images: tuple[Image, ...] = field(repr=False)
    count: int
    lost: tuple[str, ...]


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

    def survey(self, most: int) -> Survey:
        """A look at all of it. :param most: images, evenly over what is announced."""
        decoder, every = _Decoder(self.path), max(1, self.count // most)
        images, lost = list[Image](), list[str]()
        for number, _ in bar(decoder.decoded(), "reading", total=self.count, unit="frame", delay=1, leave=False):
            if not decoder.is_whole:
                lost.append(self._name(number))
            elif number % every == 0 and len(images) < most and (image := decoder.image()) is not None:
                images.append(image)
        decoder.close()
        self._seen = decoder.number
        return Survey(tuple(images), decoder.number, tuple(lost))

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
        name, image = self._name(number), decoder.image()
        if image is None:
            return Frame(stamp_ns, name, error=UNDECODABLE)
        return Frame(stamp_ns, name, image, fitting(self._options.camera, image, self._report, "--camera-info"))

    def _name(self, number: int) -> str:
        return f"{self.path.stem}_{number:06d}"

"""Videos: of overlay pictures, and such as somebody has."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.base.errors import SourceError

VIDEO_SUFFIXES = (
    ".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg", ".wmv", ".ogv", ".flv", ".3gp", ".ts", ".mts",
    ".m2ts", ".gif",
)  # fmt: skip
_SLOWEST_HZ, _FASTEST_HZ = 1.0, 60.0


class VideoWriter:
    """An MP4 (MPEG-4 part 2) whose rate is that of the first two pictures and whose size is the first one's.

    A context manager. Pictures of another size are fitted into the first one's, with dark margins.
    """

    def __init__(self, path: Path) -> None:
        self._path = path.absolute()  # FFmpeg takes the beginning of 'http:x/v.mp4' for a protocol
        self._first: tuple[int, NDArray[Any]] | None = None
        self._writer: cv2.VideoWriter | None = None
        self._size = (0, 0)

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, *_: object) -> None:
        if self._writer is None and self._first is not None:
            self._open(_SLOWEST_HZ)
        if self._writer is not None:
            self._writer.release()

    def add(self, stamp_ns: int, picture: NDArray[Any]) -> None:
        """:raises SourceError: if this OpenCV cannot write such a video."""
        if self._first is None:
            self._first = (stamp_ns, picture)
            height, width = picture.shape[:2]
            self._size = (width - width % 2, height - height % 2)  # the codec wants even sizes
            return
        if self._writer is None:
            step_ns = stamp_ns - self._first[0]
            self._open(1e9 / step_ns if step_ns > 0 else _FASTEST_HZ)
        self._write(picture)

    def _open(self, rate_hz: float) -> None:
        assert self._first is not None
        rate_hz = float(np.clip(rate_hz, _SLOWEST_HZ, _FASTEST_HZ))
        fourcc = cv2.VideoWriter.fourcc(*"mp4v")
        self._writer = cv2.VideoWriter(str(self._path), fourcc, rate_hz, self._size)
        if not self._writer.isOpened():
            raise SourceError(f"{self._path}: this OpenCV cannot write MP4 videos; use --no-video")
        self._write(self._first[1])

    def _write(self, picture: NDArray[Any]) -> None:
        assert self._writer is not None
        width, height = self._size
        factor = min(width / picture.shape[1], height / picture.shape[0])
        if factor != 1 and (picture.shape[1] - width, picture.shape[0] - height) not in ((0, 1), (1, 0), (1, 1)):
            picture = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
        canvas = np.full((height, width, 3), 30, np.uint8)
        part = picture[:height, :width]
        canvas[: part.shape[0], : part.shape[1]] = part
        self._writer.write(canvas)

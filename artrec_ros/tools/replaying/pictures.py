"""What is made of the overlays: files, a video, a bag for each source, a recording. In the order of the frames."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import cv2

from ...core.base.errors import SourceError
from ...core.model.target import Target
from ...io.base.whole_files import write_whole
from ...io.images.video import VideoWriter
from ...io.results.journal import Recognised
from ...io.results.result_bag import ResultBag
from ...io.results.results import VIDEO_FILE
from ...io.sources.frames import Source
from .names import FRAMES_FOLDER, overlay_name
from .rerun_file import RerunFile
from .work import Drawn, Wanted

UNFINISHED = "unfinished"


@dataclass(frozen=True)
class PictureOptions:
    """What is wanted.

    :param images: overlay files of so many frames, from the first one on; None: of all.
    :param bag_storage: mcap or sqlite3: a bag for each source; None: no bags.
    """

    images: int | None = None
    video: bool = True
    bag_storage: str | None = None

    @property
    def in_order(self) -> bool:
        """Whether something needs all frames."""
        return self.video or self.bag_storage is not None


class Pictures:
    """Files, video and bags in a folder. A context manager; what is closed halfway is whole as far as it goes.

    :param check: raises SourceError where the folder is gone: another run's may have its name by then.
    :param recording: gets the frames, too.
    """

    def __init__(
        self,
        folder: Path,
        options: PictureOptions,
        sources: Sequence[Source],
        targets: Sequence[Target],
        check: Callable[[], None],
        recording: RerunFile | None = None,
    ) -> None:
        self._folder, self._options, self._sources, self._targets = folder, options, sources, targets
        self._unfinished = folder / UNFINISHED
        self._video: VideoWriter | None = None
        self._bag: ResultBag | None = None
        self._bag_number = -1
        self._check, self._recording = check, recording

    def __enter__(self) -> Pictures:
        shutil.rmtree(self._unfinished, ignore_errors=True)
        if self._options.in_order:
            self._unfinished.mkdir()
        if self._options.video:
            self._video = VideoWriter(self._unfinished / VIDEO_FILE).__enter__()
        if self._recording is not None:
            self._recording.__enter__()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            if kind is None:
                self._check()
                self._close_video()
                self._close_bag()
                if self._recording is not None:
                    self._recording.__exit__(kind)
            else:
                self._drop()
        finally:  # of what could not be finished nothing stays
            with suppress(SourceError):
                self._check()
                shutil.rmtree(self._unfinished, ignore_errors=True)

    def _drop(self) -> None:
        """Something failed, perhaps for want of room: video and bag cannot be finished either."""
        if self._video is not None:
            self._video.__exit__()
        if self._bag is not None:
            with suppress(OSError):
                self._bag.__exit__(None, None, None)

    def wanted(self, number: int, place: int, frame: Recognised) -> Wanted | None:
        """How a frame is to be drawn; None: not at all, or it is there already.

        :param number: of the frame in the replay. :param place: in its part.
        """
        png = self._options.images is None or number < self._options.images
        png = png and not self._path(number, frame).exists()
        plain, raw = self._options.in_order, self._recording is not None
        return Wanted(place, frame, png, plain, raw) if png or plain or raw else None

    def add(self, number: int, source: int, frame: Recognised, drawn: Drawn | None) -> None:
        """The frames in their order. :raises OSError, SourceError: something cannot be written."""
        self._check()
        if drawn is not None and drawn.png is not None:
            write_whole(self._path(number, frame), drawn.png)
        if self._recording is not None:
            self._recording.add(source, frame, None if drawn is None else drawn.raw)
        if drawn is None or drawn.picture is None:
            return
        if self._video is not None:
            self._video.add(frame.stamp_ns, drawn.picture)
        if self._options.bag_storage is not None:
            if source != self._bag_number:
                self._next_bag(source, self._options.bag_storage)
            assert self._bag is not None
            self._bag.add(frame, drawn.picture)

    def _path(self, number: int, frame: Recognised) -> Path:
        return self._folder / FRAMES_FOLDER / overlay_name(number, frame.frame, frame.stamp_ns)

    def _next_bag(self, source: int, storage: str) -> None:
        self._close_bag()
        path = self._unfinished / f"bag_{source}"
        self._bag = ResultBag(path, storage, self._sources[source], self._targets).__enter__()
        self._bag_number = source

    def _close_bag(self) -> None:
        if self._bag is not None:
            self._bag.__exit__(None, None, None)
            self._bag = None
            name = f"bag_{self._bag_number}"
            shutil.rmtree(self._folder / name, ignore_errors=True)
            os.replace(self._unfinished / name, self._folder / name)

    def _close_video(self) -> None:
        if self._video is None:
            return
        self._video.__exit__()
        path = self._unfinished / VIDEO_FILE
        if not path.exists():  # no frame at all
            return
        if not cv2.VideoCapture(str(path.absolute())).isOpened():  # OpenCV does not say when the disk is full
            raise SourceError(f"{self._folder / VIDEO_FILE}: cannot be written whole; make room, or use --no-video")
        os.replace(path, self._folder / VIDEO_FILE)

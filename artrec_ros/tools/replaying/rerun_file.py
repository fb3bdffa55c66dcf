"""A recording for the Rerun viewer, from `artrec replay --rerun FILE.rrd` (the extra `rerun`)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...core.base.config import ImageConfig
from ...core.base.errors import ArtrecError, SourceError
from ...core.model.target import Target
from ...io.base.whole_files import write_whole
from ...io.results.journal import Recognised
from .raw_frames import RawFrame

_APPLICATION = "artrec_replay"
_TIMELINE = "stamp"
_LEAST_DATE_NS = 10**18  # September 2001: stamps before count from the start of something


class RerunFile:
    """Frames in their order go in; when all were there, the file stands under its name. A context manager.

    Until then they are in memory, 50 to 100 kB for each of 640x480, where the viewer will hold them, too: Rerun's own
    writer of files hangs when the disk is full.

    :param sources: how many: of several, each has a path of its own, source_0, source_1, ...
    """

    def __init__(self, path: Path, image: ImageConfig, targets: Sequence[Target], sources: int = 1) -> None:
        """:raises ArtrecError: rerun-sdk is not installed. :raises SourceError: there is no such folder."""
        try:
            import rerun

            from . import rerun_layout, rerun_scene
        except ImportError as error:
            raise ArtrecError(f"--rerun: {error}; pip install 'artrec_ros[rerun]'") from error
        if not path.parent.is_dir():
            raise SourceError(f"--rerun: {path}: there is no folder {path.parent}; make it, or name another")
        self._rerun, self._words, self._layout = rerun, rerun_scene.told_in_words, rerun_layout
        self._path = path
        self._scene = rerun_scene.Scene(targets)
        self._classes = rerun_scene.class_names(image, targets)
        self._roots: list[list[str]] = [[]] if sources == 1 else [[f"source_{i}"] for i in range(sources)]
        self._shown: dict[int, set[tuple[str, ...]]] = {}
        self._ever: set[tuple[str, ...]] = set()
        self._dated: bool | None = None
        self._stream: Any = None

    def __enter__(self) -> RerunFile:
        self._stream = self._rerun.RecordingStream(_APPLICATION, recording_id=self._path.stem)
        self._stream.set_log_time_enabled(False)
        self._stream.set_log_tick_enabled(False)
        self._written = self._stream.binary_stream()
        for root in self._roots:
            self._stream.log([*root, "camera"], self._classes, static=True)
            self._stream.log(root or "/", self._rerun.ViewCoordinates.RDF, static=True)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """:raises SourceError: the file cannot be written."""
        if kind is not None:
            return
        self._stream.send_blueprint(self._layout.layout(self._roots, self._ever))
        try:
            write_whole(self._path, self._written.read())
        except OSError as error:
            raise SourceError(
                f"--rerun: {self._path}: cannot be written: {error.strerror or error}; make room, and the same command "
                "goes on"
            ) from error

    def add(self, source: int, frame: Recognised, raw: RawFrame | None) -> None:
        """The next frame. :param source: its number in the replay."""
        self._set_time(frame.stamp_ns)
        root, now = self._roots[source], set()
        for path, content in self._scene.entities(frame, raw):
            now.add((*root, *path))
            self._stream.log([*root, *path], *content)
        for gone in sorted(self._shown.get(source, set()) - now):
            self._stream.log(list(gone), self._rerun.Clear(recursive=False))
        self._shown[source] = now
        self._ever |= now
        for level, text in self._words(frame):
            self._stream.log([*root, "log"], self._rerun.TextLog(text, level=level))
            self._ever.add((*root, "log"))

    def _set_time(self, stamp_ns: int) -> None:
        """A date, or, where stamps count from a start, a duration; a timeline is one or the other throughout."""
        if self._dated is None:
            self._dated = stamp_ns >= _LEAST_DATE_NS
        if self._dated:
            self._stream.set_time(_TIMELINE, timestamp=np.datetime64(stamp_ns, "ns"))
        else:
            self._stream.set_time(_TIMELINE, duration=np.timedelta64(stamp_ns, "ns"))

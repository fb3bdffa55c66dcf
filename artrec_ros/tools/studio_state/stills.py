"""The frames of a source as files that can be looked at in any order; annotations name these files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import cv2

from ...core.base.errors import ImageError, SourceError
from ...core.geometry.camera import Camera
from ...io.base.whole_files import write_whole
from ...io.images.cameras import camera_yaml, load_camera
from ...io.images.decoding import Image, read_image
from ...io.sources.frames import Frame, SourceOptions
from ...io.sources.opening import FolderSource, holds_bag, open_sources

VIDEO_SUFFIXES = (".mp4", ".avi", ".mov", ".mkv", ".webm")
CAMERA_FILE = "camera.yaml"
_NAME_DIGITS = 19  # of a stamp in nanoseconds: names of so many digits are read as stamps again
_KEPT = 24  # frames that are kept decoded

Told = Callable[[str], None]


class Stills:
    """Some frames of a source, by their numbers.

    :ivar files: each frame's image file. :ivar stamps_ns: their stamps. :ivar camera: the calibration, where known.
    """

    def __init__(self, folder: Path, options: SourceOptions, camera: Camera | None = None) -> None:
        """:raises SourceError: the folder holds no images."""
        source = FolderSource(folder, options)
        self.stamps_ns, self.files = [t for t, _ in source.files], [p for _, p in source.files]
        self.camera = options.camera or camera
        self._kept: dict[int, Image] = {}

    def __len__(self) -> int:
        return len(self.files)

    def name(self, number: int) -> str:
        return self.files[number].name

    def number(self, path: Path) -> int | None:
        """The frame whose file this is; by its name, where the path leads elsewhere."""
        same = [n for n, own in enumerate(self.files) if own == path]
        same = same or [n for n, own in enumerate(self.files) if own.name == path.name]
        return same[0] if same else None

    def image(self, number: int) -> Image:
        """:raises ImageError: the file is damaged."""
        if number not in self._kept:
            try:
                image = read_image(self.files[number])
            except ImageError as error:
                raise ImageError(f"{self.files[number]}: {error}") from None
            while len(self._kept) >= _KEPT:
                self._kept.pop(next(iter(self._kept)))
            self._kept[number] = image
        return self._kept[number]

    def spread(self, count: int) -> list[int]:
        """So many frames, evenly over all of them."""
        most = min(count, len(self))
        return [round(i * (len(self) - 1) / max(most - 1, 1)) for i in range(most)]


def open_stills(source: Path, options: SourceOptions, most: int, folder: Path, told: Told) -> Stills:
    """The frames of a folder of images as they are; those of a bag or a video as files in `folder`.

    :param most: of a bag or a video so many frames at most, evenly over all of it. They are written once: where
        `folder` holds images already, these are taken.
    :raises SourceError: no such source, no frames in it, or the files cannot be written.
    """
    if source.is_dir() and not holds_bag(source):
        return Stills(source, options)
    if not folder.is_dir() or not any(folder.glob("*.png")):
        told(f"writing up to {most} frames of {source} to {folder}")
        try:
            _write(source, options, most, folder)
        except OSError as error:
            raise SourceError(f"{folder}: cannot be written: {error.strerror or error}") from error
    kept = folder / CAMERA_FILE
    return Stills(folder, SourceOptions(camera=options.camera), load_camera(kept) if kept.is_file() else None)


def _write(source: Path, options: SourceOptions, most: int, folder: Path) -> None:
    written = 0
    with open_sources([source], options) if source.suffix.lower() not in VIDEO_SUFFIXES else _Video(source) as frames:
        every = max(1, -(-frames.count // most))
        for number, frame in enumerate(frames):
            if number % every == 0 and frame.image is not None:
                _write_frame(frame, folder)
                written += 1
    if not written:
        raise SourceError(f"{source}: no frame of it can be used")


def _write_frame(frame: Frame, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    _, data = cv2.imencode(".png", frame.image)
    write_whole(folder / f"{max(frame.stamp_ns, 0):0{_NAME_DIGITS}d}.png", data.tobytes())
    if frame.camera is not None and not (folder / CAMERA_FILE).exists():
        write_whole(folder / CAMERA_FILE, camera_yaml(frame.camera))


class _Video:
    """A video file as `Sources` are: a context manager to be iterated once. `count`: frames to expect."""

    def __init__(self, path: Path) -> None:
        self._path, self._video = path, cv2.VideoCapture(str(path))
        if not path.is_file():
            raise SourceError(f"{path}: there is no such file")
        if not self._video.isOpened():
            raise SourceError(f"{path}: cannot be read as a video by this OpenCV")
        self.count = max(1, int(self._video.get(cv2.CAP_PROP_FRAME_COUNT)))

    def __enter__(self) -> _Video:
        return self

    def __exit__(self, *_: object) -> None:
        self._video.release()

    def __iter__(self) -> Iterator[Frame]:
        rate = self._video.get(cv2.CAP_PROP_FPS) or 30.0
        number = 0
        while True:
            more, image = self._video.read()
            if not more:
                return
            yield Frame(round(number * 1e9 / rate), self._path.name, image)
            number += 1

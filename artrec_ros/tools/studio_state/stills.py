"""The frames of a source as files that can be looked at in any order; annotations name these files."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import cv2

from ...core.base.errors import ImageError, SourceError
from ...core.geometry.camera import Camera
from ...io.base.whole_files import write_whole
from ...io.images.cameras import camera_yaml, load_camera
from ...io.images.decoding import Image, read_image
from ...io.sources.frames import Frame, SourceOptions, fitting
from ...io.sources.opening import FolderSource, holds_bag, open_sources
from .ros import Live

FRAMES, CAMERA_FILE = "frames", "camera.yaml"
_NAME_DIGITS = 19  # of a stamp in nanoseconds: names of so many digits are read as stamps again
_KEPT = 24  # frames that are kept decoded
_PATIENCE_S = 20.0  # for a live topic's first image
_CALIBRATION_S = 1.5  # for the calibration beside it

Told = Callable[[str], None]


class Stills:
    """Some frames of a source, by their numbers.

    :ivar files: each frame's image file. :ivar stamps_ns: their stamps. :ivar camera: the calibration, where known.
    :ivar problems: lines about the source and its calibration.
    """

    def __init__(
        self, folder: Path, options: SourceOptions, camera: Camera | None = None, problems: Sequence[str] = ()
    ) -> None:
        """:raises SourceError: the folder holds no images."""
        source = FolderSource(folder, options)
        self._folder, self._camera_is_given = folder, options.camera is not None
        self.stamps_ns, self.files = [t for t, _ in source.files], [p for _, p in source.files]
        self.camera = options.camera or camera
        self.problems = list(problems)
        self._kept: dict[int, Image] = {}
        self._lock = threading.Lock()  # the page looks at frames while they are recognised in a thread

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
        with self._lock:
            if number not in self._kept:
                try:
                    image = read_image(self.files[number])
                except ImageError as error:
                    raise ImageError(f"{self.files[number]}: {error}") from None
                while len(self._kept) >= _KEPT:
                    self._kept.pop(next(iter(self._kept)))
                self._kept[number] = image
            return self._kept[number]

    def camera_of(self, number: int) -> Camera | None:
        """The calibration, where it is one for images of this frame's size. :raises ImageError: the file is damaged."""
        height, width = self.image(number).shape[:2]
        return self.camera if self.camera is not None and self.camera.size == (width, height) else None

    def drop_unfit_camera(self) -> None:
        """Go without a calibration that is not for images of the first one's size, which is a problem."""
        for number in range(len(self)):
            try:
                image = self.image(number)
            except ImageError:  # told when it is looked at
                continue
            whence = "--camera-info" if self._camera_is_given else str(self._folder / CAMERA_FILE)
            if fitting(self.camera, image, self.problems.append, whence) is None:
                self.camera = None
            return

    def add(self, frame: Frame) -> int:
        """One more frame, as a file; returns its number, or that of the frame of the same stamp.

        :raises ImageError: it has no pixels, or another calibration than the frames before.
        :raises SourceError: it cannot be written.
        """
        if frame.image is None:
            raise ImageError(frame.error or "no image")
        if frame.stamp_ns in self.stamps_ns:
            return self.stamps_ns.index(frame.stamp_ns)
        if frame.camera is not None and not self._camera_is_given:
            if self.camera is not None and not self.camera.sees_as(frame.camera):
                kept = self._folder / CAMERA_FILE
                raise ImageError(f"the calibration is another one than in {kept}: begin a new sitting (-o)")
            self.camera = self.camera or frame.camera
        with _writing(self._folder):
            path = _write_frame(frame, self._folder)
        self.stamps_ns.append(frame.stamp_ns)
        self.files.append(path)
        return len(self.files) - 1

    def spread(self, count: int) -> list[int]:
        """So many frames, evenly over all of them."""
        most = min(count, len(self))
        return [round(i * (len(self) - 1) / max(most - 1, 1)) for i in range(most)]


def live_stills(live: Live, options: SourceOptions, folder: Path, told: Told) -> Stills:
    """What was taken of a live topic before, as files in `folder`; where there is none yet, its next image.

    :raises SourceError: no image comes, it cannot be used, or not be written.
    """
    if not any(folder.glob("*.png")):
        told(f"waiting for an image on {live.topic}")
        live.wait(_PATIENCE_S)
        end_s = time.monotonic() + _CALIBRATION_S
        while (frame := live.frame(live.held()[-1])).camera is None and time.monotonic() < end_s:
            time.sleep(0.1)
        if frame.image is None:
            raise SourceError(f"--topic {live.topic}: {frame.error}")
        with _writing(folder):
            _write_frame(frame, folder)
    return _of_files(folder, options)


def _of_files(folder: Path, options: SourceOptions, problems: Sequence[str] = ()) -> Stills:
    """Those written before."""
    kept = folder / CAMERA_FILE
    camera = load_camera(kept) if kept.is_file() else None
    stills = Stills(folder, SourceOptions(camera=options.camera), camera, problems)
    stills.drop_unfit_camera()
    return stills


def is_folder_of_images(source: Path) -> bool:
    """Whether frames are looked at where they lie."""
    return source.is_dir() and not holds_bag(source)


def open_stills(source: Path, options: SourceOptions, most: int, folder: Path, told: Told) -> Stills:
    """The frames of a folder of images as they are; those of a bag or a video as files in `folder`.

    :param most: of a bag or a video so many frames at most, evenly over all of it. They are written once: where
        `folder` holds images already, these are taken.
    :raises SourceError: no such source, no frames in it, or the files cannot be written.
    """
    if is_folder_of_images(source):
        stills = Stills(source, options)
        stills.drop_unfit_camera()
        return stills
    problems = list[str]()
    if not folder.is_dir() or not any(folder.glob("*.png")):
        told(f"writing up to {most} frames of {source} to {folder}")
        with _writing(folder):
            problems = _write(source, options, most, folder)
    return _of_files(folder, options, problems)


@contextmanager
def _writing(folder: Path) -> Iterator[None]:
    """:raises SourceError: the folder cannot be written."""
    try:
        yield
    except OSError as error:
        raise SourceError(f"{folder}: cannot be written: {error.strerror or error}") from error


def _write(source: Path, options: SourceOptions, most: int, folder: Path) -> list[str]:
    """:return: what is wrong with the source."""
    written, problems = 0, list[str]()
    with open_sources([source], options, problems.append) as frames:
        every = max(1, -(-frames.count // most))
        for number, frame in enumerate(frames):
            if number % every == 0 and frame.image is not None:
                _write_frame(frame, folder)
                written += 1
        problems += frames.problems
    if not written:
        raise SourceError(f"{source}: no frame of it can be used")
    return problems


def _write_frame(frame: Frame, folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    _, data = cv2.imencode(".png", frame.image)
    path = folder / f"{max(frame.stamp_ns, 0):0{_NAME_DIGITS}d}.png"
    write_whole(path, data.tobytes())
    if frame.camera is not None and not (folder / CAMERA_FILE).exists():
        write_whole(folder / CAMERA_FILE, camera_yaml(frame.camera))
    return path

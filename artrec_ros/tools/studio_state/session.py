"""One sitting: the frames, the parameter file as it now is, and what the recogniser makes of the frames with it."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.base import kernel_cache
from ...core.base.config import ImageConfig
from ...core.drawing import class_picture, draw_result
from ...core.image.segmentation import Segmenter
from ...core.model.frame_result import FrameResult
from ...core.recognizer import Recognizer
from ...io.base.shared_files import resolve_path
from ...io.base.whole_files import save_file
from ...io.parameters.parameter_file import Setup, load_parameters, setup_from_flat
from ...io.parameters.sections import read_files
from ...io.sources.frames import Frame
from ..tuning.parameter_text import tuned_text
from .stills import Stills

PARAMETERS_FILE = "params.yaml"
_KEPT = 400  # results that are kept
_RECOGNISERS = 3  # that are kept: the saved parameters', those being tried, the ones before


@dataclass
class Session:
    """What all pages share. What is learned and changed goes to `folder`, as files that the commands read.

    :param given: the parameter files as the user named them.
    :param setup: the parameters as they are now, saved in `folder` where they differ from `given`.
    :ivar compiled: the share of the code that is compiled, while an image waits for the rest; None: none does.
    """

    stills: Stills
    folder: Path
    given: tuple[Path, ...]
    setup: Setup
    compiled: float | None = None
    _warned: str = ""
    _results: dict[tuple[str, int], FrameResult] = field(default_factory=dict)
    _recognizers: dict[str, Recognizer] = field(default_factory=dict)
    _lock: threading.RLock = field(default_factory=threading.RLock)

    @property
    def parameters(self) -> Path:
        """The parameter file that holds what was made here."""
        return self.folder / PARAMETERS_FILE

    @property
    def names(self) -> list[str]:
        return [t.name for t in self.setup.targets]

    @property
    def warnings(self) -> list[str]:
        """Lines about what all that is found here suffers from: doubts about the calibration, and the compiler."""
        return [*self.stills.problems, *filter(None, [self._warned])]

    def keep(self, changes: Mapping[str, Any]) -> None:
        """Changes parameters (flat name -> value) and writes the file.

        :param changes: names of files as from `folder`. :raises ConfigError: they are not valid, or it is not writable.
        """
        with self._lock:  # what is learned in a thread and what is saved by hand come one after the other
            self._keep(changes)

    def _keep(self, changes: Mapping[str, Any]) -> None:
        absolute = {k: str(self.folder / v) if k.endswith("_file") else v for k, v in changes.items()}
        setup = self.setup.changed(absolute)
        first = not self.parameters.exists()
        paths = list(self.given) if first else [self.parameters]
        note = f"Written by artrec studio, from {', '.join(p.name for p in self.given)}." if first else ""
        save_file(self.parameters, tuned_text(paths, setup, changes, self.parameters, note))
        self.setup = load_parameters(self.parameters)  # files that it names may be others now
        self.forget()

    def recognise(self, number: int, setup: Setup | None = None) -> FrameResult:
        """What is found in a frame; with other parameters than the session's, where given.

        :raises ArtrecError: the image cannot be used.
        """
        setup = setup or self.setup
        key = setup.to_yaml()
        with self._lock:
            if (key, number) not in self._results:
                camera = self.stills.camera_of(number)
                recognizer = self._recognizer(key, setup, camera is not None)
                result = recognizer.recognize(self.stills.image(number), camera)
                while len(self._results) >= _KEPT:
                    self._results.pop(next(iter(self._results)))
                self._results[key, number] = result
            return self._results[key, number]

    def take(self, frame: Frame) -> int:
        """One more frame of a live topic; its number. The first one with a calibration lends it to all.

        :raises ArtrecError: it cannot be used, or not be written.
        """
        before = self.stills.camera
        number = self.stills.add(frame)  # the page does not wait for what is being recognised
        if self.stills.camera is not before:
            self.forget()
        return number

    def known(self, numbers: Iterable[int]) -> dict[int, FrameResult]:
        """What was found in these frames with the parameters as they are, where that is known already."""
        key = self.setup.to_yaml()
        with self._lock:
            return {n: self._results[key, n] for n in numbers if (key, n) in self._results}

    def _recognizer(self, key: str, setup: Setup, calibrated: bool) -> Recognizer:
        """Ready for an image. Whoever has the compiler begin, it is every window's to tell."""
        self._warned = self._warned or kernel_cache.switched_off()
        try:
            if key not in self._recognizers:
                made = setup.build(calibrated=calibrated, told=self._compiling)
                while len(self._recognizers) >= _RECOGNISERS:
                    self._recognizers.pop(next(iter(self._recognizers)))
                self._recognizers[key] = made
            self._recognizers[key].get_ready(calibrated, self._compiling)
        finally:
            if self.compiled is not None:  # a full folder may have refused the last of it
                self._compiling(1.0)
            self.compiled = None
        return self._recognizers[key]

    def _compiling(self, share: float) -> None:
        self.compiled, self._warned = share, kernel_cache.problem()

    def forget(self) -> None:
        """Files that parameters name have changed: what was found with them is found anew."""
        with self._lock:
            self._results.clear()
            self._recognizers.clear()

    def overlay(self, number: int, result: FrameResult) -> NDArray[np.uint8]:
        """(H, W, 3) BGR a result drawn over its frame, as a replay draws it."""
        return draw_result(self.stills.image(number), result, self.names, self.stills.camera_of(number))

    def picture(self, number: int) -> NDArray[np.uint8]:
        """(H, W, 3) BGR a frame as it is looked at: class numbers as colours."""
        image = self.stills.image(number)
        return class_picture(image) if image.ndim == 2 else image


class ClassPictures:
    """What class each pixel gets, each class in the colour that it is named after.

    :param image: how images are read.
    """

    def __init__(self, image: ImageConfig) -> None:
        self._segmenter, self._classes = Segmenter(image), image.named_labels

    def of(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """(H, W, 3) BGR."""
        return class_picture(self._segmenter.labels(image), self._classes)


def load_setup(given: tuple[Path, ...], folder: Path) -> Setup:
    """The set-up to begin with: what an earlier sitting left in `folder`, else the given files'.

    Constraint files that are yet to be learned need not be there.
    """
    kept = folder / PARAMETERS_FILE
    paths = (kept,) if kept.is_file() else given
    flat, base, source = read_files(*paths)
    known = {
        k: v
        for k, v in flat.items()
        if not (k.endswith(".constraint_file") and v and not resolve_path(v, base).is_file())
    }
    return setup_from_flat(known, base, source)

"""Pictures as files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2

from ...core.base.errors import ConfigError
from ..base.whole_files import save_file
from .decoding import Image


def save_picture(path: Path, picture: Image, options: Sequence[int] = ()) -> None:
    """In the form that the name's end tells, whole or not at all. :param options: OpenCV's, of that form.

    :raises ConfigError: there is no such form, or the file cannot be written.
    """
    try:
        done, data = cv2.imencode(path.suffix, picture, list(options))
    except cv2.error:
        done = False
    if not done:
        raise ConfigError(f"{path}: '{path.suffix}' cannot hold this picture; let the name end in .png")
    save_file(path, data.tobytes())

"""What the files of a replay are called; those of overlays after the frames that they show."""

from __future__ import annotations

import os
from pathlib import Path

from ...io.images.decoding import IMAGE_SUFFIXES

FRAMES_FOLDER, PARAMETERS_FILE = "frames", "parameters.yaml"
_LONGEST_STEM = 200  # bytes: file systems allow 255 for a name


def overlay_name(number: int, frame: str, stamp_ns: int) -> str:
    """A file's name: the frame's number in the replay, and the image's own name or, of a bag, its stamp.

    Names are unique, and sorted in the order of the frames, however many sources there are.

    :param frame: the bag's topic, or the file's name, as in `FrameRecord`.
    """
    path = Path(frame)
    own = path.stem if path.suffix.lower() in IMAGE_SUFFIXES else str(stamp_ns)
    return f"{number:06d}_{os.fsdecode(os.fsencode(own)[:_LONGEST_STEM])}.png"

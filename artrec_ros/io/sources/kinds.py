"""What can be no source, by its name, and what to do instead."""

from __future__ import annotations

import re
from pathlib import Path

from ...core.base.errors import SourceError
from ..bags.metadata import BAG_SUFFIXES, is_storage
from ..images.decoding import IMAGE_SUFFIXES
from ..images.video import VIDEO_SUFFIXES

KINDS = (
    f"a bag ({', '.join(BAG_SUFFIXES)}), a video ({', '.join(VIDEO_SUFFIXES)}) or a folder of images "
    f"({', '.join(IMAGE_SUFFIXES)})"
)
_ADDRESS = re.compile(r"([a-z][a-z0-9+.-]+):/+", re.IGNORECASE)  # of a drive there is one letter


def check_not_live(path: Path) -> None:
    """:raises SourceError: a camera, or an address, of whose slashes a path keeps one."""
    named = _ADDRESS.match(str(path)) or str(path).startswith("/dev/video")
    if path.is_char_device() or (named and not path.exists()):
        told = _ADDRESS.sub(r"\1://", str(path), count=1)
        raise SourceError(
            f"{told}: is no file: live images go to the node, by the topic of a camera's driver; or record them "
            "(download them) first, and give the file"
        )


def check_kind(path: Path) -> None:
    """:raises SourceError: a file that is none of a source's kinds, or a live source."""
    check_not_live(path)
    suffix = path.suffix.lower()
    if not path.is_file() or is_storage(path) or suffix in VIDEO_SUFFIXES:
        return
    if suffix in IMAGE_SUFFIXES:
        raise SourceError(f"{path}: is an image; give the folder that it lies in, or one of its own")
    raise SourceError(f"{path}: '{suffix or path.name}' is no source: {KINDS} is wanted")

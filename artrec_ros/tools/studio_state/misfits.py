"""What of annotation files fits no frame or no object: told, for it is neither shown nor scored."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from ...io.learned.annotations import Annotations
from .stills import Stills


def misfits(named: str, known: Annotations, images: Sequence[Path], stills: Stills) -> Iterator[str]:
    """A line for each thing. :param named: the files. :param images: theirs."""
    for name, count in known.bare.items():
        if count:
            yield (
                f"{named}: category '{name}' has no keypoints COMPONENT/MARKER.tail and .head: its {count} annotations "
                "are passed over"
            )
    strange = [image for image in images if stills.number(image) is None]
    if strange and len(strange) == len(images):
        yield none_in_common(named, images, stills)
    elif strange:
        yield (
            f"{named}: {len(strange)} of its {len(images)} images, such as '{strange[0].name}', are none of the "
            "frames: their examples are learned from, but not shown"
        )


def none_in_common(named: str, images: Sequence[Path], stills: Stills) -> str:
    """That not one image is a frame."""
    return (
        f"{named}: no image of it ({len(images)}, such as '{images[0].name}') is one of the frames ({len(stills)}, "
        f"such as '{stills.name(0)}'); annotated images go by file name: give the folder that was annotated as SOURCE"
    )

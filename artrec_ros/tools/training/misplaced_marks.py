"""Annotations that cannot be of the images that they name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ...core.base.errors import ImageError
from ...io.images.decoding import size_of_image
from ...io.learned.annotations import AnnotatedObject

_FAR = 0.1  # of the image's size: marks that lie so far beyond its border are no ends of markers that it cuts


def misplaced(annotated: Sequence[AnnotatedObject]) -> Iterator[str]:
    """A line on marks far outside their images, and one on images that have another size than the file says."""
    far = [o for o in annotated if o.size is not None and _reaches_far_out(o, o.size)]
    if far:
        width, height = far[0].size or (0, 0)
        yield (
            f"warning: {far[0].place}: marks lie far outside its image of {width}x{height}, and so in {len(far)} of "
            f"{len(annotated)} annotations: are these the marks, or the size, of another image?"
        )
    claimed = {o.image: o.size for o in annotated if o.size is not None}
    wrong = [(image, size, real) for image, size in claimed.items() if (real := _size_of(image)) not in (None, size)]
    if wrong:
        image, size, real = wrong[0]
        assert real is not None
        yield (
            f"warning: {image}: has {real[0]}x{real[1]} pixels; its COCO file says {size[0]}x{size[1]}, and so of "
            f"{len(wrong)} of {len(claimed)} images: what is marked may lie elsewhere"
        )


def _reaches_far_out(annotated: AnnotatedObject, size: tuple[int, int]) -> bool:
    most, points = np.array(size), np.reshape([*annotated.points.values()], (-1, 2))
    return bool(((points < -_FAR * most) | (points > (1 + _FAR) * most)).any())


def _size_of(image: Path) -> tuple[int, int] | None:
    """None: it is not there, or cannot be read; training needs no pixels."""
    try:
        return size_of_image(image)
    except ImageError:
        return None

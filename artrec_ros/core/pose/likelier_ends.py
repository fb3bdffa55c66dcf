"""Objects that face the camera told with the ends of their long markers where these likeliest are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .laid_otherwise import LaidOtherwise, told_likelier
from .poses import Poses


def likelier_ends(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]
) -> tuple[Poses, Sequence[LaidOtherwise | None], Sequence[LaidOtherwise | None]]:
    """As `likelier_laid`, of poses at rest whose ends may be elsewhere, see `OtherEnds`."""
    found: list[LaidOtherwise | None] = [None] * len(poses)
    ends = finder.other_ends
    if ends is not None and ends.may_be:
        for h in range(len(poses)):
            if not frame.deadline.expired:
                others = LaidOtherwise(*ends.of(frame.unhurried(), poses[h : h + 1], used[h]))
                found[h] = others if len(others.poses) else None
    return told_likelier(poses, found)

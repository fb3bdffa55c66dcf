"""Which hypotheses of objects that are one marker go on: those that all their pixels bear out.

Votes look at a few points of a marker. A climb on these leads from where it lies to a larger scale, over a notch, or
round a ring to where its gap is hit by none of them; what is left out of a large one's contours no fit brings back.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .geometry.projection import project
from .geometry.transforms import Array
from .image.image_frame import ImageFrame
from .pose.differing import MarkerPixels, differing_odds
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses

_Rows = NDArray[np.int64]


class FacingLone:
    """One target's."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, self._pixels = finder, MarkerPixels(finder.surface)

    def worth(self, frame: ImageFrame, poses: Poses) -> Array:
        """(H,) pixels that speak for hypotheses."""
        return self._pixels.own(frame, poses)

    def told_apart(self, frame: ImageFrame, poses: Poses, few: _Rows, best: _Rows) -> _Rows:
        """Indices of hypotheses that are the best of their places by all their pixels, and of those with many votes
        that the pixels in which these differ from them do not refute: of a small marker votes see as much.

        :param few: with many votes. :param best: by all pixels, one of each place.
        """
        if not len(few) or not len(best):
            return few
        at = project(frame.camera, self._finder.required.anchors(poses))
        there = np.linalg.norm(at[few, None] - at[best], axis=2).argmin(axis=1)
        kept = [best]
        for n, row in enumerate(best.tolist()):
            mine = few[(there == n) & (few != row)]
            odds = differing_odds(self._finder, frame, poses[np.append(row, mine)])[0, 1:]
            kept.append(mine[odds < self._finder.config.verdict.least_turn_odds])
        return np.concatenate(kept)

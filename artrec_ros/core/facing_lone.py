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
from .pose.differing import MarkerPixels, odds_among
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .pose.slants import Slants
from .verdict.acceptance import verdicts_of
from .verdict.claims import claims_of

_Rows = NDArray[np.int64]


class FacingLone:
    """One target's."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, self._pixels = finder, MarkerPixels(finder.surface)
        self._slants = Slants(finder.surface, finder.config)

    def worth(self, frame: ImageFrame, poses: Poses) -> Array:
        """(H,) pixels that speak for hypotheses."""
        return self._pixels.own(frame, poses)

    def slanted(self, frame: ImageFrame, poses: Poses) -> Poses:
        """Slants of those of some poses that face the camera and are no objects so, which they refute, by pixels, votes
        and contours together: an outline that is drawn by eye is off, too, and a slant would explain that. What lies in
        a known plane has none."""
        config, faces = self._finder.config, np.isclose(np.abs(poses.R[:, 2, 2]), 1.0)
        if frame.scene.plane is not None or frame.deadline.expired:
            return poses[:0]
        probability = verdicts_of(claims_of(self._finder, poses, frame)).probability
        facing = poses[np.flatnonzero(faces & (probability < config.min_probability))]
        slanted, of = self._slants.of(frame, facing)
        slanted = self._finder.climber.within_limits(frame.camera, slanted)
        worth, kept = self.worth(frame, slanted), [poses[:0]]
        for n in np.unique(of).tolist():
            mine = np.flatnonzero(of == n)
            best = slanted[mine[[int(worth[mine].argmax())]]]
            (odds,) = odds_among(self._finder, frame, Poses.concatenate([facing[n : n + 1], best]))
            if odds > config.verdict.least_turn_odds:
                kept.append(best)
        return Poses.concatenate(kept)

    def told_apart(self, frame: ImageFrame, poses: Poses, few: _Rows, best: _Rows) -> _Rows:
        """Indices of hypotheses that are the best of their places by all their pixels, and of those with many votes
        that these do not refute, by pixels, votes and contours together, as turns are told: what touches an object, or
        pixels astray, are most in one that is too large, which few votes and no contours bear out.

        :param few: with many votes. :param best: by all pixels, one of each place.
        """
        if not len(few) or not len(best):
            return few
        at = project(frame.camera, self._finder.required.anchors(poses))
        there = np.linalg.norm(at[few, None] - at[best], axis=2).argmin(axis=1)
        kept = [best]
        for n, row in enumerate(best.tolist()):
            mine = few[(there == n) & (few != row)]
            if len(mine) and not frame.deadline.expired:
                odds = odds_among(self._finder, frame, poses[np.append(row, mine)])
                mine = mine[odds > -self._finder.config.verdict.least_turn_odds]
            kept.append(mine)
        return np.concatenate(kept)

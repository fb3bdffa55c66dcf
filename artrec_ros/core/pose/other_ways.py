"""Another way to bend an object that has all that is seen of it where it is.

A part between two others that is not seen, as a knee behind a rail, may lie on either side of the line between these:
nothing in the image tells, unless limits of joints do. No derivative knows of the other side, and what a search found
first is told. So the other ways through the middles of what is seen are sought, and compared as mirrored turns are.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from ..geometry.projection import project
from ..geometry.transforms import Array, short_way
from ..image.image_frame import ImageFrame
from ..model.found import OtherTurn
from .finder import WholeObjectFinder
from .other_turns import other_of
from .poses import Poses
from .rivals import ANY_DEPTH
from .through_middles import Middles
from .turn_evidence import turn_odds, weighed

LEAST_BEND = 0.1  # radians, or units of what slides: ways that are nearer to each other are one


class OtherWays:
    """Those of one target's objects."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, self._kin = finder, finder.surface.kinematics
        self._through = finder.through_middles

    def of(
        self, frames: Sequence[ImageFrame], poses: Poses, seen: Sequence[Collection[int]], used: NDArray[np.bool_]
    ) -> list[OtherTurn | None]:
        """Of each of H poses at rest the likeliest other way, where it may be the true one; as likely at most.

        :param frames: in which each is looked at. :param seen: of each the components that are.
        :param used: (H, M) markers that the labels support.
        """
        out = list[OtherTurn | None]()
        for h, frame in enumerate(frames):
            patches = self._finder.surface.markers[used[h]]
            open_ = self._leaves_open(seen[h]) and not frame.deadline.expired and len(patches)
            out.append(self._other(frame, poses[h : h + 1], patches, self._moving(seen[h])) if open_ else None)
        return out

    def _leaves_open(self, seen: Collection[int]) -> bool:
        """Whether something that is seen hangs on what is not, by joints that bend."""
        if not self._moving(seen).any():
            return False
        parents = [self._kin.parent[c] for c in seen]
        while any(p >= 0 for p in parents):
            if any(p >= 0 and p not in seen for p in parents):
                return True
            parents = [self._kin.parent[p] for p in parents if p >= 0]
        return False

    def _moving(self, seen: Collection[int]) -> NDArray[np.bool_]:
        """(J,) which joints move something that is seen: of the others nothing in the image speaks."""
        return np.asarray(self._kin.moves[list(seen)].any(axis=0) & (self._kin.upper > self._kin.lower))

    def _other(
        self, frame: ImageFrame, pose: Poses, patches: NDArray[np.int64], moving: NDArray[np.bool_]
    ) -> OtherTurn | None:
        finder, frame = self._finder, frame.unhurried()
        at = self._through.places(pose, patches)[0]
        middles = Middles(patches, project(frame.camera, at), frame.camera.focal_px / at[:, 2])
        ways = finder.climber.within_limits(frame.camera, self._through.of(frame.camera, pose, middles))
        ways = self._apart(ways, pose, moving)
        if not len(ways):
            return None
        ways = finder.refit.of(frame, ways, ANY_DEPTH).poses[len(ways) :]
        ways = finder.rest.at_rest(frame, ways, finder.voter.supports(frame, ways))
        told = finder.voter.votes(frame, pose, occlusion=True)
        may_be = finder.voter.votes(frame, ways, occlusion=True) > self._least(told)
        ways = ways[np.flatnonzero(may_be & frame.scene.stand(ways.R, ways.t))]
        ways = self._apart(ways, pose, moving)
        if not len(ways):
            return None
        odds = turn_odds(finder, frame, pose[np.zeros(len(ways), int)], ways)
        best = int(np.argmax(odds))
        probability = float(weighed(np.minimum(odds[best : best + 1], 0.0), 0.0)[1][0])
        return other_of(finder, Poses.concatenate([pose, ways]), 0, 1 + best, probability)

    def _least(self, told: Array) -> float:
        return float(self._finder.config.verdict.mirrored_votes * told[0])

    def _apart(self, ways: Poses, pose: Poses, moving: NDArray[np.bool_]) -> Poses:
        """Those of some that are bent otherwise, by joints that are `moving` what is seen (J,)."""
        off = np.abs(short_way(ways.q - pose.q, self._kin.endless)) / self._kin.unit
        return ways[np.flatnonzero((off > LEAST_BEND)[:, moving].any(axis=1))]

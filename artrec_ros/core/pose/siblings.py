"""Which of like components one is that is seen, where what carries it is not.

Of two arms whose upper halves are hidden either fore-arm may be the left one's or the right one's; where one alone is
seen, it may be the other one's that is not. A search keeps what it found first. So the others are laid in its place,
by the middles of all that is seen, brought to rest, and compared with it as mirrored turns are.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ..geometry.projection import project
from ..geometry.spread import spread
from ..geometry.transforms import Array, short_way
from ..image.image_frame import ImageFrame
from .along_joints import Bent
from .exchanges import may_be_taken_for
from .finder import WholeObjectFinder
from .poses import Poses
from .through_middles import Middles
from .turn_evidence import even_odds

_STARTS = 6  # bends of the joints that carry what is laid otherwise
_MOST = 4  # ways of an object that are looked at: each takes some milliseconds

_Pairs = list[tuple[int, int]]  # rows of markers: one that is to be laid where another one is seen


class Siblings:
    """Those of one target's objects."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, surface, self._kin = finder, finder.surface, finder.surface.kinematics
        self._component = surface.component[surface.markers]
        like = may_be_taken_for(surface, surface.markers) & surface.compiled.like
        self._like = [np.flatnonzero(row).tolist() for row in like]  # of each marker those that may be it

    def of(
        self, frames: Sequence[ImageFrame], poses: Poses, seen: Sequence[Collection[int]], used: NDArray[np.bool_]
    ) -> list[Bent]:
        """Of H poses at rest. :param frames: in which each is looked at. :param seen: of each the components that are.
        :param used: (H, M) markers that the labels support."""
        each = enumerate(zip(frames, seen, used, strict=True))
        return [self._of_one(frame, poses[h : h + 1], mine, row) for h, (frame, mine, row) in each]

    def _of_one(self, frame: ImageFrame, pose: Poses, seen: Collection[int], used: NDArray[np.bool_]) -> Bent:
        stays, variance = dict[str, float](), dict[str, float]()
        if not any(self._like) or frame.deadline.expired:
            return Bent(stays, variance)
        frame = frame.unhurried()
        shown = {c: int(rows[0]) for c in seen if len(rows := np.flatnonzero(used & (self._component == c)))}
        doubts = list[tuple[set[int], float, Array]]()
        for n, laid in enumerate(self._ways(shown)):
            if n == _MOST:
                break
            other = self._laid(frame, pose, shown, laid)
            if len(other):
                odds = float(even_odds(self._finder, frame, pose, other)[0])
                bent = short_way(other.q[0] - pose.q[0], self._kin.endless)
                doubts.append(({self._of(there) for _, there in laid}, float(np.exp(min(odds, 0.0))), bent))
        names, joints = [c.name for c in self._finder.surface.model.components], self._finder.surface.model.joint_names
        for c in set().union(*(lies for lies, _, _ in doubts)) if doubts else ():
            mine = [(worth, bent) for lies, worth, bent in doubts if c in lies]
            total = 1 + sum(worth for worth, _ in mine)
            stays[names[c]] = 1 / total
            for j in np.flatnonzero(self._kin.moves[c]).tolist():
                off = sum(worth / total * float(bent[j]) ** 2 for worth, bent in mine)
                variance[joints[j]] = max(variance.get(joints[j], 0.0), off)
        return Bent(stays, variance)

    def _ways(self, shown: dict[int, int]) -> Iterator[_Pairs]:
        """Which markers may be where others are seen: one that is not seen, or two each in the other's place. None in
        the place of what is held by what carries it: more joints would have to be where they are by chance.

        :param shown: of each component that is seen its marker.
        """
        for c, row in shown.items():
            for other in self._like[row]:
                d = self._of(other)
                if d not in shown and self._hangs_free(c, shown):
                    yield [(other, row)]
                elif c < d and shown.get(d) == other and (self._hangs_free(c, shown) or self._hangs_free(d, shown)):
                    yield [(other, row), (row, other)]

    def _hangs_free(self, component: int, shown: Collection[int]) -> bool:
        """Whether what carries a component is not seen."""
        parent = self._kin.parent[component]
        return parent >= 0 and parent not in shown and parent != self._finder.root

    def _laid(self, frame: ImageFrame, pose: Poses, shown: dict[int, int], laid: _Pairs) -> Poses:
        """A pose at rest in which markers lie so and all others that are seen where they are; none where there is no
        such."""
        finder, surface, kin = self._finder, self._finder.surface, self._kin
        moved = {there for _, there in laid}
        stay = [row for row in shown.values() if row not in moved]
        patches = surface.markers[stay + [row for row, _ in laid]]
        at = finder.through_middles.places(pose, surface.markers[stay + [there for _, there in laid]])[0]
        middles = Middles(patches, project(frame.camera, at), frame.camera.focal_px / at[:, 2])
        mine, others_of = ([self._of(row) for row in rows] for rows in ([row for row, _ in laid], stay))
        free = np.flatnonzero(kin.moves[mine].any(axis=0) & ~kin.moves[others_of].any(axis=0))
        q = np.repeat(pose.q, _STARTS, axis=0)
        q[:, free] = kin.lower[free] + (kin.upper - kin.lower)[free] * spread(_STARTS, len(free))
        starts = Poses(np.repeat(pose.R, _STARTS, axis=0), np.repeat(pose.t, _STARTS, axis=0), q)
        others = finder.climber.within_limits(frame.camera, finder.through_middles.begun(frame.camera, starts, middles))
        if not finder.facing:
            others = others[np.flatnonzero(frame.scene.stand(others.R, others.t))]
        if not len(others):
            return others
        others = finder.rest.at_rest(frame, others, finder.voter.supports(frame, others))
        votes = finder.voter.votes(frame, Poses.concatenate([pose, others]), occlusion=True)
        best = int(np.argmax(votes[1:]))
        return others[[best] if votes[1 + best] > finder.config.verdict.mirrored_votes * votes[0] else []]

    def _of(self, row: int) -> int:
        return int(self._component[row])

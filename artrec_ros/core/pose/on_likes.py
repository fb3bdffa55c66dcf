"""Poses of an object with joints that lay its required component where it has a like one, or a like one where that is,
all joints sought anew.

One place off along a row of like parts, or from a chain's other end, joints bend the others to where they are seen for
all that: a search that comes to such a pose finds nothing better near it.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .exchanges import OFF, may_be_taken_for
from .lookalikes import Lookalikes
from .poses import Poses
from .ranked import Ranked

if TYPE_CHECKING:
    from .finder import WholeObjectFinder


_NUMBERS = 1_000_000  # of distances at a time, some 32 MB


class OnLikes:
    """Those of one object. :ivar any: whether there are."""

    def __init__(self, finder: WholeObjectFinder, lookalikes: Lookalikes) -> None:
        """:param lookalikes: the object's."""
        surface, config = finder.surface, finder.config
        self._finder, self._lookalikes = finder, lookalikes.on_others()
        self.any = surface.kinematics.n_joints > 0 and len(self._lookalikes) > 0
        self._grids = surface.kinematics.grids(config.search.joint_step)
        self._most = config.facing.rivals if finder.facing else config.search.flip_keep
        self._size = np.sqrt(surface.area[surface.markers])

    def begun(self, frame: ImageFrame, pose: Poses) -> Poses:
        """A few of a pose that lacks something, the best first of each kind, as they are before a climb: what lays the
        required component on another one, and what lays another one where that is."""
        onto = self._finder.standing(frame, self._lookalikes.of(pose))
        back = self._bent_onto(frame, pose, self._finder.standing(frame, _back(pose, onto)))
        onto = Poses.concatenate([self._by_labels(frame, onto), self._bent_onto(frame, pose, onto)])
        return Poses.concatenate([self._best(frame, onto), self._best(frame, back)])

    def of(self, frame: ImageFrame, pose: Poses, seen: Collection[int]) -> Poses:
        """A few after a climb; where all components are seen those alone that look the same throughout, for others lack
        one of them.

        :param seen: components that are.
        """
        if len(seen) < len(self._finder.target.model.components):
            begun = self.begun(frame, pose)
        else:
            onto = self._by_labels(frame, self._finder.standing(frame, self._lookalikes.of(pose)))
            begun = self._best(frame, onto[np.flatnonzero(self.same(frame.camera, pose, onto))])
        if not len(begun):
            return begun
        return self._finder.looked_again(frame, begun).best(2 * self._most, self._finder.config.search).poses

    def _by_labels(self, frame: ImageFrame, poses: Poses) -> Poses:
        return self._finder.surface.search_joints(frame, poses, self._grids)

    def _best(self, frame: ImageFrame, poses: Poses) -> Poses:
        """A few by what they show: what they lack is weighed after a climb."""
        votes = self._finder.voter.borne_out(self._finder.voter.judge(frame, poses, occlusion=True))
        return Ranked(poses, votes).best(self._most, self._finder.config.search).poses

    def distinct(self, camera: Camera, pose: Poses, others: Poses, log_odds: Array) -> NDArray[np.int64]:
        """Which of K others have some marker elsewhere than a pose, and than likelier ones: else one place would count
        twice. :param log_odds: (K,)"""
        at, size_px = self.pixels(camera, Poses.concatenate([pose, others]))
        kept = [0]
        for n in (1 + np.argsort(-log_odds, kind="stable")).tolist():
            off = np.linalg.norm(at[kept] - at[n], axis=2)
            if (off > OFF * np.minimum(size_px[kept], size_px[n])).any(axis=1).all():
                kept.append(n)
        return np.array(kept[1:], np.int64) - 1

    def pixels(self, camera: Camera, poses: Poses) -> tuple[Array, Array]:
        """(H, M, 2) the middles of all markers in the image, (H, M) how large these are there."""
        at = self._finder.through_middles.places(poses, self._finder.surface.markers)
        return project(camera, at), self._size * camera.focal_px / at[..., 2]

    def _bent_onto(self, frame: ImageFrame, pose: Poses, others: Poses) -> Poses:
        """Others with each joint, parents first, where what it carries lies nearest to like markers of a pose, be these
        seen or not: beyond what is hidden a search by labels finds nothing. Those that there is time for."""
        (there,) = self._finder.through_middles.places(pose, self._finder.surface.markers)
        most = max(1, _NUMBERS // (self._grids.shape[1] * len(there) ** 2))
        parts = [self._bent_in_part(there, others[part]) for part in frame.deadline.parts(len(others), most)]
        return Poses.concatenate(parts) if parts else others[:0]

    def _bent_in_part(self, there: Array, others: Poses) -> Poses:
        """:param there: (M, 3) where a pose has its markers."""
        kin, markers, q = self._finder.surface.kinematics, self._finder.surface.markers, others.q.copy()
        most, last = self._size**2, self._last_joint
        for j in np.flatnonzero(np.bincount(last[last >= 0], minlength=kin.n_joints)).tolist():
            mine, values = np.flatnonzero(last == j), self._grids[j][~np.isnan(self._grids[j])]
            tried = np.repeat(q, len(values), axis=0)
            tried[:, j] = np.tile(values, len(q))
            rows = np.repeat(np.arange(len(q)), len(values))
            at = self._finder.through_middles.places(Poses(others.R[rows], others.t[rows], tried), markers[mine])
            off = ((at[:, :, None] - there) ** 2).sum(axis=3)
            off = np.where(self._like[mine], off, np.inf).min(axis=2)
            lost = np.minimum(off, most[mine]).sum(axis=1).reshape(len(q), -1)
            q[:, j] = values[lost.argmin(axis=1)]
        return Poses(others.R, others.t, q)

    @cached_property
    def _last_joint(self) -> NDArray[np.int64]:
        """(M,) the last of the joints that move each marker; -1: none."""
        moves = self._finder.surface.kinematics.moves[self._finder.surface.component[self._finder.surface.markers]]
        return np.where(moves.any(axis=1), moves.shape[1] - 1 - moves[:, ::-1].argmax(axis=1), -1)

    @cached_property
    def _like(self) -> NDArray[np.bool_]:
        """(M, M) which markers may be taken for each other."""
        return may_be_taken_for(self._finder.surface, self._finder.surface.markers)

    def same(self, camera: Camera, pose: Poses, others: Poses) -> NDArray[np.bool_]:
        """(K,) whether others have each marker, seen or not, on a like one of a pose: nothing hidden tells these from
        it."""
        pixels, size_px = self.pixels(camera, Poses.concatenate([pose, others]))
        off = np.linalg.norm(pixels[1:, :, None] - pixels[0], axis=3)  # (K, M, M)
        near = off < OFF * np.minimum(size_px[1:, :, None], size_px[0])
        return np.asarray((near & self._like).any(axis=2).all(axis=1))


def _back(pose: Poses, others: Poses) -> Poses:
    """(K,) a pose moved as each of K others is moved from it, but the other way: where these lay the required component
    on another one, another one comes to lie where it is."""
    R = others.R @ pose.R[0].T
    t = others.t - R @ pose.t[0]
    back = R.swapaxes(1, 2)
    return Poses(back @ pose.R[0], np.einsum("kij,kj->ki", back, pose.t[0] - t), others.q)

"""Other components that explain what is taken for the required one better than it does.

A chain whose head is hidden shows links alone: the head laid on one of them is an object that is not there. Of what
the labels show in one place the component whose marker fits it best is the likelier one, if the object can lie so that
the rest of it explains as much.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from ..geometry.transforms import Array, Pose, rotation_from_rotvec
from ..image.image_frame import ImageFrame
from ..model.marker import Marker
from ..model.surface import Patch
from .layout import middle_of
from .lookalikes import turns_alike
from .poses import Poses
from .surface_model import SpatialModel

_TURNS = 2 * np.pi * np.arange(8) / 8  # in which another marker is laid there,
_SHIFTS = 0.1 * np.arange(-3, 4)  # and how far off, along both axes, as a share of the root of the area


class StandIns:
    """One object's: components of the required one's class, with markers that look otherwise, that joints may bring
    where it seems to be."""

    def __init__(self, surface: SpatialModel, grids: Array, share: float) -> None:
        """:param grids: (J, n) values of joints, see `Kinematics.grids`.
        :param share: see `VerdictConfig.stand_in`.
        """
        self._surface, self._grids, self._share = surface, grids, share
        self._others = {p: self._unlike(p) for p in surface.markers_of[surface.root]}
        turns, u, v = np.array(list(product(_TURNS, _SHIFTS, _SHIFTS))).T
        self._R = np.array([rotation_from_rotvec([0.0, 0.0, turn]) for turn in turns])  # (K, 3, 3)
        self._shift = np.column_stack([u, v, np.zeros(len(u))])  # (K, 3)

    def better(self, frame: ImageFrame, poses: Poses, patch: int, votes: float, area_px: float) -> int | None:
        """The component whose marker in this place of one hypothesis has the most votes, where these are more than
        those of the required component's own, all in all and of a pixel (a larger one has more where it lies across
        two), and the object's other components find their labels then, too; None: there is none.

        :param patch: its marker, one of the surface's patches. :param votes, area_px: of it.
        """
        others, best, most, of_all = self._others[patch], None, votes, None
        scale = self._scale(frame, poses, patch) if others else 0.0
        for other in others:
            if self._most_votes(other, scale) <= most:
                continue
            there = self._laid_on(poses, patch, other)
            said = self._surface.score(frame, there, np.array([other]), occlusion=False)
            fits = said.votes * max(area_px, 1.0) > said.area_px * votes
            found = np.where(fits, said.votes, -np.inf)[:, 0]
            turned = found.reshape(len(_TURNS), -1)
            each = turned.argmax(axis=1) + np.arange(len(_TURNS)) * turned.shape[1]
            each = each[found[each] > most]
            if not len(each):
                continue
            if of_all is None:
                of_all = float(self._explained(frame, poses).max())
            c = int(self._surface.component[other])
            rest = self._explained(frame, self._bent(frame, there[each], c), self._surface.root)
            if rest.max() > self._share * of_all:
                best, most = c, float(found[each].max())
        return best

    def _bent(self, frame: ImageFrame, poses: Poses, component: int) -> Poses:
        """Hypotheses with the joints that do not carry a component where the labels like theirs best."""
        carried = self._surface.kinematics.moves[component]
        found = []
        for h in range(len(poses)):
            grids = self._grids.copy()
            grids[carried] = np.nan
            grids[carried, 0] = poses.q[h, carried]
            found.append(self._surface.search_joints(frame, poses[h : h + 1], grids))
        return Poses.concatenate(found)

    def _explained(self, frame: ImageFrame, poses: Poses, *without: int) -> Array:
        """(H,) votes for the markers of the components that have any, some left out."""
        surface = self._surface
        votes = surface.score(frame, poses, surface.markers, occlusion=False).votes
        on = surface.component[surface.markers]
        each = np.stack([votes[:, on == c].sum(axis=1) for c in range(len(surface.model.components))], axis=1)
        each[:, list(without)] = 0.0
        return np.asarray(np.maximum(each, 0.0).sum(axis=1))

    def _unlike(self, patch: int) -> list[int]:
        """Patches of markers of the same class that look otherwise, one of each kind, of components that move against
        the required one."""
        surface, out = self._surface, dict[object, int]()
        mine, moves = surface.patches[patch], surface.kinematics.moves
        for p in surface.markers.tolist():
            other, c = surface.patches[p], surface.component[p]
            moved = (moves[c] != moves[surface.root]).any()
            if moved and set(other.labels) & set(mine.labels) and not _alike(mine, other):
                out.setdefault((_marker(other).outline.tobytes(), other.labels), p)
        return list(out.values())

    def _scale(self, frame: ImageFrame, poses: Poses, patch: int) -> float:
        """Pixels per metre where one hypothesis has a marker of the required component."""
        surface = self._surface
        seen = surface.kinematics.forward(poses.R, poses.t, poses.q)
        depth = float((seen.R[0, surface.root] @ surface.centre[patch] + seen.t[0, surface.root])[2])
        return frame.camera.focal_px / max(depth, 1e-6)

    def _most_votes(self, patch: int, scale: float) -> float:
        """That a marker can have: pixels and outline all of its class, and nothing squeezes it."""
        surface, v = self._surface, self._surface.votes
        around = (v.rim[0] + v.ring[2]) * v.ring_width_px * _marker(surface.patches[patch]).perimeter * scale
        return float(v.inside[0] * surface.area[patch] * scale**2 + around)

    def _laid_on(self, poses: Poses, patch: int, other: int) -> Poses:
        """K hypotheses with another marker laid on one in all turns, a little off in all directions; joints as they
        are."""
        surface = self._surface
        kin, c = surface.kinematics, int(surface.component[other])
        # a ball lies in no plane but the one that is seen
        frames = kin.seen if surface.root in surface.sides.balls else kin.forward
        seen = frames(poses.R, poses.t, poses.q)
        at = Pose(seen.R[0, surface.root], seen.t[0, surface.root]) @ middle_of(_marker(surface.patches[patch]))
        inside = middle_of(_marker(surface.patches[other])).inverse()
        R = at.rotation @ self._R @ inside.rotation  # (K, 3, 3) frames of the component
        t = at.position + surface.area[patch] ** 0.5 * self._shift @ at.rotation.T
        t = t + (at.rotation @ self._R) @ inside.position
        own = kin.in_object(poses.q)  # its frame in the object's
        R = R @ own.R[0, c].T
        return Poses(R, t - R @ own.t[0, c], np.repeat(poses.q, len(R), axis=0))


def _marker(patch: Patch) -> Marker:
    assert patch.marker is not None  # the caller's condition
    return patch.marker


def _alike(a: Patch, b: Patch) -> bool:
    return bool(turns_alike(_marker(a), _marker(b)))

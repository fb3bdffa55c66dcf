"""In which directions an object that faces the camera is tried about its required component."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array, rotation_from_rotvec
from ..image.image_frame import ImageFrame
from .facing_guesses import FacingGuesser
from .finder import WholeObjectFinder
from .poses import Poses

_MOST = 360  # directions: more would take long; of what is so small and far out a climb makes the rest good


@dataclass(frozen=True)
class Directions:
    """An outline tells its direction, or a few, when it is laid on a blob. A disc tells none: it comes to rest where it
    is first, and then the markers around it are turned about it, each over its pixels or another one's.

    :ivar laid: in which the component is laid on its blobs. :ivar turned: in which the object is turned then; 1: none.
    :ivar kept: that go on, for each time that the component goes into its blob.
    """

    laid: int
    turned: int
    kept: int

    @classmethod
    def about_required(cls, finder: WholeObjectFinder, config: RecognizerConfig) -> Directions:
        """Of a finder of objects that face the camera."""
        facing = config.facing
        around = _angular_radii(finder) if finder.target.model.needs_another else []
        if not len(around):
            return cls(facing.turns, 1, facing.per_patch)
        turned = int(min(np.ceil(2 * np.pi / (facing.disc_step * min(around))), _MOST))
        alike = min(len(around) * (len(around) - 1), turned)  # in which a marker comes to lie where another one is
        return cls(1, turned, max(alike, facing.per_patch))

    def turn(
        self, finder: WholeObjectFinder, guesser: FacingGuesser, frame: ImageFrame, poses: Poses
    ) -> tuple[Poses, NDArray[np.int64]]:
        """Poses (H,), and these at rest on the disc's contour, in all directions; of which one each is.

        :param guesser: that laid them.
        """
        at_rest = guesser.fitted(frame, poses)
        laid = Poses.concatenate([poses, finder.climber.within_limits(frame.camera, at_rest)])
        which, middle = np.repeat(np.arange(len(laid)), self.turned), finder.required.anchors(laid)
        turns = np.zeros((self.turned, 3))
        turns[:, 2] = 2 * np.pi * np.arange(self.turned) / self.turned
        R = np.tile(rotation_from_rotvec(turns), (len(laid), 1, 1))
        arm = np.einsum("hij,hj->hi", R, (laid.t - middle)[which])
        return Poses(R @ laid.R[which], middle[which] + arm, laid.q[which]), which % len(poses)


def _angular_radii(finder: WholeObjectFinder) -> list[float]:
    """Radius of each marker around the required component's only one, radians as seen from there, where joints slide it
    farthest; but for those that a joint can turn to where they are. What reaches over the middle looks much the same in
    any direction, and wants no small steps."""
    surface, kin = finder.surface, finder.surface.kinematics
    ends = np.stack([np.where(kin.revolute, 0.0, limit) for limit in (kin.lower, kin.upper)])
    at = kin.in_object(kin.bound(ends))
    turning = (kin.moves != kin.moves[finder.root]) & kin.revolute
    middle: Array = at.R[:, finder.root] @ surface.anchor + at.t[:, finder.root]
    out = []
    for p in surface.markers:
        marker, c = surface.patches[p].marker, surface.component[p]
        assert marker is not None
        if turning[c].any():
            continue
        off = float(np.linalg.norm(at.R[:, c] @ marker.centre + at.t[:, c] - middle, axis=1).max())
        out += [marker.radius / off] if off > marker.radius else []
    return out

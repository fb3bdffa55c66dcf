"""Which markers look almost the same bent as far from the camera as towards it, and which way is mirrored.

Of a flat marker that is its normal. A ball, or a solid of one class, shows an outline alone: that is almost the same
where what reaches out from the joint leans as far from the camera, whichever of its sides are in view.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..model.objects import Joint
from ..model.solids import middle_of
from .across_kernels import Tipped

_SLIGHT = 1e-6  # a lever that is none but for rounding

if TYPE_CHECKING:
    from .surface_model import SpatialModel


def tipped_markers(surface: SpatialModel) -> tuple[NDArray[np.int64], Tipped]:
    """Rows of the markers that their component's own joint tips, not only turns in their plane or slides; and these for
    compiled code."""
    way, middle, outline = surface.normal.copy(), surface.centre.copy(), surface.sides.balls | surface.solids
    tips = np.zeros(len(surface.patches), bool)
    for c, part in enumerate(surface.model.components):
        joint, markers = part.joint, surface.markers_of[c]
        if joint is None or joint.kind != "revolute":
            continue
        if part.ball is not None:
            way[markers] = _across_reach(joint, part.ball.centre[None])
        elif c in outline:
            sides = [surface.patches[p] for p in markers]
            way[markers] = _across_reach(joint, np.concatenate([side.drawn[3:] for side in sides]))
            middle[markers] = middle_of(sides)
        tips[markers] = np.linalg.norm(np.cross(joint.axis, way[markers]), axis=1) > _SLIGHT
    rows = np.flatnonzero(tips[surface.markers])
    patch = surface.markers[rows]
    component = surface.component[patch]
    joint_of = np.array(surface.kinematics.joint_of)[component]
    return rows, Tipped(component, joint_of, way[patch], middle[patch], np.isin(component, sorted(outline)))


def _across_reach(joint: Joint, points: Array) -> Array:
    """(3,) square to a joint's axis, and to where most of points (n, 3) lie off it, by the mean of their squares; none
    where all lie on it."""
    off = points - (points @ joint.axis)[:, None] * joint.axis
    _, size, ways = np.linalg.svd(off, full_matrices=False)
    return np.asarray(np.cross(joint.axis, ways[0]) if size[0] > _SLIGHT else np.zeros(3), np.float64)

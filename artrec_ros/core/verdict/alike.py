"""Which components of an object look like one another, and what that takes from what they say of an object in space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..base.config import VerdictConfig
from ..pose.freedom import is_round, numbers_told, pose_numbers
from ..pose.surface_model import SpatialModel
from .alike_kernels import Alike

# Its place, for how far off one of several like dots is the others say as well; and a whole pose. With three of what is
# round, as at rest, where its size counts, the model is a little worse
_OF_ROUND, _OF_OTHERS = 2, 6


def alike_of(surface: SpatialModel, config: VerdictConfig, *, facing: bool) -> Alike:
    """For compiled code. What faces the camera is judged by what chance makes of an image's blobs (`chance.py`)."""
    share, power, per_number = config.mixed_up
    numbers, free = numbers_told(surface, _OF_ROUND, _OF_OTHERS), pose_numbers(facing=facing)
    like = _look_alike(surface, config.left_over_ratio)
    return Alike(numbers.astype(float), float(free), like, 0.0 if facing else share, power, per_number)


def _look_alike(surface: SpatialModel, ratio: float) -> NDArray[np.bool_]:
    """(C, C) round components of a class that both may have, of which none is so many times larger than the other, and
    each with itself: of what is not round its outline tells, too, which one it is not, and curves how well it fits."""
    size, bears = np.log(surface.sides.blobs[1][surface.markers]), surface.may_show.astype(int)
    of = surface.of_component[surface.markers]  # (M, C)
    as_large = of.T @ (np.abs(size[:, None] - size) <= np.log(ratio)) @ of
    discs = is_round(surface)
    like = (as_large > 0) & (bears @ bears.T > 0) & discs[:, None] & discs
    return np.asarray(like | np.eye(len(like), dtype=bool))

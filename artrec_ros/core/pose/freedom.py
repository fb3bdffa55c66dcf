"""How many numbers the places of components tell, and how many a pose has."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .surface_model import SpatialModel


def pose_numbers(*, facing: bool) -> int:
    """Of the pose of a rigid body: six, of what faces the camera its place, turn and scale."""
    return 4 if facing else 6


def is_round(surface: SpatialModel) -> NDArray[np.bool_]:
    """(C,) components that show nothing but discs, or are balls: no picture tells which way they are turned."""
    discs = np.array([all(m.disc_radius is not None for m in c.markers) for c in surface.model.components])
    return discs | np.isin(np.arange(len(discs)), sorted(surface.sides.balls))


def numbers_told(surface: SpatialModel, of_round: int, of_others: int) -> NDArray[np.int64]:
    """(C,) how many the marker of each component tells: of what is round, and of all else."""
    return np.where(is_round(surface), of_round, of_others)

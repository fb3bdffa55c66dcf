"""What a fit knows of an object on the scene's floor: how high it is about, and how upright.

Users say within which limits. Of what is anywhere within them, as likely here as there, height and leaning have
deviations; the fit takes them for those of normal distributions, so that it errs on the safe side within, and what an
image shows plainly, as a leap, is told as it is.
"""

from __future__ import annotations

import numpy as np

from ..base.config import FitConfig
from ..geometry.floor import Floor
from ..geometry.transforms import Array
from .floor_term_kernels import FloorTerm, add_floor_each
from .poses import Poses

_NOTHING = FloorTerm(np.zeros(3), 0.0, np.zeros(2))


def floor_term(floor: Floor | None, config: FitConfig) -> FloorTerm:
    """For compiled code. :param floor: None: none is known."""
    if floor is None:
        return _NOTHING
    weight = (config.point_sigma_px / np.array([floor.height_sigma_m, floor.leaning_sigma_rad])) ** 2
    return FloorTerm(np.ascontiguousarray(floor.up), floor.standing_at_m, weight)


def is_told(term: FloorTerm) -> bool:
    """Whether a floor is known."""
    return bool(term.weight.any())


def equations(term: FloorTerm, poses: Poses, n: int) -> tuple[Array, Array]:
    """Normal equations A (H, n, n) x + b (H, n) = 0 of H poses, per variance of a contour's point."""
    A, b = np.zeros((len(poses), n, n)), np.zeros((len(poses), n))
    add_floor_each(term, np.ascontiguousarray(poses.R), np.ascontiguousarray(poses.t), A, b)
    return A, b

"""Hypotheses on a floor that lean more than they may, turned upright.

What a fit makes of blobs that tell little of how an object is turned, as balls, leans as chance has it. Such a
hypothesis is refused; turned back about its required component, which stays where it is, it may be the right one.
"""

from __future__ import annotations

import numpy as np

from ..image.image_frame import ImageFrame
from .poses import Poses
from .required_place import RequiredPlace


class Upright:
    """Those of one object."""

    def __init__(self, required: RequiredPlace) -> None:
        self._required = required

    def of(self, frame: ImageFrame, poses: Poses) -> Poses:
        """Those that lean too much, turned about the middle of their required component by as little as will do."""
        floor = frame.scene.floor
        if floor is None:
            return poses[:0]
        poses = poses[np.flatnonzero(floor.tilts_deg(poses.R) > floor.config.max_tilt_deg)]
        turns, middle = floor.turns_upright(poses.R), self._required.anchors(poses)
        return Poses(turns @ poses.R, (turns @ (poses.t - middle)[..., None])[..., 0] + middle, poses.q)

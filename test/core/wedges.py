"""Three like discs on a plate, two of which are nearer to each other, and exact pictures of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scene import disc
from squares import TEAM, Placing

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.objects import Component, ObjectModel

DOT = disc("dot", 0.0129)
DOTS = {"front": (0.0418, 0.0), "left": (-0.0418, 0.0215), "right": (-0.0418, -0.0215)}


def dotted(dots=DOTS):
    """The first one is required, and all are of its class."""
    markers = {n: replace(DOT, T_component_marker=Pose(np.eye(3), np.array([*at, 0.0]))) for n, at in dots.items()}
    parts = [Component(name, (marker,), label=TEAM) for name, marker in markers.items()]
    return ObjectModel("wedge", (replace(parts[0], required=True, label=None), *parts[1:]))


class Wedge(Placing):
    """Its `name` is that of the disc that is hidden."""

    def patches(self):
        return [(self.at(DOT.outline + at), TEAM) for name, at in DOTS.items() if name != self.name]

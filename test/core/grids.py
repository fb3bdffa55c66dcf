"""Boards of equal markers in rows, and where their markers are."""

import numpy as np
from solids import marker, rectangle

from artrec_ros.core.geometry.transforms import rotation_from_rotvec
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.pose.poses import Poses

PITCH = 0.07
TOWARDS = np.diag([1.0, -1.0, -1.0])  # a plane's frame (x right, y up, z out) in a camera that faces it


def grid(columns=3, rows=4, required=(1, 1), outline=None, radius=None):
    """Equal markers in rows, on a plane; z points out of it."""
    outline = rectangle(0.05, 0.05) if outline is None else outline
    parts = []
    for i in range(columns):
        for j in range(rows):
            m = marker("m", outline, np.eye(3), (i * PITCH, j * PITCH, 0))
            m = Marker("m", m.outline, m.tail, m.head, radius, m.T_component_marker)
            parts.append(Component(f"s{i}_{j}", (m,), required=(i, j) == required))
    return ObjectModel("grid", tuple(parts))


def at(x=0.0, y=0.0, z=1.0, turn=0.0, tilt=0.0):
    R = rotation_from_rotvec([0.0, 0.0, turn]) @ rotation_from_rotvec([tilt, 0.0, 0.0]) @ TOWARDS
    return Poses(R[None], np.array([[x, y, z]]), np.zeros((1, 0)))


def centres(model, poses, h=0):
    points = np.array([c.markers[0].centre for c in model.components])
    return points @ poses.R[h].T + poses.t[h]


def covered(here, there):
    """How many points have one of the others at their place."""
    return int((np.linalg.norm(here[:, None] - there, axis=2).min(axis=1) < 1e-6).sum())

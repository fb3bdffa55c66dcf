"""Drawn fingers: a bar on which round patches swing in a chain, its pins where they are or elsewhere; their marks."""

import cv2
import numpy as np
from solids import RED

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.learning.marked_views import Figure, Marks, markers_of
from artrec_ros.core.model.kinematics import Kinematics
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.pose.poses import Poses

SIZE, PX_PER_M = (320, 240), 900.0
CAMERA = Camera.facing(SIZE)
PINS = ((0.045, 0.0), (0.10, 0.01), (0.145, 0.01))  # of the bar's frame, joints at 0
ELSEWHERE = ((0.01, 0.03), (0.075, -0.015), (0.12, 0.03))
ROUND = ((0.09, 0.008), (0.135, 0.02), (0.185, 0.01))  # where patches lie at rest
SWING = ((-0.35, 0.35), (-0.1, 0.8), (-0.2, 0.6))


def finger(pins=PINS, limits=SWING, radii=(0.012, 0.011, 0.010)):
    parts, parent, at = [Component("bar", (_bar(),), required=True)], "bar", (0.0, 0.0)
    for name, pin, middle, (lower, upper), radius in zip("abc", pins, ROUND, limits, radii, strict=True):
        joint = Joint(parent, _shifted(np.subtract(pin, at)), np.array([0.0, 0.0, 1.0]), lower, upper)
        parts.append(Component(name, (_disc(radius, np.subtract(middle, pin)),), joint=joint))
        parent, at = name, pin
    return ObjectModel("finger", tuple(parts))


def _shifted(to):
    return Pose(np.eye(3), np.array([*to, 0.0]))


def _bar():
    outline = np.array([(-0.04, -0.02), (0.04, -0.014), (0.04, 0.014), (-0.04, 0.02)])
    return Marker("bar", outline, np.array([-0.04, 0.0]), np.array([0.04, 0.0]), T_component_marker=_shifted((0, 0)))


def _disc(radius, middle):
    angles = 2 * np.pi * np.arange(24) / 24
    outline = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return Marker("disc", outline, np.array([-radius, 0.0]), np.array([radius, 0.0]), radius, _shifted(middle))


def placed(model, rng):
    """A pose before the camera and joints: one row."""
    kin = Kinematics(model)
    R = rotation_from_rotvec([0, 0, rng.uniform(-0.6, 0.6)]) @ np.diag([1.0, -1.0, -1.0])
    t = np.array([-0.07, 0.0, 0.0]) + np.array([0.0, 0.0, CAMERA.focal_px / PX_PER_M])
    return Poses(R[None], t[None], rng.uniform(kin.lower, kin.upper)[None])


def marks(model, poses, rng=None, place="", noise_px=0.4):
    """The ends of all its axes."""
    ends = project(CAMERA, Figure.of(model).ends(poses))[0]
    noise = 0.0 if rng is None else rng.normal(0, noise_px, ends.shape)
    return Marks(np.arange(len(ends)), ends + noise, place)


def picture(model, poses):
    """(H, W) labels."""
    frames, labels, fine = Figure.of(model).frames(poses), np.zeros(SIZE[::-1], np.uint8), 16
    for c, marker, T in markers_of(model):
        flat = T.apply(np.column_stack([marker.outline, np.zeros(len(marker.outline))]))
        seen = project(CAMERA, flat @ frames.R[0, c].T + frames.t[0, c])
        cv2.fillPoly(labels, [np.rint(seen * fine).astype(np.int32)], RED, shift=4)
    return labels

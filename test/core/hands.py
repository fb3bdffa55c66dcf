"""Drawn hands of nine equal discs."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from legs import HIP, PX_PER_M, RADIUS, along, disc

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target

SIZE, Z = (640, 480), np.array([0.0, 0.0, 1.0])
PALM = np.array([(0.0, 0.0), (0.5, -0.15), (0.15, 0.55)])  # metres
ROOTS, WAYS = np.array([(0.7, -0.35), (0.8, 0.2), (0.45, 0.75)]), np.array([-0.5, 0.1, 0.6])  # of its fingers
MIDDLE, TIP = 0.45, 0.4  # lengths of a finger's two links
TURN = 0.4


def hand():
    """Three discs on a palm, and three fingers of two that swing, all of one class."""
    parts = [
        Component(f"p{n}", (replace(disc(0.0), T_component_marker=_at(place)),), required=n == 0)
        for n, place in enumerate(PALM)
    ]
    for n, (root, way) in enumerate(zip(ROOTS, WAYS, strict=True)):
        knuckle = Joint("p0", _at(root, way), Z, -0.7, 0.7, name=f"knuckle{n}")
        bend = Joint(f"m{n}", along(MIDDLE), Z, -0.3, 1.3, name=f"bend{n}")
        parts += [Component(f"m{n}", (disc(MIDDLE),), joint=knuckle), Component(f"t{n}", (disc(TIP),), joint=bend)]
    return Target("hand", ObjectModel("hand", tuple(parts)), HIP)


def _at(place, turn=0.0):
    c, s = np.cos(turn), np.sin(turn)
    return Pose(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.array([*place, 0.0]))


def places(at, bends):
    """(9, 2) pixels of its discs. :param at: of the first. :param bends: (3,) of its fingers' tips."""
    out, unit = [*PALM], lambda angle: np.array([np.cos(angle), np.sin(angle)])
    for root, way, bend in zip(ROOTS, WAYS, bends, strict=True):
        middle = root + MIDDLE * unit(way)
        out += [middle, middle + TIP * unit(way + bend)]
    c, s = np.cos(TURN), np.sin(TURN)
    return np.asarray(at) + PX_PER_M * (np.array(out) @ np.array([[c, s], [-s, c]])) * (1, -1)


def picture(discs):
    """(H, W) labels."""
    labels = np.zeros(SIZE[::-1], np.uint8)
    for x, y in discs:
        cv2.circle(labels, (round(16 * x), round(16 * y)), int(16 * RADIUS * PX_PER_M), HIP, cv2.FILLED, shift=4)
    return labels

"""Drawn legs of four discs, seen from the side: hip, knee, ankle, toe, of a class each."""

from __future__ import annotations

import cv2
import numpy as np

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target

SIZE, PX_PER_M, RADIUS = (480, 320), 100.0, 0.10
THIGH, SHANK, FOOT = 0.95, 0.93, 0.34
HIP, KNEE, ANKLE, TOE = range(1, 5)  # their classes


def leg():
    """Thigh and knee are one; the ankle swings about the knee, the toe about the ankle."""
    z = np.array([0.0, 0.0, 1.0])
    knee = Joint("knee", along(THIGH), z, -2.0, 0.6, name="knee_angle")
    ankle = Joint("ankle", along(SHANK), z, -0.5, 2.3, name="ankle_angle")
    parts = (
        Component("hip", (disc(0.0),), required=True),
        Component("knee", (disc(THIGH),), label=KNEE),
        Component("ankle", (disc(SHANK),), label=ANKLE, joint=knee),
        Component("toe", (disc(FOOT),), label=TOE, joint=ankle),
    )
    return Target("leg", ObjectModel("leg", parts), HIP)


def places(shank=1.0, thigh_rad=1.2, knee=-0.6, ankle=1.4, hip=(220.0, 60.0)):
    """(4, 2) pixels of its discs. :param shank: how long the shank looks, as a share of its length. Angles count as the
    joints do, counter-clockwise as one looks at the picture."""
    turns = np.array([thigh_rad, thigh_rad - knee, thigh_rad - knee - ankle])
    steps = np.array([THIGH, shank * SHANK, FOOT])[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])
    return np.array(hip) + PX_PER_M * np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def picture(at, hidden=(), strays=()):
    """(H, W) labels. :param at: (4, 2) of its discs. :param hidden: classes that are not seen. :param strays: class and
    place of like discs that are no leg's."""
    labels = np.zeros(SIZE[::-1], np.uint8)
    for label, place in [*strays, *(own for own in enumerate(at, HIP) if own[0] not in hidden)]:
        centre = np.rint(16 * np.asarray(place)).astype(int).tolist()
        cv2.circle(labels, centre, int(16 * RADIUS * PX_PER_M), int(label), cv2.FILLED, shift=4)
    return labels


def along(length):
    return Pose(np.eye(3), np.array([length, 0.0, 0.0]))


def disc(at):
    angles = 2 * np.pi * np.arange(24) / 24
    outline = RADIUS * np.column_stack([np.cos(angles), np.sin(angles)])
    return Marker("ball", outline, np.array([-RADIUS, 0.0]), np.array([RADIUS, 0.0]), RADIUS, along(at))

"""Of what is left over of sure objects, too, a limb may be made."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from legs import HIP, PX_PER_M, RADIUS, SIZE, along, disc
from settings import settings

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.left_over_looks import LeftOverLooks
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.through_middles import ThroughMiddles
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.core.verdict.left_over import LeftOvers

BASE, ARM, ANGLE = ((0.0, 0.0), (0.5, 0.0), (0.5, 0.4), (-0.3, 0.7), (0.9, 0.9)), 0.9, 1.1  # metres, radians
CONFIG = settings(time_budget_ms=60000.0, min_scale=85.0, max_scale=118.0)


def crane():
    """Five discs of one class on a base, and one like them that swings about the first."""
    swing = Joint("d0", along(0.0), np.array([0.0, 0.0, 1.0]), -2.0, 2.0, name="swing")
    at = (Pose(np.eye(3), np.array([x, y, 0.0])) for x, y in BASE)
    base = [
        Component(f"d{n}", (replace(disc(0.0), T_component_marker=place),), required=n == 0)
        for n, place in enumerate(at)
    ]
    return Target("crane", ObjectModel("crane", (*base, Component("arm", (disc(ARM),), joint=swing))), HIP)


OFFSETS = np.array([*BASE, (ARM * np.cos(ANGLE), ARM * np.sin(ANGLE))])  # of its discs from the first, metres
MIDDLE = OFFSETS.mean(axis=0)


def picture(*cranes):
    """(H, W) labels. :param cranes: of each where its middle is, pixels, and which discs are seen."""
    labels = np.zeros(SIZE[::-1], np.uint8)
    for at, seen in cranes:
        for x, y in np.asarray(at) + PX_PER_M * ((OFFSETS - MIDDLE) * (1, -1))[seen]:
            cv2.circle(labels, (round(16 * x), round(16 * y)), int(16 * RADIUS * PX_PER_M), HIP, cv2.FILLED, shift=4)
    return labels


def claimed(finder, frame, at):
    """The verdict on a crane whose middle lies at a pixel, with its arm bent the wrong way."""
    camera = frame.camera
    x, y = (np.asarray(at) - np.array(SIZE) / 2) / PX_PER_M - MIDDLE * (1, -1)
    turned = np.diag([1.0, -1.0, -1.0])  # its z looks at the camera
    wrong = Poses(turned[None], np.array([[x, y, camera.focal_px / PX_PER_M]]), np.array([[-1.2]]))
    return Judge.of(finder.config).verdicts(finder, wrong, frame)[0]


def test_the_limb_of_an_object_that_is_sure_without_it_is_sought_where_a_blob_lies_unexplained():
    finder = WholeObjectFinder(crane(), CONFIG, facing=True)
    labels = picture(((240, 160), range(6)))
    frame = ImageFrame(LabelField(labels)).faced()
    verdict = claimed(finder, frame, (240, 160))
    assert verdict.confirmed == (True,) * 5 + (False,)
    assert not LeftOvers(finder).is_in_doubt(range(5))
    looks = LeftOverLooks([finder])
    found = looks.candidates(frame, [verdict], find_blobs(labels, {HIP}, CONFIG))[finder]
    assert abs(found.q[:, 0] - ANGLE).min() < 0.02


def test_those_in_doubt_are_looked_at_first(monkeypatch):
    config = settings(time_budget_ms=60000.0, min_scale=85.0, max_scale=118.0, looks=1)
    finder, sure, doubtful = WholeObjectFinder(crane(), config, facing=True), (110, 160), (360, 160)
    labels = picture((sure, range(6)), (doubtful, [0, 1, 5]))
    frame = ImageFrame(LabelField(labels)).faced()
    accepted = [claimed(finder, frame, at) for at in (sure, doubtful)]
    assert [LeftOvers(finder).is_in_doubt(np.flatnonzero(v.confirmed)) for v in accepted] == [False, True]
    looked_at = []
    monkeypatch.setattr(
        ThroughMiddles, "of", lambda self, camera, pose, middles: looked_at.append(pose) or finder.surface.no_poses
    )
    looks = LeftOverLooks([finder])
    looks.candidates(frame, accepted, find_blobs(labels, {HIP}, config))
    assert looked_at == [accepted[1].claim.poses]

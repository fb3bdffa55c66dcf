"""Small markers that look larger than they are, as blur, running ink and dark coats make them."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scene import disc
from settings import settings
from squares import TEAM, Placing, hinge, patch, rendered

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.recognizer import Recognizer

HEAD, RUMP = 4, 4  # of one colour: an animal that is turned by half lays one on the other's pixels
ROUND = np.column_stack([np.cos(np.pi * np.arange(16) / 8), np.sin(np.pi * np.arange(16) / 8)])
BACK, SPOT = ROUND * (0.011, 0.007), 0.0055 * ROUND
TARGET = Target(
    "mouse",
    ObjectModel(
        "mouse",
        (
            Component("back", (patch("back", BACK),), required=True),
            Component(
                "head",
                (patch("head", SPOT + (0.021, 0.0)),),
                label=HEAD,
                joint=hinge("back", (0.013, 0.0, 0.0), (0, 0, 1), limits=(-0.9, 0.9)),
            ),
            Component(
                "rump",
                (patch("rump", SPOT - (0.015, 0.0)),),
                label=RUMP,
                joint=hinge("back", (-0.010, 0.0, 0.0), (0, 0, 1), limits=(-0.8, 0.8)),
            ),
        ),
    ),
    TEAM,
)


class Mouse(Placing):
    def patches(self):
        head, rump = SPOT + (0.034, 0.0), SPOT - (0.025, 0.0)
        return [(self.at(BACK), TEAM), (self.at(head), HEAD), (self.at(rump), RUMP)]


LAMPS = {"knee": (4, 0.045), "ankle": (5, 0.06), "toe": (6, 0.05)}  # their classes and radii
SHANK, FOOT, LARGER_PX = (0.6, 0.0), (0.25, 0.0), 1.0


def lamp(name, radius, at):
    return replace(disc(name, radius), T_component_marker=Pose(np.eye(3), np.array([*at, 0.0])))


LEG = Target(
    "leg",
    ObjectModel(
        "leg",
        (
            Component("hip", (lamp("hip", 0.06, (0.0, 0.0)),), required=True),
            Component("knee", (lamp("knee", 0.045, (0.5, 0.0)),), label=LAMPS["knee"][0]),
            Component(
                "ankle",
                (lamp("ankle", 0.06, SHANK),),
                label=LAMPS["ankle"][0],
                joint=hinge("knee", (0.5, 0.0, 0.0), (0, 0, 1)),
            ),
            Component(
                "toe", (lamp("toe", 0.05, FOOT),), label=LAMPS["toe"][0], joint=hinge("ankle", (*SHANK, 0.0), (0, 0, 1))
            ),
        ),
    ),
    TEAM,
)


class Leg(Placing):
    def lamps(self):
        """Where they are: its knee is bent by as much as its ankle is the other way."""
        bent = np.array([0.5, 0.0]) + 0.6 * np.array([np.cos(self.arm), np.sin(self.arm)])
        places = {"hip": (0.0, 0.0), "knee": (0.5, 0.0), "ankle": bent, "toe": bent + FOOT}
        return {name: self.at([place])[0] for name, place in places.items()}

    def patches(self):
        at = self.lamps()
        lamps = {"hip": (TEAM, 0.06), **LAMPS}
        return [(at[n] + (self.scale * radius + LARGER_PX) * ROUND, label) for n, (label, radius) in lamps.items()]


def swollen(*placed, size):
    """What a camera shows of them: each patch larger by a pixel all around."""
    labels = rendered(*placed, size=size, fine=4)
    out = np.zeros_like(labels)
    for label in np.setdiff1d(labels, [0]).tolist():
        out[cv2.dilate(np.uint8(labels == label), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))) > 0] = label
    return out


def mice(scale, n=15):
    turns = np.random.default_rng(int(scale)).uniform(-np.pi, np.pi, n)
    return [Mouse(50 + 90 * (i % 5) + t, 50 + 90 * (i // 5) - t, t, scale) for i, t in enumerate(turns)]


def recognized(labels, **options):
    config = settings(time_budget_ms=60000, **options)
    return Recognizer((TARGET,), config, Segmenter(ImageConfig())).recognize(labels).detections


def is_right(d, placed, scale):
    one = min(placed, key=lambda p: np.hypot(p.x - d.image.x, p.y - d.image.y))
    parts = {part.component: np.array([part.x, part.y]) for part in d.components}
    ats = {"back": 0.0, "head": 0.034, "rump": -0.025}
    return parts.keys() == ats.keys() and all(
        np.linalg.norm(parts[name] - one.at([(at, 0.0)])[0]) < 0.004 * scale for name, at in ats.items()
    )


@pytest.mark.parametrize(
    "limits", [{"min_scale": 560.0, "max_scale": 1100.0}, {"min_scale": 720.0, "max_scale": 1100.0}], ids=str
)
@pytest.mark.parametrize("scale", [800.0, 950.0])
def test_swollen_ones_are_found_as_they_lie_and_leave_nothing_on_their_rims(scale, limits):
    """Where they were taken as large as they are most were turned, or held twice."""
    placed = mice(scale)
    found = recognized(swollen(*placed, size=(460, 280)), **limits)
    assert len(found) == len(placed) and all(is_right(d, placed, scale) for d in found)


@pytest.mark.parametrize("arm", [-0.7, 0.0])
def test_far_apart_discs_that_look_a_pixel_larger_are_an_object_all_the_same(arm):
    """All of their outlines lay amid their classes: most were not told, and the others by less than .5."""
    legs = [Leg(40.0 + 10 * n, 60.0 + 110 * n, 0.3 - 0.2 * n, 90.0 + 8 * n, arm=arm) for n in range(4)]
    config = settings(time_budget_ms=60000, min_scale=75.0, max_scale=130.0)
    labels = rendered(*legs, size=(260, 500), fine=4)
    found = Recognizer((LEG,), config, Segmenter(ImageConfig())).recognize(labels).detections
    assert len(found) == len(legs)
    for d in found:
        at = min(legs, key=lambda leg: np.hypot(leg.x - d.image.x, leg.y - d.image.y)).lamps()
        assert d.score > 0.8 and {p.component for p in d.components} == set(at)
        assert all(np.hypot(*(at[p.component] - (p.x, p.y))) < 4 for p in d.components)


def test_markers_that_look_larger_have_more_votes_for_larger_patches_and_rest_where_they_are():
    mouse = Mouse(60.0, 45.0, 0.4, 800.0)
    image = ImageFrame(LabelField(swollen(mouse, size=(120, 90)))).faced()
    exact = ImageFrame(LabelField(rendered(mouse, size=(120, 90), fine=4))).faced()
    plain = WholeObjectFinder(TARGET, settings(), facing=True)
    half, full = plain.swollen
    poses = mouse.pose(image.camera)
    poses = type(poses)(poses.R, poses.t, np.zeros((1, 2)))

    def votes(finder, frame):
        return float(finder.voter.votes(frame, poses, occlusion=True)[0])

    assert votes(full, image) > votes(half, image) > votes(plain, image)
    assert votes(plain, exact) > votes(full, exact)
    used, true = np.ones((1, 3), bool), float(poses.t[0, 2])
    depth = {f: float(f.refit.of(image, poses, (0.0, np.inf)).poses.t[1, 2]) for f in (plain, full)}
    assert depth[plain] < 0.98 * true and abs(depth[full] / true - 1) < 0.015
    assert abs(float(plain.rest.settled(image, poses, used).t[0, 2]) / true - 1) < 0.01  # by how far they are apart


def test_where_markers_cannot_look_larger_there_are_no_such():
    assert WholeObjectFinder(TARGET, settings(swollen_px=0.0), facing=True).swollen == ()
    mouse = Mouse(60.0, 45.0, 0.4, 800.0)
    (found,) = recognized(rendered(mouse, size=(120, 90), fine=4), swollen_px=0.0)
    assert np.hypot(found.image.x - mouse.x, found.image.y - mouse.y) < 1


def test_in_crowds_they_are_taken_as_large_as_they_are():
    """Nobody has the time then: 600 robots took half as long again."""
    labels = swollen(*mice(800.0), size=(460, 280))
    crowd, few = (
        sum(is_right(d, mice(800.0), 800.0) for d in recognized(labels, swollen_most=most)) for most in (0, 15)
    )
    assert crowd < few

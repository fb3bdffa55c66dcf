"""Plates of tiles, each of one of several classes: what lies across two of them is no tile."""

from dataclasses import replace

import numpy as np
import pytest
from scene import disc
from settings import DEFAULTS
from squares import COLOURS, Placing, patch, rendered

from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.range_limits import ScaleLimits
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.blobs import centres, find_blobs
from artrec_ros.core.image.codes import UNKNOWN
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, Identity, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.facing_guesses import FacingGuesser
from artrec_ros.core.pose.finder import WholeObjectFinder

PITCH, HALF = 0.019, 0.0085
SQUARE = np.array([(-HALF, -HALF), (HALF, -HALF), (HALF, HALF), (-HALF, HALF)])
MIDDLE = replace(disc("middle", 0.009), T_component_marker=Pose.identity())
AT = {f"t{r}{c}": PITCH * np.array([c - 1, 1 - r]) for r in range(3) for c in range(3)}
FACES = ("rvrvgrvrv", "vvrrgvrvr", "gvgvrggvv", "vgggrvvgv", "rgggvrrgr")  # the middle is alone in its class


def plate():
    tiles = [Component(n, (patch(n, SQUARE + at),), classes=dict(COLOURS)) for n, at in AT.items() if n != "t11"]
    middle = Component("t11", (MIDDLE,), required=True, classes=dict(COLOURS))
    faces = tuple(Identity(f"f{n}", dict(zip(AT, face, strict=True))) for n, face in enumerate(FACES))
    return ObjectModel("plate", (middle, *tiles), faces, unique=True)


class Plate(Placing):
    def patches(self):
        labels = [COLOURS[c] for c in FACES[int(self.name)]]
        outlines = [MIDDLE.outline if n == "t11" else SQUARE + at for n, at in AT.items()]
        return [(self.at(outline), label) for outline, label in zip(outlines, labels, strict=True)]


@pytest.mark.parametrize("face", range(len(FACES)))
def test_what_lies_across_tiles_of_several_classes_is_none_of_them(face):
    """Wherever and however large it is laid about a blob, a tile is of that blob's class."""
    rng = np.random.default_rng(face)
    finder = WholeObjectFinder(Target("plate", plate(), 1), DEFAULTS, facing=True)
    guesser = FacingGuesser(finder.target.model, finder.surface, DEFAULTS, finder.surface.root)
    for _ in range(6):
        placed = Plate(130.0, 130.0, rng.uniform(-np.pi, np.pi), rng.uniform(2400, 3300), str(face))
        labels = rendered(placed, size=(260, 260), background=UNKNOWN, fine=4)
        frame = ImageFrame(LabelField(labels)).faced()
        blobs = find_blobs(labels, set(COLOURS.values()), DEFAULTS)
        middle = min(blobs, key=lambda b: np.linalg.norm(centres([b])[0] - 130.0))
        found = guesser.guess(frame, [middle], ScaleLimits(0.0, np.inf))
        best = found.poses[[int(found.votes.argmax())]]
        assert np.linalg.norm(project(frame.camera, best.t)[0] - 130.0) < 0.25 * PITCH * placed.scale

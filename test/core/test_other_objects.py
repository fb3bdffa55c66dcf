"""Objects that may be another target's: which one is told, and how sure that is."""

import numpy as np
import pytest
from settings import settings
from solids import camera_of
from squares import SIZE, TEAM, Placing, patch, rendered

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, Identity, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer

OTHER = 5
WIDE = np.array([(-0.03, -0.03), (0.03, -0.03), (0.06, 0.0), (0.03, 0.03), (-0.03, 0.03)])
NOTCH = np.array([(-0.03, 0.01), (-0.012, 0.0), (-0.03, -0.01)])
NOTCHED = np.vstack([WIDE, NOTCH])
DISC = 0.02 * np.column_stack([np.cos(np.pi * np.arange(24) / 12), np.sin(np.pi * np.arange(24) / 12)])
CAMERAS = pytest.mark.parametrize("camera", [None, camera_of(SIZE)], ids=["facing", "space"])
WAYS = pytest.mark.parametrize("turn", [0.3, 2.1, -1.2])


def pair(front, back):
    """Two discs of two classes, the one ahead of the other."""
    ahead, behind = (patch(name, DISC + (x, 0.0)) for name, x in (("front", 0.03), ("back", -0.03)))
    return ObjectModel("pair", (Component("front", (ahead,), required=True), Component("back", (behind,), label=back)))


def lone(outline):
    return ObjectModel("lone", (Component("top", (patch("top", outline),), required=True),))


class Wide(Placing):
    def patches(self):
        return [(self.at(WIDE), TEAM)]


class Notched(Wide):
    def patches(self):
        return [*super().patches(), (self.at(NOTCH), 0)]


CORNERS = [DISC * 0.7 + at for at in ((0.03, 0.03), (0.03, -0.03), (-0.03, -0.03), (-0.03, 0.03))]
FLEET = {name: [OTHER + int(one) for one in name] for name in ("0111", "0011", "0001", "0101", "0000", "1111")}


class Plate(Placing):
    def patches(self):
        return [(self.at(DISC * 0.7), TEAM), *zip(map(self.at, CORNERS), FLEET[self.name], strict=True)]


def plate(classes):
    """A disc, and one in each corner."""
    corners = zip(CORNERS, classes, strict=True)
    parts = [Component(f"c{n}", (patch(f"c{n}", at),), label=label) for n, (at, label) in enumerate(corners)]
    return ObjectModel("plate", (Component("middle", (patch("middle", DISC * 0.7),), required=True), *parts))


class Pair(Placing):
    def patches(self):
        return [(self.at(DISC + (0.03, 0.0)), TEAM), (self.at(DISC - (0.03, 0.0)), OTHER)]


def told(image, models, camera=None):
    """The one object that is told of several targets. :param models: by their targets' names, with their classes."""
    targets = [Target(name, model, label) for name, (model, label) in models.items()]
    recognizer = Recognizer(targets, settings(), Segmenter(ImageConfig()), calibrated=camera is not None)
    (detection,) = recognizer.recognize(image, camera).detections
    return detection


@CAMERAS
@WAYS
def test_what_another_target_turned_looks_like_may_be_either(camera, turn):
    both = {"ahead": (pair(TEAM, OTHER), TEAM), "astern": (pair(OTHER, TEAM), OTHER)}
    image = rendered(Pair(75.0, 60.0, turn, 600.0))
    one = told(image, both, camera)
    (other,) = both.keys() - {one.object}
    assert one.other_object.object == other
    assert one.score < 0.75 and 0.3 < one.other_object.probability < 0.7
    assert one.score / one.as_told > 0.9  # that there is one of the two
    alone = told(image, {"ahead": both["ahead"]}, camera)
    assert alone.score > 0.9 and alone.other_object is None


@CAMERAS
@WAYS
@pytest.mark.parametrize("shape", [Wide, Notched])
@pytest.mark.parametrize("first", ["wide", "notched"])
def test_what_differs_little_is_told_by_the_pixels_in_which_it_does(camera, turn, shape, first):
    both = {"wide": (lone(WIDE), TEAM), "notched": (lone(NOTCHED), TEAM)}
    in_order = {name: both[name] for name in sorted(both, key=lambda name: name != first)}
    one = told(rendered(shape(75.0, 60.0, turn, 600.0)), in_order, camera)
    assert one.object == ("wide" if shape is Wide else "notched")
    assert one.other_object is None or one.other_object.probability < 0.2


@CAMERAS
@pytest.mark.parametrize("name", FLEET)
def test_of_a_fleet_the_one_is_told_whose_classes_are_all_seen(camera, name):
    """Any other one explains all of its pixels but those of the corners in which they differ."""
    fleet = {name: (plate(classes), TEAM) for name, classes in FLEET.items()}
    one = told(rendered(Plate(75.0, 60.0, 0.4, 500.0, name)), fleet, camera)
    assert one.object == name and one.score > 0.75


def test_where_its_own_pixels_tell_it_nothing_is_taken_from_it():
    both = {"ahead": (pair(TEAM, OTHER), TEAM), "lone": (lone(DISC), TEAM)}
    one = told(rendered(Pair(75.0, 60.0, 0.3, 600.0)), both)
    assert one.object == "ahead" and one.score > 0.9 and one.other_object is None and one.as_told == 1


@WAYS
def test_of_which_name_is_not_known_direction_is_not_either(turn):
    either = {"first": TEAM, "second": OTHER}
    ahead, behind = (patch(name, DISC + (x, 0.0)) for name, x in (("front", 0.03), ("back", -0.03)))
    parts = Component("front", (ahead,), required=True, classes=either), Component("back", (behind,), classes=either)
    names = [Identity(f"{a}_{b}", {"front": a, "back": b}) for a in either for b in either if a != b]
    one = told(rendered(Pair(75.0, 60.0, turn, 600.0)), {"pair": (ObjectModel("pair", parts, tuple(names)), TEAM)})
    assert one.identity.name is None and one.score < 0.8
    assert one.as_told == pytest.approx(max(one.identity.probability, 1 - one.identity.probability), abs=0.02)

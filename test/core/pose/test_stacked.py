"""Of markers that lie on each other, views of one thing, one at a time is there."""

import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import RED, camera_of, marker, rectangle, render

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.rebends import Rebends
from artrec_ros.core.pose.region_fit import RegionFit
from artrec_ros.core.pose.stacked_regions import StackedRegions
from artrec_ros.core.recognizer import Recognizer

CAMERA = camera_of((320, 240), 300.0)
VIEWS = {
    "up": rectangle(0.05, 0.06),
    "lie": rectangle(0.13, 0.04, (-0.04, 0.0)),
    "back": rectangle(0.13, 0.04, (0.04, 0.0)),
}
PLATE = np.array([[-0.08, -0.05], [0.08, -0.05], [0.08, 0.07], [0.0, 0.07], [0.0, 0.03], [-0.08, 0.03]])


def toy(*views):
    """A plate, and on a joint below it a foot that shows one of some views."""
    plate = Component("plate", (marker("plate", PLATE, np.eye(3), (0, 0, 0)),), required=True)
    hip = Joint("plate", Pose(np.eye(3), np.array([0.0, -0.05, 0.0])), np.array([0.0, 0.0, 1.0]), -0.9, 0.9)
    foot = tuple(marker(view, VIEWS[view], np.eye(3), (0, -0.1, 0)) for view in views)
    return ObjectModel("toy", (plate, Component("foot", foot, joint=hip)))


ALL = toy(*VIEWS)


def standing(*hips):
    each = np.tile(np.diag([1.0, -1.0, -1.0]), (len(hips), 1, 1))
    return Poses(each, np.tile([0.02, -0.05, 0.6], (len(hips), 1)), np.array(hips, float)[:, None])


def drawn(view, hip=0.3):
    return render(CAMERA, [(toy(view), standing(hip), RED)])


def finder_of(model):
    return WholeObjectFinder(Target("toy", model, RED), DEFAULTS)


@pytest.mark.uncompiled
@pytest.mark.parametrize("view", VIEWS)
def test_the_view_that_fits_counts_as_if_it_were_the_only_one(view):
    """In the search as in the verdict; the others are neither seen nor missed."""
    frame, poses = ImageFrame(LabelField(drawn(view)), CAMERA), standing(0.3)
    every, alone = finder_of(ALL), finder_of(toy(view))
    said, only = (f.voter.judge(frame, poses, occlusion=True) for f in (every, alone))
    assert said.votes.sum() == pytest.approx(only.votes.sum())
    assert every.voter.votes(frame, poses, occlusion=False) == pytest.approx(alone.voter.total(only))
    there = np.array([True, *(name == view for name in VIEWS)])
    assert (every.surface.there(frame, poses)[0] == there).all()
    assert (every.voter.supported(said)[0] == there).all() and not said.area_px[0, ~there].any()
    some = every.surface.score(
        frame, poses, np.array([1, 3]), occlusion=True
    )  # each is there where others are not asked
    assert (some.area_px > 0).sum() == 1


@pytest.mark.uncompiled
@pytest.mark.parametrize("view", VIEWS)
def test_joints_are_sought_with_the_view_that_fits(view):
    frame, poses = ImageFrame(LabelField(drawn(view)), CAMERA), standing(0.0)
    every, alone = finder_of(ALL).surface, finder_of(toy(view)).surface
    grids = every.kinematics.grids(0.15)
    assert every.search_joints(frame, poses, grids).q == pytest.approx(alone.search_joints(frame, poses, grids).q)
    bent, only = (Rebends(s, DEFAULTS.search, 0.5).of(frame, poses).q[0, 0] for s in (every, alone))
    assert bent == pytest.approx(only) and bent == pytest.approx(0.3, abs=0.06)


def test_regions_of_colour_are_those_of_the_view_that_fits():
    views = ("up", "lie", "up")
    frames = {
        view: ImageFrame(LabelField(labels), CAMERA, image=np.repeat((60 * labels)[..., None], 3, axis=2))
        for view in views
        for labels in [drawn(view)]
    }
    every, poses = finder_of(ALL).surface, standing(0.3, 0.25, 0.35)
    for view, frame in frames.items():
        alone = RegionFit(finder_of(toy(view)).surface, DEFAULTS)
        stacked = StackedRegions(every, DEFAULTS)
        assert stacked.evenness(frame, poses) == pytest.approx(alone.evenness(frame, poses))
        used = np.ones((3, len(every.markers)), bool)
        assert stacked.fitted(frame, poses, used).q == pytest.approx(alone.fitted(frame, poses, used[:, :2]).q)


@pytest.mark.parametrize("camera", [CAMERA, None], ids=["space", "flat"])
@pytest.mark.parametrize("view", VIEWS)
def test_the_view_that_is_drawn_is_told(camera, view):
    """As surely as if it were the only one, but that chance has the choice, too."""
    scale = {} if camera is not None else dict(min_scale=400.0, max_scale=600.0)
    every, alone = (
        Recognizer((Target("toy", model, RED),), settings(**scale), Segmenter(ImageConfig()))
        for model in (ALL, toy(view))
    )
    ((found,), (only,)) = (engine.recognize(drawn(view), camera).detections for engine in (every, alone))
    assert {c.component: c.marker for c in found.components} == {"plate": "plate", "foot": view}
    times = np.sqrt(len(VIEWS))  # the plate has one
    assert 1 / found.score - 1 == pytest.approx(times * (1 / only.score - 1), rel=0.05)

"""Other components that explain what is taken for the required one."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from solids import BLUE, RED, camera_of, marker, rectangle, render

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.stand_ins import StandIns
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.core.verdict.ownership import share_out

CAMERA = camera_of((640, 480), 600.0)
HEAD = np.array([[-0.03, -0.015], [0.03, -0.015], [0.045, 0], [0.03, 0.015], [-0.03, 0.015]])
LINK = rectangle(0.056, 0.022)
TOWARDS = np.diag([1.0, -1.0, -1.0])  # a plane's frame (x right, y up, z out) in a camera that faces it


def snake(links=6, outline=LINK, label=None, jointed=True):
    """A head and links behind it, in one plane."""
    parts = [Component("head", (marker("head", HEAD, np.eye(3), (0, 0, 0)),), required=True)]
    for n in range(links):
        origin = Pose(np.eye(3), np.array([-0.04 if n == 0 else -0.072, 0, 0]))
        limits = (-0.8, 0.8) if jointed else (0.0, 0.0)
        joint = Joint(parts[-1].name, origin, np.array([0.0, 0, 1.0]), *limits, "revolute" if jointed else "fixed")
        link = marker("link", outline, np.eye(3), (-0.036, 0, 0))
        parts.append(Component(f"link{n}", (link,), label=label, joint=joint))
    return ObjectModel("snake", tuple(parts))


def at(model, x=0.0, z=1.0, bend=0.1):
    joints = sum(c.joint is not None and c.joint.kind != "fixed" for c in model.components)
    return Poses(TOWARDS[None], np.array([[x, 0.0, z]]), np.full((1, joints), bend))


def frame_of(model, pose, hidden=()):
    """Seen without some components."""
    labels = render(CAMERA, [(model, pose, RED)])
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    frames = surface.kinematics.forward(pose.R, pose.t, pose.q)
    for c, component in enumerate(model.components):
        if component.name in hidden:
            centre = component.markers[0].centre @ frames.R[0, c].T + frames.t[0, c]
            u, v = np.rint(centre[:2] / centre[2] * 600 + (320, 240)).astype(int)
            labels[v - 24 : v + 25, u - 28 : u + 29] = 0
    return ImageFrame(LabelField(labels), CAMERA)


def head_on(model, pose, component):
    """The object moved to where its head lies on another component, and the links follow."""
    kin = SpatialModel(model, RED, DEFAULTS.votes).kinematics
    frames, c = kin.forward(pose.R, pose.t, pose.q), [m.name for m in model.components].index(component)
    offset = np.array([-0.036, 0, 0])
    t = frames.R[0, c] @ offset + frames.t[0, c]
    return Poses(frames.R[:, c], t[None], pose.q)


def stand_ins_of(surface):
    return StandIns(surface, surface.kinematics.grids(DEFAULTS.search.fine_joint_step), DEFAULTS.verdict.stand_in)


def judged(model, frame, poses):
    finder = WholeObjectFinder(Target("snake", model, RED), DEFAULTS)
    scores = finder.voter.judge(frame, poses, occlusion=True)
    patch = finder.surface.markers_of[finder.surface.root][0]
    return finder.surface, patch, float(scores.votes[0, patch]), float(scores.area_px[0, patch])


def test_a_head_laid_on_a_link_looks_more_like_a_link():
    model = snake()
    true = at(model)
    frame = frame_of(model, true, hidden=["head"])
    claim = head_on(model, true, "link1")
    surface, patch, *said = judged(model, frame, claim)
    found = stand_ins_of(surface).better(frame, claim, patch, *said)
    assert found is not None and model.components[found].name.startswith("link")


@pytest.mark.parametrize("z", [0.6, 1.0, 2.0])
def test_a_head_in_view_looks_like_itself(z):
    model = snake()
    true = at(model, z=z)
    frame = frame_of(model, true)
    surface, patch, *said = judged(model, frame, true)
    assert stand_ins_of(surface).better(frame, true, patch, *said) is None


@pytest.mark.parametrize(
    "other",
    [{"outline": HEAD}, {"label": BLUE}, {"jointed": False}],
    ids=["looks the same", "of another class", "fixed"],
)
def test_only_what_joints_may_bring_there_and_looks_otherwise_stands_in(other):
    model = snake(**other)
    true = at(snake())
    frame = frame_of(snake(), true, hidden=["head"])
    claim = Poses(*(getattr(head_on(snake(), true, "link1"), n) for n in "Rt"), at(model).q)
    surface, patch, _, area_px = judged(model, frame, claim)
    assert stand_ins_of(surface).better(frame, claim, patch, -1e9, area_px) is None


def test_such_an_object_is_not_told_but_owns_its_pixels_and_the_reason_names_the_other():
    model, judge = snake(), Judge.of(DEFAULTS)
    true = at(model, bend=0.0)
    frame = frame_of(model, true, hidden=["head"])
    finder = WholeObjectFinder(Target("snake", model, RED), DEFAULTS)
    claim = head_on(model, true, "link0")
    claim = Poses(claim.R, 1.05 * claim.t, claim.q)  # as a fit has it: the head is larger
    assert judge.accepts(judge.verdicts(finder, claim, frame))[0]
    told, others, _ = share_out([(finder, claim)], frame, judge)
    assert told == []
    (other,) = others
    assert "looks more like link" in judge.reason(other)


@pytest.mark.parametrize("length", [0.03, 0.04])
@pytest.mark.parametrize("bend", [0.0, 0.1])
def test_a_head_that_is_smaller_than_what_it_draws_looks_like_itself(length, bend):
    """A link laid across it and the next one has more votes, but fewer a pixel."""
    plain, judge = snake(), Judge.of(DEFAULTS)
    head = Component("head", (marker("head", rectangle(length, 0.022), np.eye(3), (0, 0, 0)),), required=True)
    model = ObjectModel("snake", (head, *plain.components[1:]))
    true = at(model, bend=bend)
    frame = frame_of(model, true, hidden=["link5"])
    finder = WholeObjectFinder(Target("snake", model, RED), DEFAULTS)
    told = share_out([(finder, true)], frame, judge).accepted
    assert len(told) == 1


def test_the_clock_does_not_decide_what_it_looks_like():
    model, judge = snake(), Judge.of(DEFAULTS)
    true = at(model, bend=0.0)
    frame = frame_of(model, true, hidden=["head"])
    claim = head_on(model, true, "link0")
    claim = Poses(claim.R, 1.05 * claim.t, claim.q)
    finder = WholeObjectFinder(Target("snake", model, RED), DEFAULTS)
    late = replace(frame, deadline=Deadline(0.0))
    for seen in (frame, late):
        (verdict,) = judge.verdicts(finder, claim, seen)
        assert verdict.stand_in == "link0" and not judge.tells(verdict)
        assert "looks more like link0" in judge.reason(verdict)


def test_where_all_components_are_in_view_there_is_none_to_spare():
    model, judge = snake(), Judge.of(DEFAULTS)
    true = at(model)
    frame = frame_of(model, true)
    finder = WholeObjectFinder(Target("snake", model, RED), DEFAULTS)
    told = share_out([(finder, true)], frame, judge).accepted
    assert len(told) == 1 and judge.reason(told[0]) is None

"""Once all objects are found, those that do not lie on their labels are bent anew."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, marker, pose, rectangle, render, truck

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.base.patience import Patience
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.memory.recall import Recall
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.second_looks import SecondLooks
from artrec_ros.core.spatial_looks import SpatialLooks
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.core.verdict.ownership import share_out

CAMERA, JUDGE = camera_of(), Judge.of(DEFAULTS)
FRONT = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)
LINKS = [f"link_{k}" for k in range(6)]


def snake():
    """A head, and equal links that swing in its plane."""
    head = marker("face", rectangle(0.1, 0.06), FRONT, (0, 0, 0))
    parts = [Component("head", (head,), required=True)]
    for k, name in enumerate(LINKS):
        joint = Joint(
            parts[-1].name, Pose.from_xyz_rpy((0, 0, 0.04 if k else 0.03)), np.array([0.0, 1.0, 0]), -0.6, 0.6
        )
        link = marker("face", rectangle(0.03, 0.034, (0.0, 0.02)), FRONT, (0, 0, 0))
        parts.append(Component(name, (link,), joint=joint))
    return ObjectModel("snake", tuple(parts))


@pytest.fixture(scope="module")
def finder():
    return WholeObjectFinder(Target("snake", snake(), RED), DEFAULTS)


def bent(x, yaw, q):
    return pose(x, 0.12, 0.6, yaw, model=snake(), joints=dict(zip(LINKS, q, strict=True)))


def seen(*poses, deadline=None):
    labels = render(CAMERA, [(snake(), p, RED) for p in poses])
    return ImageFrame(LabelField(labels), CAMERA, deadline=deadline or Deadline())


def told(finder, frame, found, recall=None):
    """Joints of what is told, from left to right; and whether the search alone tells the same."""
    looks = SecondLooks(frame, JUDGE, DEFAULTS.search, recall)
    both = [share_out([(finder, found)], frame, JUDGE)[0], looks.shared([(finder, found)])[0]]
    plain, again = (sorted((v.claim.poses for v in told), key=lambda p: p.t[0, 0]) for told in both)
    same = [p.q.tolist() for p in plain] == [p.q.tolist() for p in again]
    return np.concatenate([p.q for p in again]), same


LEFT, RIGHT = (0.3, 0.3, 0.1, -0.2, -0.3, 0.1), (-0.3, -0.2, -0.1, 0.3, 0.2, 0.1)
ASTRAY = (0.3, 0.3, 0.6, 0.6, 0.6, 0.6)


def test_what_went_astray_is_bent_anew_in_what_the_others_leave(finder):
    left, right = bent(-0.08, 0.0, LEFT), bent(0.1, 0.0, RIGHT)
    frame, found = seen(left, right), Poses.concatenate([bent(-0.08, 0.0, ASTRAY), right])
    q, same = told(finder, frame, found)
    np.testing.assert_allclose(q, [LEFT, RIGHT], atol=0.15)  # it is not at rest yet
    assert not same


def test_where_nothing_is_in_doubt_or_no_time_is_left_nothing_is_bent(finder):
    left, right = bent(-0.08, 0.0, LEFT), bent(0.1, 0.0, RIGHT)
    assert told(finder, seen(left, right), Poses.concatenate([left, right]))[1]
    astray = Poses.concatenate([bent(-0.08, 0.0, ASTRAY), right])
    assert told(finder, seen(left, right, deadline=Deadline(-1.0)), astray)[1]
    lorry = WholeObjectFinder(Target("truck", truck(), RED), DEFAULTS)
    assert lorry.bending.any is False


class Ending(Deadline):
    """Expires when it is told to; all of its parts with it."""

    over = False

    @property
    def expired(self):
        return self.over

    def part(self, share):
        return self


def test_what_is_shared_out_late_takes_nothing_from_what_was_told(finder, monkeypatch):
    left, right = bent(-0.06, 0.0, LEFT), bent(0.07, 0.0, RIGHT)
    ending = Ending()
    frame, found = seen(left, right, deadline=ending), Poses.concatenate([bent(-0.06, 0.0, ASTRAY), right])
    begun = share_out([(finder, found)], frame, JUDGE)[0]
    look = SpatialLooks.again

    def last_look(*args):
        bent_anew = look(*args)
        ending.over = True
        return bent_anew

    monkeypatch.setattr(SpatialLooks, "again", last_look)
    told_late = SecondLooks(frame, JUDGE, DEFAULTS.search).shared([(finder, found)])[0]
    assert len(told_late) == len(begun) == 2


def test_while_a_newer_image_waits_nothing_is_bent(finder):
    left, right = bent(-0.08, 0.0, LEFT), bent(0.1, 0.0, RIGHT)
    frame, found = seen(left, right), Poses.concatenate([bent(-0.08, 0.0, ASTRAY), right])
    assert not told(finder, frame, found, Recall(patience=Patience(lambda: False)))[1]
    assert told(finder, frame, found, Recall(patience=Patience(lambda: True)))[1]


def test_what_did_not_change_is_not_looked_at_again(finder, monkeypatch):
    """A chain far away that nothing bends better costs one look, however many rounds its neighbours take."""
    camera = camera_of(size=(960, 240))
    placed = [bent(-0.4, 0.0, LEFT), bent(0.3, 0.0, LEFT), bent(0.47, 0.0, RIGHT)]
    frame = ImageFrame(LabelField(render(camera, [(snake(), p, RED) for p in placed])), camera)
    found = Poses.concatenate([bent(-0.4, 0.0, ASTRAY), bent(0.3, 0.0, ASTRAY), placed[2]])
    looked, look = [], SpatialLooks.again

    def counted(self, frame, finder, poses):
        looked.append(round(float(poses.t[0, 0]), 1))
        return None if poses.t[0, 0] < -0.3 else look(self, frame, finder, poses)

    monkeypatch.setattr(SpatialLooks, "again", counted)
    SecondLooks(frame, JUDGE, DEFAULTS.search).shared([(finder, found)])
    assert looked.count(-0.4) == 1 and looked.count(0.3) > 1


def test_a_known_object_is_looked_at_again_in_its_turn(finder, monkeypatch):
    left, right = bent(-0.08, 0.0, LEFT), bent(0.1, 0.0, RIGHT)
    frame, found = seen(left, right), Poses.concatenate([bent(-0.08, 0.0, ASTRAY), right])
    monkeypatch.setattr(Recall, "rests", lambda *_: True)
    assert told(finder, frame, found, Recall())[1]


def test_more_candidates_come_beside_what_was_bent_and_in_time_only(finder):
    left, right = bent(-0.06, 0.0, LEFT), bent(0.07, 0.0, RIGHT)
    ending = Ending()
    frame, found = seen(left, right, deadline=ending), Poses.concatenate([bent(-0.06, 0.0, ASTRAY), right])
    looks, more = SecondLooks(frame, JUDGE, DEFAULTS.search), [(finder, bent(-0.06, 0.0, ASTRAY))]
    before = looks.shared([(finder, found)])[0]
    after = looks.beside(more)[0]
    assert sum(v.claim.votes for v in after) >= sum(v.claim.votes for v in before)  # what was bent anew is not lost
    ending.over = True
    assert looks.beside(more)[0] is after

"""Components of an accepted object: which of them lie on their own markers."""

import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import BODY, RED, camera_of, marker, pose, rectangle, render, truck

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.verdict.acceptance import packed, verdicts_of
from artrec_ros.core.verdict.acceptance_curves import PARTS
from artrec_ros.core.verdict.claims import claims_of, silhouette
from artrec_ros.core.verdict.curve_kernels import probabilities
from artrec_ros.core.verdict.descriptions import Describer
from artrec_ros.core.verdict.parts import PartEvidence, part_evidence, part_probabilities

CAMERA = camera_of()
TRUCK = truck()
AT = pose(0, 0, 0.7, 0.1, model=TRUCK)
NAMES = [c.name for c in TRUCK.components]


def verdict_on(labels, model=TRUCK, at=AT, owners=(), config=DEFAULTS):
    frame = ImageFrame(LabelField(labels), CAMERA)
    finder = WholeObjectFinder(Target(model.name, model, RED), config)
    for other, place in owners:
        frame = frame.without(silhouette(WholeObjectFinder(Target("o", other, RED), config).surface, CAMERA, place))
    return verdicts_of(claims_of(finder, at, frame))[0], frame


def logistic(model, row):
    out = np.empty(1)
    probabilities(packed([model], PartEvidence), np.zeros(1, np.int64), np.array([row]), out)
    return float(out[0])


def whole():
    return render(CAMERA, [(TRUCK, AT, RED)])


def without_leg(name, left=0.0):
    """The picture with one leg's marker painted over with its body's colour, but for a share of its rows."""
    labels, verdict = whole(), verdict_on(whole())[0]
    (detection,) = Describer(verdict.claim.finder).describe([verdict], ImageFrame(LabelField(labels), CAMERA))
    (part,) = (p for p in detection.components if p.component == name)
    x, y = np.rint(part.contour).astype(int).T
    low, high = y.min() - 1, y.max() + 2
    box = labels[low + round(left * (high - low)) : high, x.min() - 1 : x.max() + 2]
    box[box == RED] = BODY
    return labels


def test_components_in_plain_view_are_all_but_certain_and_the_required_one_is_as_probable_as_the_object():
    verdict, _ = verdict_on(whole())
    (found,) = part_probabilities([verdict])
    assert set(found) == {0, 1, 2}
    assert min(found.values()) > 0.9
    assert found[0] == verdict.probability


def test_a_component_of_which_little_is_seen_is_less_probable():
    full, some = (
        part_probabilities([verdict_on(labels)[0]])[0].get(1, 0.0) for labels in (whole(), without_leg("fore", 0.3))
    )
    assert some < full
    (none,) = part_probabilities([verdict_on(without_leg("fore"))[0]])
    assert none.get(1, 0.0) < DEFAULTS.min_component_probability


def test_only_components_probable_enough_are_told_and_joints_that_they_tell():
    labels, told = whole(), {}
    for least in (0.0, 1.0):
        verdict, frame = verdict_on(labels, config=settings(min_component_probability=least))
        (told[least],) = Describer(verdict.claim.finder).describe([verdict], frame)
    assert {p.component for p in told[0.0].components} == set(NAMES) and set(told[0.0].joints) == {"fore", "hind"}
    assert {p.component for p in told[1.0].components} == {"torso"} and not told[1.0].joints


def siblings(gap):
    """A plate with two equal bars on joints of their own, `gap` apart."""
    plate = Component("plate", (marker("m", rectangle(0.1, 0.06), np.eye(3), (0, 0.08, 0)),), required=True)
    bars = [
        Component(
            name,
            (marker("m", rectangle(0.02, 0.1, (0, -0.05)), np.eye(3), (0, 0, 0)),),
            joint=Joint("plate", Pose.from_xyz_rpy((x, 0.04, 0)), np.array([0.0, 0.0, 1.0]), -1.0, 1.0),
        )
        for name, x in (("one", -gap / 2), ("two", gap / 2))
    ]
    return ObjectModel("pair", (plate, *bars))


@pytest.mark.parametrize("gap, alone", [(0.06, 1.0), (0.01, 0.5), (0.0, 0.0)])
def test_of_two_that_lie_on_one_marker_one_has_it_to_itself(gap, alone):
    """Of the pixels that two siblings claim only the likelier one's count."""
    model = siblings(gap)
    at = Poses(np.diag([1.0, -1.0, -1.0])[None], np.array([[0.0, 0.0, 0.6]]), np.zeros((1, 2)))
    verdict, _ = verdict_on(render(CAMERA, [(model, at, RED)]), model, at)
    first, *second = sorted((row.alone for c, row in part_evidence(verdict).items() if c), reverse=True)
    assert first == 1.0
    assert second == ([pytest.approx(alone, abs=0.1)] if alone else [])  # of one that has no pixel nothing is shown


def test_what_another_object_hides_of_a_component_is_not_open():
    block = ObjectModel("block", (Component("b", (marker("m", rectangle(0.3, 0.12), np.eye(3), (0, 0, 0)),), True),))
    in_front = Poses(np.diag([1.0, -1.0, -1.0])[None], np.array([[0.0, 0.13, 0.65]]), np.zeros((1, 0)))
    free, hidden = (verdict_on(whole(), owners=o)[0] for o in ([], [(block, in_front)]))
    assert all(row.open == pytest.approx(1) for row in part_evidence(free).values())
    rows = part_evidence(hidden)
    assert rows[0].open > 0.95 and all(rows[c].open < 0.9 for c in rows if c)


def test_more_evidence_never_lowers_the_probability():
    least = PartEvidence(*(xs[0] for xs in (PARTS[1].get(name, ((0.0, 0.0),))[0] for name in PartEvidence._fields)))
    for name, (xs, ys) in PARTS[1].items():
        assert (np.diff(xs) > 0).all() and (np.diff(ys) >= 0).all()
        p = [logistic(PARTS, least._replace(**{name: x})) for x in np.linspace(xs[0] - 1, xs[-1] + 1, 20)]
        assert p == sorted(p)


def test_a_likelier_object_has_likelier_components():
    verdict, _ = verdict_on(whole())
    rows = part_evidence(verdict)
    assert rows[1].whole == pytest.approx(min(np.log(verdict.probability / (1 - verdict.probability)), 7.0))
    assert logistic(PARTS, rows[1]._replace(whole=-3.0)) < logistic(PARTS, rows[1])

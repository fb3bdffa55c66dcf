"""Flat objects that are found from the blobs of their limbs: their required component is merged, hidden or not seen."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from settings import settings
from solids import RED, rectangle
from squares import BODY, Placing, hinge, patch, rendered

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.facing_search import FacingSearch
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.range_limits import scale_limits
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.facing_limbs import FacingLimbs
from artrec_ros.core.pose.lookalikes import Lookalikes
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.recognizer import Recognizer

LIMB, SIZE = 4, (200, 160)
ANGLES = {"one": 0.3, "two": 2.1, "three": 4.4}
ROUND = np.column_stack([np.cos(np.arange(8) * np.pi / 4), np.sin(np.arange(8) * np.pi / 4)]) * 0.04
LEG = rectangle(0.06, 0.02, (0.035, 0.0))
LARGE = rectangle(0.08, 0.03, (0.045, 0.0))  # three of these show more than the middle


def star(leg=LEG):
    """An octagon, which hardly tells its turn, and three legs of another class that swing about its rim."""
    legs = [
        Component(
            name, (patch(name, leg),), label=LIMB,
            joint=hinge("middle", (0.045 * np.cos(a), 0.045 * np.sin(a), 0.0), (0, 0, 1), limits=(a - 0.4, a + 0.4)),
        )
        for name, a in ANGLES.items()
    ]  # fmt: skip
    return ObjectModel("star", (Component("middle", (patch("middle", ROUND),), required=True), *legs))


@dataclass(frozen=True)
class Star(Placing):
    """A star; its legs swing by `arm` from where they stand."""

    large: bool = False

    def patches(self):
        out = [(self.at(ROUND), RED)]
        for angle in ANGLES.values():
            q = angle + self.arm
            turn = np.array([[np.cos(q), np.sin(q)], [-np.sin(q), np.cos(q)]])
            leg = LARGE if self.large else LEG
            out.append((self.at(leg @ turn + 0.045 * np.array([np.cos(angle), np.sin(angle)])), LIMB))
        return out


AT = Star(90.3, 80.2, 0.7, 500.0, arm=0.2)
PLAIN, LARGE_LEGS = (rendered(at, size=SIZE) for at in (AT, replace(AT, large=True)))


def merged(rows=(62, 100), columns=(4, 90)):
    """A part of its middle's rim is amid a bar of its class."""
    labels, bar = PLAIN.copy(), (slice(*rows), slice(*columns))
    labels[bar] = np.where(labels[bar] == 0, RED, labels[bar])
    return labels


def recognized(labels, leg=LEG, **options):
    config = settings(time_budget_ms=60000, **options)
    return Recognizer((Target("star", star(leg), RED),), config, Segmenter(ImageConfig())).recognize(labels)


def error(detection):
    """Pixels, degrees, share."""
    turn = np.degrees(np.angle(np.exp(1j * (-detection.image.theta - AT.turn))))
    off = np.hypot(detection.image.x - AT.x, detection.image.y - AT.y)
    return off, abs(turn), abs(np.log(detection.image.scale / AT.scale))


def test_a_plain_one_is_found():
    (found,) = recognized(PLAIN).detections
    assert np.less(error(found), (1.0, 3.0, 0.05)).all() and len(found.components) == 4


def test_legs_tell_where_a_body_is_that_merged_with_others_of_its_class(monkeypatch):
    for picture in (merged(), merged(columns=(0, 200))):
        found, *others = recognized(picture).detections
        assert np.less(error(found), (2.0, 3.0, 0.05)).all() and found.score > 0.8
        assert all(other.score < 0.6 for other in others)  # what is left of the blob may be another one, at the border
    monkeypatch.setattr(FacingSearch, "limbs", lambda *args: [])
    monkeypatch.setattr(Lookalikes, "__len__", lambda self: 0)  # turned onto itself it is found without them, too
    assert not recognized(merged(columns=(0, 200))).detections


@pytest.mark.parametrize("greatest", [0.0, 550.0])
@pytest.mark.parametrize(("rows", "columns"), [((62, 100), (0, 200)), ((50, 110), (0, 95))])
def test_limits_of_the_scale_do_not_end_the_search_from_legs(rows, columns, greatest):
    """Of so large a blob no smaller part is looked for where the scale is known."""
    found = recognized(merged(rows, columns), max_scale=greatest).detections
    best = min(found, key=lambda d: error(d)[0])
    assert np.less(error(best), (2.0, 3.0, 0.05)).all()


def test_one_without_labels_on_its_required_component_is_found_where_that_is_no_matter():
    faded = np.where(LARGE_LEGS == RED, 0, LARGE_LEGS)
    assert not recognized(faded, LARGE).detections
    every = {"required": "visible", "facing": replace(settings().facing, limb_keep=1000)}
    (found,) = recognized(faded, LARGE, **every).detections
    assert np.less(error(found), (2.0, 3.0, 0.05)).all()
    assert {c.component for c in found.components} == set(ANGLES)  # what is not seen is not told
    assert found.score < recognized(LARGE_LEGS, LARGE).detections[0].score + 1e-3  # both are sure
    other = np.where(LARGE_LEGS == RED, BODY, LARGE_LEGS)  # something else is where its middle should be
    assert all(error(d)[0] > 20 for d in recognized(other, LARGE, **every).detections)


@pytest.mark.parametrize("greatest", [495.0, 490.0])
def test_what_legs_tell_keeps_to_the_limits_of_the_scale(greatest):
    faded = np.where(LARGE_LEGS == RED, 0, LARGE_LEGS)
    every = {"required": "visible", "facing": replace(settings().facing, limb_keep=1000)}
    (found,) = recognized(faded, LARGE, max_scale=greatest, **every).detections
    assert np.less(error(found), (2.0, 3.0, 0.05)).all() and found.image.scale <= greatest + 1e-6


def test_a_limbs_blob_leads_to_the_object_whichever_way_it_bends():
    config, model = settings(), star()
    surface = SpatialModel(model, RED, config.votes)
    frame = ImageFrame(LabelField(PLAIN)).faced()
    legs = [b for b in find_blobs(PLAIN, {RED, LIMB}, config) if b.label == LIMB]
    limbs = FacingLimbs(model, surface, config)
    poses, blob = limbs.guess(frame, legs, scale_limits(config, None))
    assert limbs.labels == {LIMB} and len(legs) == 3
    assert set(blob.tolist()) == {0, 1, 2} and (np.bincount(blob) <= config.facing.limb_keep).all()
    off = np.linalg.norm(project(frame.camera, poses.t) - (AT.x, AT.y), axis=1)
    true = AT.pose(frame.camera).R[0]
    turned = np.arccos(np.clip((np.einsum("hij,ij->h", poses.R, true) - 1) / 2, -1, 1))
    near = (off < 8) & (turned < 0.4)
    assert set(blob[near].tolist()) == {0, 1, 2}  # from each of them


def test_of_no_limb_there_is_no_guess():
    config, model = settings(), star()
    limbs = FacingLimbs(model, SpatialModel(model, RED, config.votes), config)
    poses, blob = limbs.guess(ImageFrame(LabelField(PLAIN)).faced(), [], scale_limits(config, None))
    assert not len(poses) and not len(blob)


FOOT_LABEL, FOOT = 5, rectangle(0.05, 0.02, (0.03, 0.0))


def test_a_joint_is_told_where_both_its_components_are():
    """A leg on which a foot turns; the leg's pixels are gone, and the foot alone hardly tells how the two are bent."""
    leg = Component("leg", (patch("leg", LEG),), label=LIMB, joint=hinge("middle", (0.045, 0, 0), (0, 0, 1)))
    foot = Component("foot", (patch("foot", FOOT),), label=FOOT_LABEL, joint=hinge("leg", (0.07, 0, 0), (0, 0, 1)))
    body = Component("middle", (patch("middle", rectangle(0.1, 0.06, (0.0, 0.0))),), required=True)
    target = Target("walker", ObjectModel("walker", (body, leg, foot)), RED)
    at = Placing(70.0, 80.0, 0.0, 500.0)
    labels = np.zeros((160, 200), np.uint8)
    for outline, label in ((body.markers[0].outline, RED), (LEG + (0.045, 0), LIMB), (FOOT + (0.115, 0), FOOT_LABEL)):
        labels[rendered(_Patch(at, outline, label), size=SIZE) == label] = label
    engine = Recognizer((target,), settings(time_budget_ms=60000), Segmenter(ImageConfig()))
    (whole,) = engine.recognize(labels).detections
    assert set(whole.joints) == {"leg", "foot"}
    (part,) = engine.recognize(np.where(labels == LIMB, 0, labels).astype(np.uint8)).detections
    assert {"middle", "foot"} == {c.component for c in part.components} and not part.joints


@dataclass(frozen=True)
class _Patch:
    """One patch of a placed object."""

    at: Placing
    outline: np.ndarray
    label: int

    def patches(self):
        return [(self.at.at(self.outline), self.label)]

"""Flat objects that are found from the blobs of their limbs: their required component is merged, hidden or not seen."""

from dataclasses import replace

import numpy as np
import test_facing_limbs
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
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.recognizer import Recognizer

LIMB, SIZE = 4, (200, 160)
ANGLES = {"one": 0.3, "two": 2.1, "three": 4.4}
ROUND = np.column_stack([np.cos(np.arange(8) * np.pi / 4), np.sin(np.arange(8) * np.pi / 4)]) * 0.04
LEG, LONG = rectangle(0.06, 0.02, (0.035, 0.0)), rectangle(0.08, 0.03, (0.045, 0.0))


def star():
    """An octagon, which hardly tells its turn, and three legs of another class that swing about its rim."""
    legs = [
        Component(
            name, (patch(name, LEG),), label=LIMB,
            joint=hinge("middle", (0.045 * np.cos(a), 0.045 * np.sin(a), 0.0), (0, 0, 1), limits=(a - 0.4, a + 0.4)),
        )
        for name, a in ANGLES.items()
    ]  # fmt: skip
    return ObjectModel("star", (Component("middle", (patch("middle", ROUND),), required=True), *legs))


class Star(Placing):
    """A star; its legs swing by `arm` from where they stand."""

    def patches(self):
        out = [(self.at(ROUND), RED)]
        for angle in ANGLES.values():
            q = angle + self.arm
            turn = np.array([[np.cos(q), np.sin(q)], [-np.sin(q), np.cos(q)]])
            out.append((self.at(LEG @ turn + 0.045 * np.array([np.cos(angle), np.sin(angle)])), LIMB))
        return out


AT = Star(90.3, 80.2, 0.7, 500.0, arm=0.2)
PLAIN = rendered(AT, size=SIZE)


def merged():
    """Half of its middle's rim is amid a bar of its class."""
    labels = PLAIN.copy()
    labels[62:100, 4:90] = np.where(labels[62:100, 4:90] == 0, RED, labels[62:100, 4:90])
    return labels


def recognized(labels, **options):
    config = settings(time_budget_ms=60000, **options)
    return Recognizer((Target("star", star(), RED),), config, Segmenter(ImageConfig())).recognize(labels)


def error(detection):
    """Pixels, degrees, share."""
    turn = np.degrees(np.angle(np.exp(1j * (-detection.image.theta - AT.turn))))
    off = np.hypot(detection.image.x - AT.x, detection.image.y - AT.y)
    return off, abs(turn), abs(np.log(detection.image.scale / AT.scale))


def test_a_plain_one_is_found():
    (found,) = recognized(PLAIN).detections
    assert error(found) < (1.0, 3.0, 0.05) and len(found.components) == 4


def test_legs_tell_where_a_body_is_that_merged_with_others_of_its_class(monkeypatch):
    (found,) = recognized(merged()).detections
    off, turn, scale = error(found)
    assert off < 4.0 and turn < 6.0 and scale < 0.1
    monkeypatch.setattr(FacingSearch, "limbs", lambda *args: [])
    assert not recognized(merged()).detections


def test_one_without_labels_on_its_required_component_is_found_where_that_is_no_matter(monkeypatch):
    monkeypatch.setattr(test_facing_limbs, "LEG", rectangle(0.08, 0.03, (0.045, 0.0)))  # they show more than the middle
    plain = rendered(AT, size=SIZE)
    faded = np.where(plain == RED, 0, plain)
    assert not recognized(faded).detections
    every = replace(settings().facing, limb_keep=1000)
    (found,) = recognized(faded, required="visible", facing=every).detections
    off, turn, scale = error(found)
    assert off < 2.0 and turn < 3.0 and scale < 0.05
    assert {c.component for c in found.components} == set(ANGLES)  # what is not seen is not told
    assert found.score < recognized(plain).detections[0].score
    other = np.where(plain == RED, BODY, plain)  # something else is where its middle should be
    assert all(error(d)[0] > 20 for d in recognized(other, required="visible", facing=every).detections)


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

"""First hypotheses of objects: from the required component's blob, and from the other components'."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import BODY, RED, camera_of, chain, pose, random_poses, render, truck, turn_between

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.guesses import Guesser
from artrec_ros.core.pose.seeds import Seeds
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.recognizer import Recognizer

CAMERA = camera_of()
TRUCK = truck()
AT = pose(0.02, 0.0, 0.6, 0.4, model=TRUCK, joints={"fore": 0.5, "hind": -0.3})


def seeds_of(labels, which, blob_of, deadline=None, config=DEFAULTS):
    target = Target("truck", TRUCK, RED)
    seeds = Seeds(target, SpatialModel(TRUCK, RED, config.votes), config)
    blobs = find_blobs(labels, {RED}, RecognizerConfig())
    frame = ImageFrame(LabelField(labels), CAMERA, deadline or Deadline())
    return getattr(seeds, which)(frame, blob_of(blobs))


def largest(blobs):
    return max(blobs, key=lambda b: b.area_px)


def smallest(blobs):
    return min(blobs, key=lambda b: b.area_px)


def near(poses, truth, place=0.08, turn=0.35):
    """How many hypotheses are near enough for a search to reach the truth."""
    close = np.linalg.norm(poses.t - truth.t, axis=1) < place * truth.t[0, 2]
    return sum(turn_between(R, truth.R[0]) < turn for R in poses.R[close])


@pytest.mark.parametrize("which", ["few", "all"])
def test_the_required_components_blob_tells_where_the_object_is(which):
    found = seeds_of(render(CAMERA, [(TRUCK, AT, RED)]), which, largest)
    assert near(found, AT, 0.03, 0.2)
    if which == "few":
        assert len(found) <= 10


def test_another_components_blob_tells_it_too_but_not_at_first_sight():
    labels = render(CAMERA, [(TRUCK, AT, RED)])
    assert not near(seeds_of(labels, "few", smallest), AT)
    assert near(seeds_of(labels, "all", smallest), AT)


@pytest.mark.parametrize("which", ["few", "all"])
def test_without_time_nothing_is_guessed(which):
    assert not len(seeds_of(render(CAMERA, [(TRUCK, AT, RED)]), which, largest, Deadline(0.0)))


def test_a_speck_is_no_object_in_plain_view():
    """Its required component alone has too few votes for an object."""
    labels = np.full((240, 320), BODY, np.uint8)
    labels[100:103, 100:103] = RED
    assert len(seeds_of(labels, "few", largest, config=settings(min_votes=0.0)))
    assert not len(seeds_of(labels, "few", largest))


@pytest.mark.parametrize("which", ["few", "all"])
@pytest.mark.parametrize(
    "out, within",
    [
        ({"max_range_m": 0.25}, {"max_range_m": 0.65}),
        ({"min_range_m": 1.5}, {"min_range_m": 0.55}),
        ({"min_scale": 1200.0}, {"min_scale": 450.0}),
        ({"max_scale": 200.0}, {"max_scale": 560.0}),
    ],
)
def test_guesses_out_of_reach_are_left_out(which, out, within):
    """The object stands at 0.6 m, where a metre is 500 px; a fit moves guesses, but not from half or twice as far."""
    labels = render(CAMERA, [(TRUCK, AT, RED)])
    assert not near(seeds_of(labels, which, largest, config=settings(**out)), AT)
    assert near(seeds_of(labels, which, largest, config=settings(**within)), AT)


@pytest.mark.parametrize("label, asked", [(RED, 3), (RED + 1, 1)])
def test_only_components_of_its_class_are_sought_in_a_blob(monkeypatch, label, asked):
    parts = tuple(c if c.required else replace(c, label=label) for c in TRUCK.components)
    model, guess, count = replace(TRUCK, components=parts), Guesser.guess, []
    monkeypatch.setattr(Guesser, "guess", lambda self, *args: count.append(self.labels) or guess(self, *args))
    labels = render(CAMERA, [(TRUCK, AT, RED)])
    blobs = find_blobs(labels, {RED}, RecognizerConfig())
    frame = ImageFrame(LabelField(labels), CAMERA)
    Seeds(Target("truck", model, RED), SpatialModel(model, RED, DEFAULTS.votes), DEFAULTS).all(frame, smallest(blobs))
    assert count == [(RED,)] * asked


@pytest.mark.parametrize("component", ["base", "arm", "finger"])
def test_bending_leaves_a_component_where_it_is(component):
    model = chain()
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    c = [p.name for p in model.components].index(component)
    guesser, kin = Guesser(model, surface, c, DEFAULTS), surface.kinematics
    rest = random_poses(np.random.default_rng(2), model, 4)
    rest.q[:] = (kin.lower + kin.upper) / 2
    bent = guesser.bends.of(rest)
    n = len(bent) // len(rest)
    assert (n > 5) == (component != "base")
    was, now = (kin.forward(p.R, p.t, p.q) for p in (rest, bent))
    np.testing.assert_allclose(now.R[:, c], np.repeat(was.R[:, c], n, axis=0), atol=1e-9)
    np.testing.assert_allclose(now.t[:, c], np.repeat(was.t[:, c], n, axis=0), atol=1e-9)
    assert (bent.q >= kin.lower - 1e-9).all() and (bent.q <= kin.upper + 1e-9).all()
    moved = bent.q[:n].std(axis=0) > 0.2 * (kin.upper - kin.lower)
    np.testing.assert_array_equal(moved, kin.moves[c])


OTHER = 7


def test_a_component_of_another_class_leads_to_it_where_the_required_one_may_be_near():
    two = replace(TRUCK, components=tuple(replace(c, label=None if c.required else OTHER) for c in TRUCK.components))
    labels = render(CAMERA, [(two, AT, RED)])
    seeds = Seeds(Target("truck", two, RED), SpatialModel(two, RED, DEFAULTS.votes), DEFAULTS)
    limbs, roots = (find_blobs(labels, {label}, RecognizerConfig()) for label in (OTHER, RED))
    limb, root = largest(limbs), largest(roots)
    assert near(seeds.all(ImageFrame(LabelField(labels), CAMERA), limb), AT)
    assert seeds.may_belong(limb, root)
    away = replace(root, contour=root.contour + (10 * root.area_px**0.5, 0))
    assert not seeds.may_belong(limb, away)
    assert not seeds.may_belong(replace(limb, area_px=30.0), root)  # a speck: its shape tells nothing


def test_what_speaks_of_the_required_component_is_looked_at_again_from_others(monkeypatch):
    """Where its required component's blob leads nowhere, those of other classes near by do; alone they lead nowhere
    that could be told."""
    two = replace(TRUCK, components=tuple(replace(c, label=None if c.required else OTHER) for c in TRUCK.components))
    recognizer = Recognizer([Target("truck", two, RED)], RecognizerConfig(), Segmenter(ImageConfig()))
    labels = render(CAMERA, [(two, AT, RED)])
    guess = Guesser.guess
    started = []

    def limbs_only(self, frame, blob, piece=0):
        started.append(blob.label)
        return guess(self, frame, blob, piece) if blob.label == OTHER else self._none

    monkeypatch.setattr(Guesser, "guess", limbs_only)
    assert [d.object for d in recognizer.recognize(labels, camera=CAMERA).detections] == ["truck"]
    started.clear()
    bare = np.where(labels == RED, BODY, labels).astype(np.uint8)
    assert not recognizer.recognize(bare, camera=CAMERA).detections
    assert OTHER not in started


def test_a_side_that_something_else_covers_says_little():
    """Its side is another object's, its front is seen. Of one in plain view nothing changes."""
    at = pose(0.02, 0.0, 0.6, -0.8, model=TRUCK)
    labels = render(CAMERA, [(TRUCK, at, RED)])
    seeds = Seeds(Target("truck", TRUCK, RED), SpatialModel(TRUCK, RED, DEFAULTS.votes), DEFAULTS)

    def votes(seen, hidden):
        return float(seeds._votes(ImageFrame(LabelField(seen), CAMERA), at, 0, bodies=False, hidden=hidden)[0])

    assert votes(labels, True) == pytest.approx(votes(labels, False)) and votes(labels, False) > 0
    covered, torso = labels.copy(), largest(find_blobs(labels, {RED}, RecognizerConfig()))
    side = np.arange(labels.shape[1]) < np.quantile(torso.contour[:, 0], 0.7)
    covered[(labels == RED) & side] = OTHER
    assert votes(covered, True) > votes(covered, False)

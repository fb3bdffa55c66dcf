"""Why components of a found object are not told."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import RED, RIGHT_SIDE, cabinet, camera_of, marker, pose, rectangle, render, truck

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.verdict import shown
from artrec_ros.core.verdict.acceptance import verdicts_of
from artrec_ros.core.verdict.claims import claims_of, silhouette
from artrec_ros.core.verdict.descriptions import Describer

CAMERA = camera_of()


def missing_of(model, at, frame, among=(), finder=None):
    """What is said of the components that are not told of an object, by their names."""
    finder = finder or WholeObjectFinder(Target(model.name, model, RED), DEFAULTS)
    (verdict,) = verdicts_of(claims_of(finder, at, frame))
    (detection,) = Describer(finder).describe([verdict], frame, [verdict, *among])
    told = {part.component for part in detection.components}
    lacking = {m.component: m for m in detection.missing}
    assert told | set(lacking) == {c.name for c in model.components} and not told & set(lacking)
    return lacking


def seen(*objects):
    return ImageFrame(LabelField(render(CAMERA, [(model, at, RED) for model, at in objects])), CAMERA)


def test_of_what_is_told_in_full_nothing_is_missing():
    model = truck()
    assert missing_of(model, pose(0, 0, 0.8, 0.2, model=model), seen((model, pose(0, 0, 0.8, 0.2, model=model)))) == {}


def test_a_label_that_is_not_there_is_not_seen_and_its_place_is_told():
    model = truck()
    at = pose(0, 0, 0.6, 0.1, model=model)
    frame = seen((model, at))
    labels = frame.field.labels.copy()
    labels[130:, :160] = np.where(labels[130:, :160] == RED, 0, labels[130:, :160])  # of the hind leg
    lacking = missing_of(model, at, replace(frame, field=LabelField(labels)))
    assert list(lacking) == ["hind"] and lacking["hind"].state == "not seen" and lacking["hind"].by == ""
    assert 80 < lacking["hind"].x < 160 and 130 < lacking["hind"].y < 190


def test_beyond_the_border_it_is_out_of_view():
    model = truck()
    at = pose(-0.31, 0, 0.6, 0.1, model=model)
    lacking = missing_of(model, at, seen((model, at)))
    assert lacking["hind"].state == "out of view" and lacking["hind"].x < 0


@pytest.mark.parametrize(("drawn", "state"), [(True, "out of view"), (False, "not seen")])
def test_what_is_mostly_beyond_the_border_is_not_seen_where_the_rest_does_not_bear_its_class(drawn, state):
    torso, fore, hind = truck().components
    model, without = truck(), ObjectModel("truck", (torso, fore, replace(hind, markers=())))
    at = pose(-0.22, 0, 0.6, 0.1, model=model)
    lacking = missing_of(model, at, seen((model if drawn else without, at)))
    assert list(lacking) == ["hind"] and lacking["hind"].state == state and lacking["hind"].x < 0


def test_what_another_object_covers_is_hidden_by_it():
    model = truck()
    near, far = pose(0.13, 0.07, 0.5, 0.1, model=model), pose(0.0, 0, 0.9, 0.1, model=model)
    whole = seen((model, far), (model, near))
    finder = WholeObjectFinder(Target("lorry", model, RED), DEFAULTS)
    (owner,) = verdicts_of(claims_of(finder, near, whole))
    rest = whole.without(silhouette(finder.surface, CAMERA, near))
    lacking = missing_of(model, far, rest, [owner])
    assert lacking["fore"].state == "hidden" and lacking["fore"].by == "lorry"
    untold = missing_of(model, far, rest)
    assert untold["fore"].state == "hidden" and untold["fore"].by == ""


def test_what_lies_behind_a_component_does_not_hide_it():
    """Nor is it told as what does: of two that cover its middle the one before it."""
    model = truck()
    at, near, behind = (pose(x, y, z, 0.1, model=model) for x, y, z in ((0, 0, 0.9), (0.13, 0.07, 0.5), (0.06, 0, 1.4)))
    whole = seen((model, behind), (model, at), (model, near))
    finders = [WholeObjectFinder(Target(name, model, RED), DEFAULTS) for name in ("lorry", "van")]
    owners = [verdicts_of(claims_of(f, p, whole))[0] for f, p in zip(finders, (near, behind), strict=True)]
    lacking = missing_of(model, at, whole.without(silhouette(finders[0].surface, CAMERA, near)), owners)
    assert lacking["fore"].state == "hidden" and lacking["fore"].by == "lorry"
    alone = missing_of(model, at, seen((model, at)).without(silhouette(finders[1].surface, CAMERA, behind)), owners[1:])
    assert not any(m.state == "hidden" for m in alone.values())


def test_what_its_own_body_covers_is_hidden_by_itself():
    model = cabinet()
    shut = pose(0, 0, 1.2, 0.0, model=model, joints={"drawer": 0.0})
    (drawer,) = missing_of(model, shut, seen((model, shut))).values()
    assert (drawer.state, drawer.by) == ("hidden", "itself")


def test_what_looks_away_is_turned_away():
    torso, fore, hind = truck().components
    model = ObjectModel("truck", (torso, replace(fore, markers=fore.markers[1:]), hind))
    at = pose(0, 0, 0.8, 0.2, model=model)
    (left,) = missing_of(model, at, seen((model, at))).values()
    assert (left.component, left.state) == ("fore", "turned away")


def test_pieces_of_a_pixel_are_too_small():
    model = truck()
    far = pose(0, 0, 9.0, 0.1, model=model)
    assert {m.state for m in missing_of(model, far, seen((model, far))).values()} == {"too small"}


@pytest.mark.parametrize(("wide_m", "state"), [(0.003, "too small"), (0.006, "not seen")])
def test_a_sliver_that_seams_leave_no_label_is_too_small(wide_m, state):
    torso, fore, hind = truck().components
    narrow = replace(fore, markers=(marker("outer", rectangle(wide_m, 0.12, (0, -0.08)), RIGHT_SIDE, (0, -0.0705, 0)),))
    model = ObjectModel("truck", (torso, narrow, hind))
    at = pose(0, 0, 0.8, 0.2, model=model)
    frame = seen((replace(model, components=(torso, replace(narrow, markers=()), hind)), at))
    assert missing_of(model, at, frame)["fore"].state == state


@pytest.mark.parametrize(("share", "state"), [(0.75, "in doubt"), (1.0, "not seen")])
def test_a_required_component_that_bears_some_of_its_class_is_in_doubt(share, state):
    """Without a score: that of its object is not its own."""
    model, finder = truck(), WholeObjectFinder(Target("truck", truck(), RED), settings(required="visible"))
    at = pose(0, 0, 0.6, 0.1, model=model)
    labels = seen((model, at)).field.labels.copy()
    bare = replace(model, components=tuple(c if c.required else replace(c, markers=()) for c in model.components))
    rows, columns = np.nonzero(seen((bare, at)).field.labels == RED)
    lost = columns < np.quantile(columns, share) + 1
    labels[rows[lost], columns[lost]] = 0
    (torso,) = missing_of(model, at, ImageFrame(LabelField(labels), CAMERA), finder=finder).values()
    assert (torso.component, torso.state, torso.score) == ("torso", state, 0.0)


def test_what_may_be_anothers_is_in_doubt(monkeypatch):
    model = truck()
    at = pose(0, 0, 0.8, 0.2, model=model)
    monkeypatch.setattr(shown, "part_probabilities", lambda verdicts: [{0: 0.9, 1: 0.1, 2: 0.8}])
    (fore,) = missing_of(model, at, seen((model, at))).values()
    assert (fore.component, fore.state, fore.score) == ("fore", "in doubt", 0.1)

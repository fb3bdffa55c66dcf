"""Lengths of objects from marked images: what was measured wrong with a ruler is found."""

from dataclasses import replace

import numpy as np
import pytest
from solids import SIDE_ON, camera_of, truck

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.learning.lengths import Lengths
from artrec_ros.core.learning.marked_views import Eye, Figure, Marks, markers_of
from artrec_ros.core.learning.size_fit import TooFew, measure
from artrec_ros.core.model.kinematics import Kinematics
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.pose.poses import Poses

FACED = Camera.facing((640, 480))


def bar(length, width, at=(0.0, 0.0, 0.0), name="bar"):
    outline = np.array([(0, -1), (1, -1), (1, 1), (0, 1)]) * (length, width / 2)
    return Marker(name, outline, np.zeros(2), np.array([length, 0.0]), T_component_marker=Pose(np.eye(3), np.array(at)))


def ball(radius, at):
    angles = 2 * np.pi * np.arange(24) / 24
    outline = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    ends = np.array([-radius, 0.0]), np.array([radius, 0.0])
    return Marker("ball", outline, *ends, radius, Pose(np.eye(3), np.array(at)))


def crane(mast=0.06, arm=0.08, pin=(0.05, 0.01, 0.0), radius=0.01):
    """Flat: a base, a mast that stands firmly on it, an arm that turns at its end, a ball on the arm's far end."""
    about = np.array([0.0, 0.0, 1.0])
    return ObjectModel(
        "crane",
        (
            Component("base", (bar(0.1, 0.03),), required=True),
            Component("mast", (bar(mast, 0.02, (0.02, 0.03, 0.0), "post"),)),
            Component("arm", (bar(arm, 0.015),), joint=Joint("base", Pose(np.eye(3), np.array(pin)), about, -2.0, 2.0)),
            Component(
                "hook",
                (ball(radius, (0.02, 0.0, 0.0)),),
                joint=Joint("arm", Pose(np.eye(3), np.array([arm, 0.0, 0.0])), about, -1.5, 1.5),
            ),
        ),
    )


def flat_marks(model, count, rng, noise_px=0.4):
    """Of objects that face the camera, anywhere and in any joints; a disc's ends in any direction."""
    kin, figure, discs = Kinematics(model), Figure.of(model), np.array([m.disc_radius for _, m, _ in markers_of(model)])
    out = []
    for n in range(count):
        R = rotation_from_rotvec([0, 0, rng.uniform(-np.pi, np.pi)]) @ np.diag([1.0, -1.0, -1.0])
        depth = FACED.focal_px / rng.uniform(700, 1500)
        q = rng.uniform(0.9 * kin.lower, 0.9 * kin.upper)
        ends = project(FACED, figure.ends(Poses(R[None], np.array([[0.01, 0.02, 1.0]]) * depth, q[None])))[0]
        for m in np.flatnonzero(discs != None):  # noqa: E711
            middle, half = ends[m].mean(axis=0), np.linalg.norm(ends[m, 1] - ends[m, 0]) / 2
            angle = rng.uniform(-np.pi, np.pi)
            ends[m] = middle + np.outer([-half, half], [np.cos(angle), np.sin(angle)])
        out.append(Marks(np.arange(len(ends)), ends + rng.normal(0, noise_px, ends.shape), f"annotation {n}"))
    return out


def test_lengths_of_a_flat_object_are_found_beside_its_base():
    rng = np.random.default_rng(0)
    true, guessed = crane(), crane(mast=0.07, arm=0.07, pin=(0.047, 0.014, 0.0), radius=0.012)
    measured = measure(guessed, flat_marks(true, 24, rng), None)
    assert measured.helps and measured.views == 24
    assert measured.after_px < 0.7 < 3 < measured.before_px
    found = measured.model
    np.testing.assert_array_equal(found.required.markers[0].outline, true.required.markers[0].outline)
    for name in ("mast", "arm"):
        marker, wanted = found.component(name).markers[0], true.component(name).markers[0]
        assert np.linalg.norm(marker.head) == pytest.approx(np.linalg.norm(wanted.head), rel=0.02)
    assert found.component("hook").markers[0].disc_radius == pytest.approx(0.01, rel=0.05)
    np.testing.assert_allclose(found.component("arm").joint.T_parent_joint.position, (0.05, 0.01, 0.0), atol=1.5e-3)
    post = found.component("mast").markers[0].T_component_marker
    np.testing.assert_allclose(post.position, (0.02, 0.03, 0.0), atol=1e-3)
    assert found.is_flat
    assert not measured.limits and not measured.outside  # what holds all that is marked stays
    assert [(c.joint.lower, c.joint.upper) for c in found.joint_components] == [(-2.0, 2.0), (-1.5, 1.5)]


def test_an_object_file_that_holds_is_left_alone():
    measured = measure(crane(), flat_marks(crane(), 24, np.random.default_rng(1)), None)
    assert not measured.helps and measured.before_px < 0.6


def test_one_mistaken_mark_changes_little_and_is_named():
    rng = np.random.default_rng(2)
    marks = flat_marks(crane(), 20, rng)
    wrong = marks[7].ends.copy()
    wrong[1] = wrong[1, ::-1]  # the mast's tail and head exchanged
    marks[7] = marks[7]._replace(ends=wrong)
    guessed = crane(arm=0.07)
    measured = measure(guessed, marks, None)
    assert measured.helps
    assert np.linalg.norm(measured.model.component("arm").markers[0].head) == pytest.approx(0.08, rel=0.03)
    far = measured.far[0]
    assert (far.place, far.component, far.marker) == ("annotation 7", "mast", "post") and far.off_px > 15


def with_hook(model, reach):
    """The same with its ball so far from its axis."""
    *others, hook = model.components
    return replace(model, components=(*others, replace(hook, markers=(ball(0.01, (reach, 0.0, 0.0)),))))


def test_a_joint_that_marks_do_not_determine_stays_and_is_named():
    """A ball on an elastic: a circle through where it hangs has its middle anywhere."""
    rng, true, guessed = np.random.default_rng(9), with_hook(crane(), 0.03), with_hook(crane(arm=0.07), 0.03)
    marks = flat_marks(true, 10, rng)
    loose = [m._replace(ends=m.ends + np.eye(4)[3][:, None, None] * rng.normal(0, 15, 2)) for m in marks]
    measured = measure(guessed, loose, None)
    assert measured.helps and [kept.name for kept in measured.kept] == ["hook"]
    joint, old = (model.component("hook").joint for model in (measured.model, guessed))
    np.testing.assert_array_equal(joint.T_parent_joint.position, old.T_parent_joint.position)
    assert np.linalg.norm(measured.model.component("arm").markers[0].head) == pytest.approx(0.08, rel=0.02)
    assert not measure(guessed, marks, None).kept


def test_what_is_marked_as_it_cannot_lie_is_left_out():
    marks = flat_marks(crane(), 8, np.random.default_rng(8))
    marks[3] = marks[3]._replace(ends=marks[3].ends[::-1])  # each axis where another one is
    measured = measure(crane(arm=0.07), marks, None)
    assert measured.left_out == ("annotation 3",) and measured.views == 7


def test_lengths_in_space_are_found_with_a_calibrated_camera():
    rng, true, camera = np.random.default_rng(3), truck(), camera_of((640, 480), 600.0)
    lengths = Lengths(true)
    guessed = lengths.model_of(rng.normal(0, 0.5, len(lengths.none)))
    measured = measure(guessed, views_in_space(true, camera, 40, rng), camera)
    assert measured.helps and measured.after_px < 0.4 * measured.before_px
    assert misplaced(measured.model, true) < 0.35 * misplaced(guessed, true)
    assert not measured.limits


def views_in_space(model, camera, count, rng):
    kin, figure, known = Kinematics(model), Figure.of(model), markers_of(model)
    out = []
    while len(out) < count:
        R = rotation_from_rotvec([rng.uniform(-0.4, 0.4), rng.uniform(-np.pi, np.pi), rng.uniform(-0.3, 0.3)]) @ SIDE_ON
        t, q = np.array([0.0, 0.0, rng.uniform(0.5, 0.8)]), rng.uniform(0.8 * kin.lower, 0.8 * kin.upper)
        poses = Poses(R[None], t[None], q[None])
        frames = figure.frames(poses).R
        ends = figure.ends(poses)[0]
        normals = np.array([frames[0, c] @ T.rotation[:, 2] for c, _, T in known])
        seen = np.flatnonzero(np.sum(normals * ends.mean(axis=1), axis=1) < -0.3 * np.linalg.norm(t))
        if len(seen) > 2:
            out.append(Marks(seen, project(camera, ends)[seen] + rng.normal(0, 0.3, (len(seen), 2, 2))))
    return out


def misplaced(model, true):
    """Root mean square distance of axes' ends at rest, after the best similarity."""

    def at_rest(one):
        return Figure.of(one).ends(Poses(np.eye(3)[None], np.zeros((1, 3)), np.zeros((1, len(one.joint_components)))))

    a, b = (v.reshape(-1, 3) - v.reshape(-1, 3).mean(axis=0) for v in (at_rest(model), at_rest(true)))
    U, S, V = np.linalg.svd(a.T @ b)
    return np.sqrt(np.mean(np.sum((S.sum() / np.sum(a**2) * a @ U @ V - b) ** 2, axis=1)))


def test_equal_and_mirrored_markers_keep_one_size():
    true = truck()
    lengths = Lengths(true)
    other = lengths.model_of(np.random.default_rng(4).normal(size=len(lengths.none)))
    sides = {m.name: m.area for m in other.required.markers}
    assert sides["left"] == pytest.approx(sides["right"]) == pytest.approx(true.required.markers[0].area)
    for leg in other.components[1:]:
        first, second = leg.markers
        assert first.area == pytest.approx(second.area)
        assert first.area != pytest.approx(true.component(leg.name).markers[0].area, rel=1e-3)


def test_too_few_marks_measure_nothing():
    marks = flat_marks(crane(), 3, np.random.default_rng(5))
    assert isinstance(measure(crane(), marks, None), TooFew)
    assert measure(crane(), [], None) == TooFew(0, 0, 0, ())
    alone = [replace_marks(m) for m in flat_marks(crane(), 9, np.random.default_rng(6))]
    assert measure(crane(), alone, None) == TooFew(0, 0, 0, ())


def replace_marks(marks):
    return Marks(marks.marker[:1], marks.ends[:1])


def test_what_is_flat_keeps_its_plane():
    model = crane()
    lengths = Lengths(replace(model))
    other = lengths.model_of(np.random.default_rng(7).normal(size=len(lengths.none)))
    places = [m.T_component_marker.position[2] for c in other.components for m in c.markers]
    places += [c.joint.T_parent_joint.position[2] for c in other.components if c.joint]
    assert places == [0.0] * len(places)


@pytest.mark.parametrize(("count", "placed"), [(5, True), (3, False)])
def test_the_middles_of_discs_tell_where_an_object_is_in_space(count, placed):
    at = [(0.0, 0, 0), (0.3, 0, 0.05), (0.05, 0.2, 0), (-0.1, -0.2, 0.05), (0.2, -0.25, 0)][:count]
    parts = [Component(f"c{n}", (ball(0.02, xyz),), required=n == 0) for n, xyz in enumerate(at)]
    model, camera = ObjectModel("balls", tuple(parts)), camera_of((640, 480), 600.0)
    R = rotation_from_rotvec([0.4, 0.2, 0.0]) @ np.diag([1.0, -1.0, -1.0])
    ends = project(camera, Figure.of(model).ends(Poses(R[None], np.array([[0.0, 0.0, 1.2]]), np.zeros((1, 0)))))[0]
    ends = ends.mean(axis=1, keepdims=True) + [[[-4.0, 3.0], [4.0, -3.0]]]  # in any direction
    starts = Eye(model, camera, facing=False).starts([Marks(np.arange(count), ends)])
    assert [s.near for s in starts] == [True] * placed

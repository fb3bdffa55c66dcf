from pathlib import Path

import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.kinematics import Kinematics
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.io.objects.object_writer import object_yaml, save_object

OBJECTS = Path(__file__).parents[2] / "config" / "objects"
SQUARE = np.array([[0, 0], [0.1, 0], [0.1, 0.1], [0, 0.1]])


@pytest.mark.parametrize("name", ["excavator", "quadruped", "pendulum", "vss", "mirosot"])
def test_what_is_written_is_read_back(tmp_path, name):
    model = load_object(OBJECTS / f"{name}.yaml", {"green": 4, "red": 5, "violet": 6} if name == "mirosot" else None)
    save_object(tmp_path / "copy.yaml", model, ("a comment",))
    copy = load_object(tmp_path / "copy.yaml")
    assert copy.name == model.name and copy.is_spatial == model.is_spatial and copy.is_flat == model.is_flat
    assert (copy.identities, copy.unique) == (model.identities, model.unique)
    for a, b in zip(model.components, copy.components, strict=True):
        assert (a.name, a.required, a.label, a.body_label) == (b.name, b.required, b.label, b.body_label)
        assert a.classes == b.classes
        for m, n in zip(a.markers, b.markers, strict=True):
            assert m.name == n.name and m.disc_radius == n.disc_radius
            np.testing.assert_allclose(m.outline, n.outline, atol=1e-5)
            np.testing.assert_allclose([m.tail, m.head], [n.tail, n.head], atol=1e-5)
            same(m.T_component_marker, n.T_component_marker)
        for p, q in zip(a.bodies, b.bodies, strict=True):
            same(p.T_component_box, q.T_component_box)
        if a.joint is not None:
            assert (a.joint.parent, a.joint.kind) == (b.joint.parent, b.joint.kind)
            np.testing.assert_allclose([a.joint.lower, a.joint.upper], [b.joint.lower, b.joint.upper], atol=1e-5)
            same(a.joint.T_parent_joint, b.joint.T_parent_joint)


def same(a, b):
    assert (a is None) == (b is None)
    if a is not None:
        np.testing.assert_allclose(a.position, b.position, atol=1e-5)
        np.testing.assert_allclose(a.rotation, b.rotation, atol=1e-6)


def test_a_joint_without_end_stays_so(tmp_path):
    """Though limits are written with few digits: as `continuous` joints of a URDF."""
    square = Marker("m", SQUARE, np.zeros(2), np.array([0.1, 0]), None, Pose.identity())
    wheel = Joint("base", Pose.identity(), np.array([0, 0, 1.0]), -np.pi, np.pi)
    model = ObjectModel(
        "cart", (Component("base", (square,), required=True), Component("wheel", (square,), joint=wheel))
    )
    save_object(tmp_path / "o.yaml", model)
    assert Kinematics(model).endless.tolist() == Kinematics(load_object(tmp_path / "o.yaml")).endless.tolist() == [True]


def test_names_of_shapes_that_are_taken_are_not_given_again(tmp_path):
    def named(name, k):
        return Marker(name, k * SQUARE, np.zeros(2), np.array([k * 0.1, 0]), None, Pose.identity())

    first = Component("a", (named("b_x", 1), named("x", 2)), required=True)
    save_object(tmp_path / "o.yaml", ObjectModel("o", (first, Component("b", (named("x", 3),)))))
    areas = [m.area for c in load_object(tmp_path / "o.yaml").components for m in c.markers]
    assert areas == pytest.approx([0.01, 0.04, 0.09])


def test_different_shapes_of_one_name_are_kept_apart(tmp_path):
    def named(k, name="side"):
        return Marker(
            name, k * SQUARE, np.zeros(2), np.array([k * 0.1, 0]), None, Pose.from_xyz_rpy([0, 0, k], [0.1, 0.2, 0.3])
        )

    model = ObjectModel(
        "yes", (Component("on", (named(1),), required=True), Component("1", (named(2), named(1, "two"))))
    )
    save_object(tmp_path / "o.yaml", model)
    copy = load_object(tmp_path / "o.yaml")
    assert [c.name for c in copy.components] == ["on", "1"] and copy.name == "yes"
    assert [m.area for c in copy.components for m in c.markers] == pytest.approx([0.01, 0.04, 0.01])
    assert object_yaml(model).count("outline:") == 2
    same(copy.component("1").marker("two").T_component_marker, named(1).T_component_marker)


def test_a_folder_that_is_a_file_is_told(tmp_path):
    (tmp_path / "none").touch()
    with pytest.raises(ConfigError, match="cannot be written"):
        save_object(tmp_path / "none" / "o.yaml", load_object(OBJECTS / "vss.yaml"))


def test_classes_whose_labels_are_open_cannot_be_written():
    model = load_object(OBJECTS / "mirosot.yaml")
    with pytest.raises(ConfigError, match="component 'left': the labels of its classes are not known"):
        object_yaml(model)

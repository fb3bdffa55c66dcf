import itertools

import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.design.placement import buried_markers
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.io.objects.solids import ball_solid, cylinder_solid
from artrec_ros.io.objects.urdf_model import object_from_urdf

URDF = """<robot name="truck">
  <link name="world"/>
  <joint name="w" type="fixed"><parent link="world"/><child link="base"/><origin xyz="1 2 3"/></joint>
  <link name="base"><collision><geometry><box size="0.3 0.2 0.1"/></geometry></collision></link>
  <joint name="p" type="fixed"><parent link="base"/><child link="plate"/>
    <origin xyz="0 0 0.1" rpy="0 0 1.5707963"/></joint>
  <link name="plate"><visual><geometry><box size="0.1 0.02 0.04"/></geometry></visual></link>
  <joint name="tilt" type="revolute"><parent link="plate"/><child link="mast"/><origin xyz="0 -0.1 0"/>
    <axis xyz="1 0 0"/><limit lower="-0.2" upper="0.3"/></joint>
  <link name="mast"><visual><geometry><mesh filename="a.stl"/></geometry></visual></link>
  <joint name="s" type="fixed"><parent link="mast"/><child link="sticker"/><origin xyz="0 0 0.05"/></joint>
  <link name="sticker"/>
  <joint name="lift" type="prismatic"><parent link="sticker"/><child link="fork"/><origin xyz="0 0 0.01"/>
    <axis xyz="0 0 2"/><limit lower="0" upper="0.1"/><mimic joint="tilt"/></joint>
  <link name="fork"><visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>
  <joint name="spin" type="continuous"><parent link="base"/><child link="wheel"/></joint>
  <link name="wheel"/>
</robot>"""
SQUARE = np.array([[0, 0], [0.1, 0], [0.1, 0.1], [0, 0.1]])


@pytest.fixture
def urdf(tmp_path):
    def write(text=URDF):
        (tmp_path / "truck.urdf").write_text(text)
        return tmp_path / "truck.urdf"

    return write


def stickers(*links):
    place = Pose.from_xyz_rpy([0.01, 0.02, 0.03], [0.1, 0.2, 0.3])
    marker = Marker("s", SQUARE, np.zeros(2), np.array([0.1, 0]), None, place)
    return ObjectModel("stickers", tuple(Component(link, (marker,), required=n == 0) for n, link in enumerate(links)))


def placed(model, joints):
    """T_object_marker of each component's marker, by the joints' own equation (URDF)."""
    frames, out = {}, {}
    for c in model.components:
        T = Pose.identity()
        if c.joint is not None:
            T = frames[c.joint.parent] @ c.joint.T_parent_joint
            q = joints.get(c.name, 0.0)
            if c.joint.kind == "prismatic":
                T = T @ Pose(np.eye(3), q * c.joint.axis)
            elif c.joint.kind == "revolute":
                T = T @ Pose.from_xyz_rpy([0, 0, 0], q * c.joint.axis)  # its axis is x
        frames[c.name] = T
        out[c.name] = T @ c.markers[0].T_component_marker
    return out


def test_markers_lie_where_the_links_put_them(urdf):
    made = object_from_urdf(urdf(), stickers("base", "sticker", "fork"))
    model = made.model
    assert model.name == "truck" and [c.name for c in model.components] == ["base", "sticker", "fork"]
    assert [None if c.joint is None else c.joint.kind for c in model.components] == [None, "revolute", "prismatic"]
    tilt, lift = 0.25, 0.07
    own = stickers("x").components[0].markers[0].T_component_marker
    mast = (
        Pose.from_xyz_rpy([0, 0, 0.1], [0, 0, 1.5707963])
        @ Pose.from_xyz_rpy([0, -0.1, 0])
        @ Pose.from_xyz_rpy([0, 0, 0], [tilt, 0, 0])
    )
    sticker = mast @ Pose.from_xyz_rpy([0, 0, 0.05])
    fork = sticker @ Pose.from_xyz_rpy([0, 0, 0.01 + lift])
    found = placed(model, {"sticker": tilt, "fork": lift})
    for name, T in (("base", Pose.identity()), ("sticker", sticker), ("fork", fork)):
        np.testing.assert_allclose(found[name].position, (T @ own).position, atol=1e-9)
        np.testing.assert_allclose(found[name].rotation, (T @ own).rotation, atol=1e-9)


def test_bodies_are_all_boxes_fixed_to_a_part(urdf):
    made = object_from_urdf(urdf(), stickers("base", "sticker", "fork"), "lorry", 5)
    base = made.model.component("base")
    assert made.model.name == "lorry" and base.body_label == 5
    np.testing.assert_allclose([b.T_component_box.position for b in base.bodies], [[0, 0, 0], [0, 0, 0.1]], atol=1e-12)
    assert not made.model.component("sticker").bodies
    assert any("'mast'" in n and "mesh 'a.stl' is not found: it gets no body" in n for n in made.notes)
    assert any("wheel" in n for n in made.notes) and any("'lift' mimics" in n for n in made.notes)


def test_joints_keep_their_names(urdf):
    model = object_from_urdf(urdf(), stickers("base", "sticker", "fork")).model
    assert model.joint_names == ("tilt", "lift")


def with_geometry(shape):
    return f"""<robot name="r"><link name="base"><collision><origin xyz="0.1 0 0.2" rpy="0.3 0.2 0.1"/>
    <geometry>{shape}</geometry></collision></link></robot>"""


def reach(boxes, directions):
    """(n,) how far the boxes reach from their common middle, in each direction."""
    middle = boxes[0].T_component_box.position
    signs = np.array(list(itertools.product((-1, 1), repeat=3)))
    corners = np.concatenate([b.T_component_box.apply(signs * b.size / 2) for b in boxes]) - middle
    return (directions @ corners.T).max(axis=1)


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_round_bodies_are_approximated_by_boxes_of_their_size(urdf, shape):
    text = with_geometry(f'<{shape} radius="0.05" length="0.3"/>')
    made = object_from_urdf(urdf(text), stickers("base"))
    boxes = made.model.components[0].bodies
    T = Pose.from_xyz_rpy([0.1, 0, 0.2], [0.3, 0.2, 0.1])
    np.testing.assert_allclose([b.T_component_box.position for b in boxes], [T.position] * len(boxes), atol=1e-12)
    rng = np.random.default_rng(0)
    around = rng.normal(size=(500, 3)) * (1, 1, shape == "sphere")
    around = around / np.linalg.norm(around, axis=1, keepdims=True) @ T.rotation.T
    found = reach(boxes, around)
    assert found.min() > 0.875 * 0.05 and found.max() < 1.125 * 0.05
    if shape == "cylinder":
        assert reach(boxes, T.rotation[:, 2][None])[0] == pytest.approx(0.15)
    assert any(f"its {shape} is approximated by" in n for n in made.notes)


TRIANGLES = np.array([[[0, 0, 0], [0.2, 0, 0], [0, 0.1, 0.4]], [[0, 0, 0], [0.2, 0, 0], [0.1, -0.1, 0.1]]])


def binary_stl(triangles):
    rows = [np.zeros(3, "<f4").tobytes() + t.astype("<f4").tobytes() + b"\0\0" for t in triangles]
    return b"solid x".ljust(80) + len(rows).to_bytes(4, "little") + b"".join(rows)


def text_stl(triangles):
    corners = "".join(f"vertex {x:g} {y:g} {z:g}\n" for t in triangles for x, y, z in t)
    return f"solid x\n{corners}endsolid".encode()


@pytest.mark.parametrize("write", [binary_stl, text_stl])
@pytest.mark.parametrize("name", ["meshes/a.stl", "package://truck_description/meshes/a.STL"])
def test_a_mesh_is_approximated_by_its_bounding_box(tmp_path, write, name):
    package = tmp_path / "truck_description"
    (package / "urdf").mkdir(parents=True)
    path = (package if "://" in name else package / "urdf") / "meshes" / name.rpartition("/")[2]
    path.parent.mkdir()
    path.write_bytes(write(TRIANGLES))
    (package / "urdf" / "r.urdf").write_text(with_geometry(f'<mesh filename="{name}" scale="1 -1 0.5"/>'))
    (box,) = object_from_urdf(package / "urdf" / "r.urdf", stickers("base")).model.components[0].bodies
    np.testing.assert_allclose(box.size, [0.2, 0.2, 0.2], atol=1e-7)
    T = Pose.from_xyz_rpy([0.1, 0, 0.2], [0.3, 0.2, 0.1])
    np.testing.assert_allclose(box.T_component_box.position, T.apply([[0.1, 0, 0.1]])[0], atol=1e-7)
    np.testing.assert_allclose(box.T_component_box.rotation, T.rotation, atol=1e-9)


@pytest.mark.parametrize(
    ("content", "reason"),
    [(b"", "no STL mesh"), (b"solid x\nvertex 1 2\n", "three coordinates"), (b"solid\nvertex 0 nan 0", "no STL mesh")],
)
def test_a_mesh_that_cannot_be_read_is_told_and_left_out(tmp_path, urdf, content, reason):
    (tmp_path / "a.stl").write_bytes(content)
    made = object_from_urdf(urdf(), stickers("base", "sticker", "fork"))
    assert any(reason in n and "it gets no body" in n for n in made.notes)
    assert not made.model.component("sticker").bodies


def test_the_frame_of_the_object_is_the_first_marked_links(urdf):
    model = object_from_urdf(urdf(), stickers("plate", "fork", "sticker")).model
    assert model.components[0].name == "plate" and model.components[0].joint is None
    np.testing.assert_allclose(model.components[0].bodies[0].T_component_box.position, [0, 0, -0.1], atol=1e-9)
    np.testing.assert_allclose(model.component("sticker").joint.T_parent_joint.position, [0, -0.1, 0], atol=1e-9)


def test_two_marked_links_fixed_to_each_other_stay_fixed(urdf):
    model = object_from_urdf(urdf(), stickers("base", "plate")).model
    assert model.component("plate").joint.kind == "fixed"
    np.testing.assert_allclose(model.component("plate").joint.T_parent_joint.position, [0, 0, 0.1])


@pytest.mark.parametrize(("shape", "solid"), [("sphere", ball_solid), ("cylinder", None)])
def test_what_is_a_ball_or_a_tube_of_one_colour_is_its_own_body(urdf, shape, solid):
    """Boxes that stand for the same would hide its sides; those of a rod on it are there."""
    origin, rod = '<origin xyz="0 0 0.1"/>', '<box size="0.02 0.02 0.6"/>'
    geometry = f'<{shape} radius="0.05" length="0.2"/></geometry></collision><collision><geometry>{rod}'
    text = URDF.replace('<collision><geometry><box size="0.3 0.2 0.1"/>', f"<collision>{origin}<geometry>{geometry}")
    at = Pose.from_xyz_rpy((0, 0, 0.1))
    sides, bodies = cylinder_solid(0.05, 0.2, at) if solid is None else solid(0.05, at)
    own = ObjectModel("own", (Component("base", sides, required=True, bodies=bodies),))
    read = object_from_urdf(urdf(text), own)
    (base,) = read.model.components
    assert [b.size.tolist() for b in base.bodies[: len(bodies)]] == [b.size.tolist() for b in bodies]
    assert ([0.02, 0.02, 0.6] in [b.size.tolist() for b in base.bodies]) == (shape != "sphere")  # of which it tells
    assert any("what is beside the ball 'base' hides nothing" in n for n in read.notes) == (shape == "sphere")
    assert not buried_markers(ObjectModel("own", (base,)))


@pytest.mark.parametrize(
    ("links", "change", "message"),
    [
        (("base", "mats"), ("", ""), "no link 'mats'; did you mean 'mast'"),
        (("base", "fork"), ("", ""), "'fork' hangs on 'mast', which bears no marker"),
        (("wheel", "fork"), ("", ""), "put a marker on 'mast', or make one of the two joints fixed"),
        (("base",), ('type="prismatic"', 'type="planar"'), "joint 'lift': type 'planar' is not supported"),
        (("base",), ('lower="0" upper="0.1"', 'lower="1" upper="0.1"'), "lower limit 1 must be below"),
        (("base",), ('<limit lower="0" upper="0.1"/>', ""), "limit: this element is missing"),
        (("base",), ('xyz="0 0 2"', 'xyz="0 0 0"'), "its length is zero"),
        (("base",), ('xyz="0 0 0.05"', 'xyz="0 nan 0"'), "needs 3 number"),
        (
            ("base",),
            ('lower="0" upper="0.1"', 'lower="-${pi}" upper="0.1"'),
            r"lower: '-\$\{pi\}' is xacro's; .* xacro ROBOT",
        ),
        (("base",), ('<parent link="world"/>', '<parent link="fork"/>'), "form a ring"),
        (("base",), ("<robot", "<model"), "no valid URDF"),
        (("base",), ("</robot>", '<x:p xmlns:x="http://www.ros.org/wiki/xacro"/></robot>'), "xacro"),
    ],
)
def test_what_cannot_be_is_refused(urdf, links, change, message):
    with pytest.raises(ConfigError, match=message):
        object_from_urdf(urdf(URDF.replace(*change)), stickers(*links))

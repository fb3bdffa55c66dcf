"""Object files: what is read, and that each mistake is refused by its key."""

from __future__ import annotations

import re
import struct
import time
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from changes import changed

from artrec_ros.core.alignment.shapes import Shape
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.transforms import rotation_from_rotvec
from artrec_ros.core.model.surface import is_on_unknown, patches_of
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.io.objects.object_writer import object_yaml

ROOT = Path(__file__).resolve().parents[2]
GOOD: dict[str, Any] = {
    "format": "artrec_object/1",
    "name": "toy",
    "markers": {
        "flag": {"outline": [[0, 0], [0.4, 0], [0.3, 0.1], [0.4, 0.2], [0, 0.2]], "axis": [[0, 0.1], [0.3, 0.1]]},
        "back": {"mirror_of": "flag"},
        "bar": {"rectangle": {"width": 0.02, "height": 0.1}},
        "dot": {"disc": {"radius": 0.05}},
    },
    "components": {
        "base": {
            "required": True,
            "markers": {
                "flag": {"pose": {"xyz": [0, 0, 1], "rpy": [0, 0, 0]}},
                "back": {"pose": {"rpy": [0, 3.1416, 0]}},
            },
            "body": {"label": 5, "boxes": [{"xyz": [0, 0, 0.5], "size": [0.1, 0.2, 0.3]}]},
        },
        "arm": {
            "label": 4,
            "markers": {
                "dot": {"pose": {}},
                "far": {"marker": "bar", "pose": {"x_axis": [0, 2, 0], "y_axis": [0, 0, 1]}},
            },
            "joint": {"parent": "base", "origin": {"xyz": [0.1, 0, 0]}, "axis": [0, 3, 0], "limits": [-1, 1]},
        },
    },
}


def _write(folder: Path, content: dict[str, Any]) -> Path:
    path = folder / "toy.yaml"
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    return path


def test_everything_in_a_file_is_read(tmp_path: Path) -> None:
    model = load_object(_write(tmp_path, GOOD), {})
    base, arm = model.components
    assert (model.name, base.name, arm.name, base.required, arm.required) == ("toy", "base", "arm", True, False)
    flag, back = base.markers
    assert flag.area == pytest.approx(back.area)
    assert np.allclose(sorted(map(tuple, flag.outline * (-1, 1))), sorted(map(tuple, back.outline)))
    assert np.allclose(back.tail, flag.tail * (-1, 1)) and np.allclose(back.head, flag.head * (-1, 1))
    assert flag.T_component_marker is not None and np.allclose(flag.T_component_marker.position, [0, 0, 1])
    dot, far = arm.markers
    assert dot.disc_radius == 0.05 and far.name == "far" and far.disc_radius is None
    assert np.allclose(far.tail, [0, -0.05]) and np.allclose(far.head, [0, 0.05])  # along the longer side
    assert np.allclose(far.T_component_marker.rotation[:, 2], [1, 0, 0])  # y cross z
    assert arm.label == 4 and base.label is None and base.body_label == 5
    assert np.allclose(base.bodies[0].size, [0.1, 0.2, 0.3])
    assert (
        arm.joint is not None
        and np.allclose(arm.joint.axis, [0, 1, 0])
        and (arm.joint.lower, arm.joint.upper) == (-1, 1)
    )
    assert model.is_spatial


BOW = [[0, 0], [1, 1], [1, 0], [0, 1]]


@pytest.mark.parametrize(
    ("change", "value", "parts"),
    [
        ("nam", "x", ("nam: unknown key", "'name'")),
        ("name", None, ("name", "missing")),
        ("name", "../../x", ("object '../../x'", "a name has 1 to 80 letters")),
        ("name", "<script>alert(1)</script>", ("a name has", "digits, '_' and '-'")),
        ("name", "two\nlines", (r"object 'two\nlines'", "a name has")),
        ("markers/..", {"disc": {"radius": 1}}, ("markers...", "marker '..'", "a name has")),
        ("components/", {"markers": {"flag": {}}}, ("components.", "component ''", "a name has")),
        ("components/a\nb", {"markers": {"flag": {}}}, (r"components.'a\nb'", "component", "a name has")),
        ("components/" + "x" * 81, {"markers": {"flag": {}}}, ("component", "a name has")),
        ("components/base/markers/<b>", {"marker": "flag"}, ("markers.<b>", "marker '<b>'", "a name has")),
        ("markers/flag/outline", [[0, 0], [1e200, 0], [0, 1]], ("outline[1][0]", "greatest value 1000")),
        ("markers/flag/outline", [[0, 0], [1, 0], [-1e308, 1]], ("outline[2][0]", "least value -1000")),
        ("markers/dot/disc/radius", 1e200, ("disc.radius", "greatest value 1000")),
        ("components/arm/joint/axis", [1e308, 0, 0], ("joint.axis[0]", "greatest value")),
        ("components/arm/joint/limits", [-1e308, 1e308], ("joint.limits[0]", "least value")),
        ("markers", None, ("markers", "missing")),
        ("components", {}, ("components", "exactly one")),
        ("markers/flag/outline", BOW, ("markers.flag.outline", "crosses itself", "point 0", "point 2")),
        ("markers/flag/outline", [[0, 0], [1, 0]], ("markers.flag.outline", "3 points")),
        ("markers/flag/outline", [[0, 0], [1, 0], [1, 0], [0, 1]], ("markers.flag.outline", "point 1")),
        ("markers/flag/outline", [[0, 0], [1, "a"], [1, 1]], ("markers.flag.outline[1][1]", "number")),
        ("markers/flag/outline", [[0, 0], [0.1, 0], [0.2, 0]], ("markers.flag",)),
        ("markers/flag/axis", None, ("markers.flag", "axis", "missing")),
        ("markers/flag/axis", [[0, 0], [0, 0]], ("markers.flag", "same point")),
        ("markers/flag/axis", [[0, 0]], ("markers.flag.axis", "2 points")),
        ("markers/flag/disc", {"radius": 1}, ("markers.flag", "exactly one")),
        ("markers/dot/disc/radius", 0, ("markers.dot.disc.radius", "greater than 0")),
        ("markers/dot/disc/radius", True, ("markers.dot.disc.radius", "number")),
        ("markers/dot/disc/radios", 1, ("markers.dot.disc.radios", "'radius'")),
        ("markers/back/mirror_of", "flg", ("markers.back.mirror_of", "'flag'")),
        ("markers/back/axis", [[0, 0], [1, 1]], ("markers.back.axis", "unknown key")),
        ("components/base/required", None, ("components", "exactly one")),
        ("components/base/required", "yes", ("components.base.required", "true or false")),
        ("components/base/markers", {}, ("components.base.markers",)),
        ("components/base/markers/flg", {}, ("components.base.markers.flg", "'flag'")),
        ("components/base/markers/flag/pose/xyz", [0, 0], ("components.base.markers.flag.pose.xyz", "3 numbers")),
        ("components/base/markers/flag/pose/x_axis", [1, 0, 0], ("components.base.markers.flag.pose", "y_axis")),
        ("components/arm/markers/far/pose/y_axis", [0, 1, 0.1], ("far.pose.y_axis", "right angle")),
        ("components/arm/markers/far/pose/y_axis", [0, 0, 0], ("far.pose.y_axis", "length is zero")),
        ("components/arm/label", 0, ("components.arm.label", "least value 1")),
        ("components/arm/label", 253, ("components.arm.label", "greatest value 252")),
        ("classes", {"paper": 255}, ("classes.paper", "greatest value 252")),
        ("components/arm/label", "gren", ("components.arm.label", "'gren'", "'green'")),
        ("components/arm/joint/parent", "bas", ("components", "'bas'")),
        ("components/arm/joint/limits", [1, -1], ("components.arm.joint.limits", "below")),
        ("components/arm/joint/limits", None, ("components.arm.joint", "limits", "missing")),
        (
            "components/arm/joint/name",
            "a\nb",
            ("components.arm.joint.name", "joint 'a\\nb': a name has"),
        ),
        ("components/arm/joint/axis", [0, 0, 0], ("components.arm.joint.axis",)),
        ("components/arm/joint/type", "ball", ("components.arm.joint.type", "revolute")),
        (
            "components/base/body/boxes",
            [{"size": [1, 1, 0]}],
            ("components.base.body.boxes[0].size[2]", "greater than 0"),
        ),
        ("components/base/body/boxes", None, ("components.base.body", "boxes or urdf")),
        ("components/base/body/label", "pale", ("components.base.body.label", "'pale'")),
    ],
)
def test_mistakes_are_refused_by_their_key(tmp_path: Path, change: str, value: Any, parts: tuple[str, ...]) -> None:
    path = _write(tmp_path, changed(GOOD, change, value))
    with pytest.raises(ConfigError) as caught:
        load_object(path, {"green": 3})
    message = str(caught.value)
    assert str(path) in message and "\n" not in message
    for part in parts:
        assert part in message


def test_class_names_resolve_and_the_callers_go_first(tmp_path: Path) -> None:
    content = changed(GOOD, "components/arm/label", "green")
    content["components"]["base"]["body"]["label"] = "pale"
    content["classes"] = {"green": 9, "pale": 7}
    model = load_object(_write(tmp_path, content), {"green": 3})
    assert (model.component("arm").label, model.component("base").body_label) == (3, 7)


def test_class_names_may_stay_open_where_labels_do_not_matter(tmp_path: Path) -> None:
    assert load_object(_write(tmp_path, changed(GOOD, "components/arm/label", "green"))).component("arm").label is None


URDF = """<robot name="r"><link name="body">
<collision><origin xyz="0 0 0.1" rpy="0 0 1.5707963"/><geometry><box size="0.4 0.2 0.1"/></geometry></collision>
<visual><geometry><mesh filename="x.dae"/></geometry></visual></link>
<link name="meshed"><visual><geometry><mesh filename="x.dae"/></geometry></visual></link><link name="bare"/>
<link name="cone"><visual><geometry><cone radius="1"/></geometry></visual></link></robot>"""


def test_body_from_urdf(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(URDF)
    content = changed(GOOD, "components/base/body", {"urdf": {"file": "r.urdf", "link": "body"}})
    (box,) = load_object(_write(tmp_path, content)).component("base").bodies
    assert np.allclose(box.T_component_box.position, [0, 0, 0.1])
    assert np.allclose(box.T_component_box.apply(box.size[None] / 2), [[-0.1, 0.2, 0.15]])


@pytest.mark.parametrize(
    ("urdf", "reason"),
    [
        ({"file": "r.urdf", "link": "bdy"}, "'body'"),
        ({"file": "r.urdf", "link": "meshed"}, "'x.dae' is not found; list the body's boxes"),
        ({"file": "r.urdf", "link": "cone"}, "'cone' is no body"),
        ({"file": "r.urdf", "link": "bare"}, "no geometry"),
        ({"file": "none.urdf", "link": "body"}, "no such file"),
        ({"file": "toy.yaml", "link": "body"}, "URDF"),
    ],
)
def test_bad_urdf_is_refused(tmp_path: Path, urdf: dict[str, str], reason: str) -> None:
    (tmp_path / "r.urdf").write_text(URDF)
    path = _write(tmp_path, changed(GOOD, "components/base/body", {"urdf": urdf}))
    with pytest.raises(ConfigError, match=reason):
        load_object(path)


def test_a_joint_can_have_a_name_of_its_own_and_has_its_components_else(tmp_path: Path) -> None:
    assert load_object(_write(tmp_path, GOOD)).joint_names == ("arm",)
    named = load_object(_write(tmp_path, changed(GOOD, "components/arm/joint/name", "shoulder")))
    assert named.joint_names == ("shoulder",) and named.component("arm").joint.name == "shoulder"
    (tmp_path / "again.yaml").write_text(object_yaml(named))
    assert load_object(tmp_path / "again.yaml").joint_names == ("shoulder",)


def test_silhouette_is_found_beside_the_file(tmp_path: Path) -> None:
    image = np.zeros((60, 90), np.uint8)
    image[20:40, 15:75] = 255
    cv2.imwrite(str(tmp_path / "s.png"), image)
    content = changed(GOOD, "markers/dot", {"silhouette": {"image": "s.png", "width": 0.6}})
    dot = load_object(_write(tmp_path, content)).component("arm").markers[0]
    assert dot.area == pytest.approx(0.12, rel=0.02)  # the blur rounds corners
    assert np.allclose(dot.tail, [-0.3, 0], atol=1e-6) and np.allclose(dot.head, [0.3, 0], atol=1e-6)
    content = changed(GOOD, "markers/dot", {"silhouette": {"image": "t.png", "width": 0.6}})
    with pytest.raises(ConfigError, match="markers.dot.silhouette.image.*t.png"):
        load_object(_write(tmp_path, content))


@pytest.mark.parametrize("path", sorted((ROOT / "config" / "objects").glob("*.yaml")), ids=lambda p: p.stem)
def test_shipped_objects_load(path: Path) -> None:
    assert load_object(path).components


def test_the_documented_example_loads(tmp_path: Path) -> None:
    text = re.search(r"```yaml\n(.*?)```", (ROOT / "docs" / "object_file.md").read_text(), re.S)
    assert text is not None
    image = np.full((50, 50), 255, np.uint8)
    cv2.circle(image, (25, 25), 15, 0, -1)
    cv2.imwrite(str(tmp_path / "logo.png"), image)
    (tmp_path / "crane.yaml").write_text(text[1])
    model = load_object(tmp_path / "crane.yaml", {})
    assert model.is_spatial and model.component("base").body_label == 5


def test_a_silhouette_of_an_implausible_size_is_not_decoded(tmp_path: Path) -> None:
    head = struct.pack(">IIBBBBB", 30000, 30000, 8, 0, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(bytes(100))), (b"IEND", b"")]
    packed = [struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in chunks]
    (tmp_path / "huge.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(packed))
    content = changed(GOOD, "markers/flag", {"silhouette": {"image": "huge.png", "width": 0.1}})
    with pytest.raises(ConfigError, match="silhouette.image.*30000x30000 pixels is implausible"):
        load_object(_write(tmp_path, content))


def test_a_fine_outline_is_read_at_once_and_one_too_fine_is_refused(tmp_path: Path) -> None:
    angle = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
    radius = 0.1 + 0.01 * np.cos(7 * angle)
    outline = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]).tolist()
    content = changed(GOOD, "markers/flag/outline", outline)
    begun = time.process_time()
    model = load_object(_write(tmp_path, content))
    shape = Shape.from_marker(model.components[0].markers[0])
    assert time.process_time() - begun < 5  # it took 44 s
    assert shape.area_m2 == pytest.approx(np.pi * (0.1**2 + 0.01**2 / 2), rel=1e-3)
    with pytest.raises(ConfigError, match=r"markers.flag.outline: has 8001 points, more than 5000"):
        load_object(_write(tmp_path, changed(GOOD, "markers/flag/outline", [[float(x), 0.0] for x in range(8001)])))


BOX = {"label": 4, "box": {"size": [0.2, 0.1, 0.06], "xyz": [0, 0, 0.03]}}


def test_a_box_of_one_colour_has_its_six_sides_for_markers(tmp_path: Path) -> None:
    """Each faces away from the middle, and all together cover its body."""
    content = {"format": "artrec_object/1", "name": "toy", "components": {"base": {"required": True, **BOX}}}
    model = load_object(_write(tmp_path, content), {})
    (base,), size = model.components, np.array([0.2, 0.1, 0.06])
    assert [m.name for m in base.markers] == ["front", "back", "left", "right", "top", "bottom"]
    for m, axis in zip(base.markers, (0, 0, 1, 1, 2, 2), strict=True):
        T = m.T_component_marker
        assert T is not None
        out = T.position - (0, 0, 0.03)
        np.testing.assert_allclose(T.rotation[:, 2] * size[axis] / 2, out, atol=1e-12)
        assert m.area == pytest.approx(size.prod() / size[axis])
    assert len(base.bodies) == 1 and base.body_label is None and is_on_unknown(patches_of(model, 4)) is False
    front, top = base.markers[0], base.markers[4]
    assert front.T_component_marker is not None and top.T_component_marker is not None
    np.testing.assert_array_equal(front.T_component_marker.rotation[:, 1], (0, 0, 1))  # up, as one looks at it
    np.testing.assert_array_equal(top.T_component_marker.rotation[:, 1], (0, 1, 0))
    again = tmp_path / "again.yaml"
    again.write_text(object_yaml(model))
    assert object_yaml(load_object(again, {})) == object_yaml(model)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"markers": {"dot": {"pose": {}}}}, "base.markers: a component that is a box of one colour is nothing"),
        ({"body": {"boxes": [{"size": [1, 1, 1]}]}}, "base.body: a component that is a box of one colour is nothing"),
        ({"box": {"size": [0.2, 0.1]}}, "base.box.size: needs 3 numbers"),
        ({"box": {"sise": [0.2, 0.1, 1]}}, "did you mean 'size'"),
        ({"cylinder": {"radius": 1, "length": 1}}, "base.cylinder: a component that is a box of one colour is nothing"),
        ({"body": {"boxes": []}}, "a component of its own, with its class and `joint: {parent: base, type: fixed}`"),
    ],
)
def test_what_is_wrong_with_a_box_is_named(tmp_path: Path, change: dict[str, Any], said: str) -> None:
    base = {"required": True, **BOX, **change}
    content = {**GOOD, "components": {"base": base, "arm": GOOD["components"]["arm"]}}
    with pytest.raises(ConfigError, match=re.escape(said)):
        load_object(_write(tmp_path, content), {})


def test_a_component_without_markers_is_told_what_it_may_have(tmp_path: Path) -> None:
    content = {"format": "artrec_object/1", "name": "toy", "components": {"base": {"required": True, "label": 4}}}
    with pytest.raises(ConfigError, match=r"base: markers: this key is missing.*a ball of one colour"):
        load_object(_write(tmp_path, content), {})


def test_a_cylinder_of_one_colour_is_as_wide_as_its_prism_in_the_mean(tmp_path: Path) -> None:
    """The prism's sides cover its body, and what it hides is as long and wide."""
    part = {"label": 4, "cylinder": {"radius": 0.05, "length": 0.2, "xyz": [0, 0, 0.1]}, "required": True}
    model = load_object(_write(tmp_path, {"format": "artrec_object/1", "name": "can", "components": {"can": part}}), {})
    (can,) = model.components
    sides = [m for m in can.markers if m.name.startswith("side")]
    assert sum(m.area for m in sides) / 0.2 / np.pi == pytest.approx(0.1)  # mean width: perimeter over pi
    assert [m.T_component_marker.position[2] for m in can.markers[-2:] if m.T_component_marker] == [0.2, 0.0]
    assert not is_on_unknown(patches_of(model, 4))
    directions = rotation_from_rotvec(np.linspace(0, 1, 7)[:, None] * np.array([0, 0, 0.5]))[:, :, 0]
    for out in directions:  # each point just within a side is in some box of its body
        point = np.append(0.046 * out[:2], 0.19)
        assert any((np.abs(b.T_component_box.inverse().apply(point[None])) <= b.size / 2).all() for b in can.bodies)


def test_an_only_component_is_the_required_one(tmp_path: Path) -> None:
    path = tmp_path / "ball.yaml"
    path.write_text("format: artrec_object/1\nname: ball\ncomponents:\n  ball: {ball: {radius: 0.02}}\n")
    assert load_object(path).required.name == "ball"


def test_a_ball_of_one_colour_is_a_disc_as_large_as_it(tmp_path: Path) -> None:
    part = {"label": 4, "ball": {"radius": 0.03, "xyz": [0.1, 0, 0]}, "required": True}
    model = load_object(
        _write(tmp_path, {"format": "artrec_object/1", "name": "ball", "components": {"ball": part}}), {}
    )
    again = load_object(_write(tmp_path, yaml.safe_load(object_yaml(model))), {})
    for (ball,) in (model.components, again.components):
        assert ball.ball is not None and [m.name for m in ball.markers] == ["ball"]
        assert ball.ball.radius == pytest.approx(0.03) and ball.ball.area == pytest.approx(np.pi * 0.03**2)
        np.testing.assert_allclose(ball.ball.centre, (0.1, 0, 0), atol=1e-12)
        (body,) = ball.bodies
        assert np.linalg.norm(body.size) / 2 == pytest.approx(0.03)  # its corners lie on the ball
    assert not is_on_unknown(patches_of(model, 4))

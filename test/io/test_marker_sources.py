"""Markers from drawings and pictures."""

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.objects.marker_images import image_marker
from artrec_ros.io.objects.marker_shapes import object_of, safe_name, simplified, with_sharp_corners
from artrec_ros.io.objects.svg import svg_markers

CAB = np.array([[100, 150], [600, 150], [700, 300], [600, 450], [300, 450], [250, 320], [100, 320]])
HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
DRAWING = f"""{HEAD} width="200mm" height="100mm" viewBox="0 0 200 100">
  <g id="base">
    <path id="side" fill="red" d="M 10 10 h 60 l 10 20 h -70 z"/>
    <line id="side.axis" x1="10" y1="20" x2="70" y2="20" stroke="black"/>
  </g>
  <g inkscape:label="arm" id="g12" transform="translate(100 0) rotate(90)">
    <rect x="0" y="10" width="50" height="10" id="ribbon"/>
    <circle id="tip" cx="30" cy="50" r="8"/>
    <path id="plate" d="M 0 0 h 20 v 20 h -20 z M 5 5 h 2 v 2 h -2 z"/>
  </g>
  <rect id="hidden" width="9" height="9" fill="none"/>
  <text id="words" x="1" y="1">words</text>
</svg>"""


@pytest.fixture
def drawing(tmp_path):
    pytest.importorskip("svgelements")

    def write(text, name="d.svg"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


def centred(outline):
    return outline - (outline.min(axis=0) + outline.max(axis=0)) / 2


def assert_same_corners(outline, corners, atol):
    assert len(outline) == len(corners)
    for corner in corners:
        assert np.linalg.norm(outline - corner, axis=1).min() <= atol


def test_a_drawing_gives_its_filled_shapes_in_metres(drawing):
    told: list[str] = []
    found = {(m.component, m.marker.name): m.marker for m in svg_markers(drawing(DRAWING), None, told.append)}
    assert told == ["hidden or without a fill, and so no markers: hidden"]
    assert list(found) == [("base", "side"), ("arm", "ribbon"), ("arm", "tip"), ("arm", "plate")]
    side = found["base", "side"]
    expected = centred(np.array([[10, 10], [70, 10], [80, 30], [10, 30]]) * [1e-3, -1e-3])
    assert_same_corners(side.outline, expected, 2e-5)
    np.testing.assert_allclose([side.tail, side.head], [[-0.035, 0], [0.025, 0]], atol=2e-5)
    assert np.ptp(found["arm", "ribbon"].outline, axis=0) == pytest.approx([0.01, 0.05], abs=2e-5)  # it is turned
    assert found["arm", "tip"].disc_radius == pytest.approx(0.008, rel=1e-4)
    assert found["arm", "plate"].area == pytest.approx(4e-4, rel=1e-3)  # both parts turn one way: it has no hole


def test_axes_belong_to_the_shapes_of_their_group(drawing):
    """Labels need not be unique."""
    shape, axis = (
        '<path inkscape:label="top" d="M {} 10 h 20 v 10 h -20 z"/>',
        '<path inkscape:label="top.axis" d="{}"/>',
    )
    group = f'<g id="{{}}">{shape}{axis}</g>'
    text = f'{HEAD} width="200mm" height="100mm" viewBox="0 0 200 100">' + group.format("left", 10, "M 12 15 L 28 15")
    text += group.format("right", 110, "M 120 18 L 120 12") + "</svg>"
    axes = {m.component: m.marker.head - m.marker.tail for m in svg_markers(drawing(text))}
    np.testing.assert_allclose(axes["left"], [0.016, 0], atol=1e-5)
    np.testing.assert_allclose(axes["right"], [0, 0.006], atol=1e-5)


def test_layers_are_no_components_and_hidden_shapes_no_markers(drawing):
    text = DRAWING.replace('<g id="base">', '<g id="base" inkscape:groupmode="layer" inkscape:label="Layer 1">')
    text = text.replace('id="tip"', 'id="tip" style="display:none"').replace(
        'id="plate"', 'id="plate" visibility="hidden"'
    )
    found = [(m.component, m.marker.name) for m in svg_markers(drawing(text))]
    assert found == [("side", "side"), ("arm", "ribbon")]


LAYERS = f"""{HEAD} xmlns:xlink="http://www.w3.org/1999/xlink" width="200mm" height="100mm" viewBox="0 0 200 100">
  <defs><path id="tri" d="M 0 0 h 10 v 10 z"/><g id="pair"><path id="one" d="M 0 0 h 9 v 9 z"/>
    <path id="two" d="M 20 0 h 9 v 9 z"/></g></defs>
  <g inkscape:groupmode="layer" inkscape:label="Ebene 1" id="layer9">
    <g inkscape:groupmode="layer" inkscape:label="claw" id="layer1"><g id="g33"><path id="path7" d="M 0 0 h 30 v 9 z"/>
      <use id="copy" xlink:href="#tri" x="50" y="20" fill="red"/></g></g>
    <g id="g34"><path id="loose" d="M 0 50 h 30 v 9 z"/></g>
    <use id="right" href="#pair" transform="translate(100 0) rotate(90)"/>
    <use id="lone" href="#tri" x="7"/>
  </g></svg>"""


def test_layers_and_copies_are_named_as_the_user_named_them(drawing):
    found = {(m.component, m.marker.name): m.marker for m in svg_markers(drawing(LAYERS))}
    assert list(found) == [
        ("claw", "path7"), ("claw", "copy"), ("g34", "loose"), ("right", "one"), ("right", "two"), ("lone", "lone"),
    ]  # fmt: skip
    assert np.ptp(found["claw", "copy"].outline, axis=0) == pytest.approx([0.01, 0.01], abs=2e-5)
    turned = centred(np.array([[0, 0], [0, 9], [-9, 9]]) * [1e-3, -1e-3])
    assert_same_corners(found["right", "two"].outline, turned, 2e-5)


@pytest.mark.parametrize(
    "path",
    [
        'd="M 0 0 h 20 v 20 h -20 z M 5 5 v 9 h 9 v -9 z"',
        'fill-rule="evenodd" d="M 0 0 h 20 v 20 h -20 z M 5 5 h 9 v 9 h -9 z"',
        'style="fill-rule:evenodd" d="M 5 5 h 9 v 9 h -9 z M 0 0 h 20 v 20 h -20 z"',
    ],
)
def test_a_shape_with_a_hole_is_refused(drawing, path):
    with pytest.raises(ConfigError, match=r"d\.svg: shape 'ring' has a hole; .* fill it"):
        svg_markers(drawing(f'{HEAD} width="20mm" viewBox="0 0 20 20"><path id="ring" {path}/></svg>'))


def test_a_drawings_size_can_be_given(drawing):
    without = DRAWING.replace('width="200mm" height="100mm"', "")
    with pytest.raises(ConfigError, match="--width in metres"):
        svg_markers(drawing(without))
    side = svg_markers(drawing(without), 0.4)[0].marker
    assert np.ptp(side.outline, axis=0) == pytest.approx([0.14, 0.04], rel=1e-3)
    pixels = DRAWING.replace('width="200mm" height="100mm"', 'width="400" height="200"')
    assert np.ptp(svg_markers(drawing(pixels), 0.4)[0].marker.outline[:, 0]) == pytest.approx(0.14, rel=1e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<svg", "no valid SVG"),
        ("<html/>", "root is 'html'"),
        (f'{HEAD} width="20mm"/>', "no filled shape"),
        (
            DRAWING.replace("www.w3.org/2000/svg", "www.w3.org/1999/svg"),
            'root must be <svg xmlns="http://www.w3.org/2000',
        ),
        (DRAWING.replace('width="200mm"', 'width="0mm"'), r"d\.svg: its width '0mm' is none; write one such as 200mm"),
        (f'{HEAD} width="20mm"><path id="a" d="M 0 0 L 10 10 L 10 0 L 0 5 Z"/></svg>', "'a'.*crosses itself"),
        (f'{HEAD} width="20mm"><path id="a" d="M 0 0 h 9 v 9 z M 20 0 h 9 v 9 z"/></svg>', "'a' has several parts"),
        (DRAWING.replace("</g>\n  <g ", '<path id="side.axis" d="M 0 0 h 5 v 5"/></g><g '), "one straight line"),
        (DRAWING.replace("side.axis", "sied.axis"), "'sied.axis' is of no filled shape; did you mean 'side'"),
    ],
)
def test_a_bad_drawing_is_refused(drawing, text, message):
    with pytest.raises(ConfigError, match=message):
        svg_markers(drawing(text))


@pytest.mark.parametrize("width", ["x", "0", "-5mm", "1e999"])
def test_a_drawings_width_that_is_none_is_refused_where_a_size_is_given_too(drawing, width):
    with pytest.raises(ConfigError, match=f"its width '{width}' is none"):
        svg_markers(drawing(DRAWING.replace('width="200mm"', f'width="{width}"')), 0.4)


def photo(background=(200, 210, 205), colour=(40, 30, 200), noise=4):
    image = np.full((600, 800, 3), background, np.uint8)
    cv2.fillPoly(image, [CAB], colour)
    shaded = cv2.GaussianBlur(image, (0, 0), 2) * np.linspace(0.6, 1, 800)[None, :, None]
    return np.clip(shaded + np.random.default_rng(0).normal(0, noise, image.shape), 0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    "colours", [((200, 210, 205), (40, 30, 200)), ((20, 120, 20), (30, 30, 160)), ((230,) * 3, (15,) * 3)]
)
def test_a_photo_gives_the_outline(tmp_path, colours):
    cv2.imwrite(str(tmp_path / "my photo.png"), photo(*colours))
    found = image_marker(tmp_path / "my photo.png", 0.6)
    assert found.component == found.marker.name == "my_photo"
    assert_same_corners(found.marker.outline, centred(CAB * [1e-3, -1e-3]), 4e-3)


def test_a_label_image_gives_a_classes_outline(tmp_path):
    labels = np.full((300, 400), 1, np.uint8)
    cv2.fillPoly(labels, [CAB // 2], 3)
    labels[280:290, 20:30] = 2
    cv2.imwrite(str(tmp_path / "l.png"), labels)
    for label in (None, 3):
        outline = image_marker(tmp_path / "l.png", 0.6, label).marker.outline
        assert np.ptp(outline, axis=0) == pytest.approx([0.6, 0.3], abs=6e-3)
    assert np.ptp(image_marker(tmp_path / "l.png", 0.6, 2).marker.outline[:, 1]) == pytest.approx(0.6, rel=0.02)
    with pytest.raises(ConfigError, match="no pixel is of class 7"):
        image_marker(tmp_path / "l.png", 0.6, 7)


def test_pictures_without_a_whole_shape_are_refused(tmp_path):
    for name, image, message in (
        ("plain", np.full((50, 50, 3), 90, np.uint8), "one colour only"),
        ("cut", photo()[:, :650], "touches the image's border"),
        ("one", np.full((50, 50), 3, np.uint8), "class 3 only"),
    ):
        cv2.imwrite(str(tmp_path / f"{name}.png"), image)
        with pytest.raises(ConfigError, match=message):
            image_marker(tmp_path / f"{name}.png", 0.1)
    (tmp_path / "text.png").write_text("no image")
    with pytest.raises(ConfigError, match="neither PNG, JPEG, WebP, BMP nor GIF"):
        image_marker(tmp_path / "text.png", 0.1)
    with pytest.raises(ConfigError, match="no such file"):
        image_marker(tmp_path / "none.png", 0.1)


def test_cut_corners_are_put_back_and_true_ones_are_kept():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    cut = np.array([[0.02, 0], [1, 0], [1, 1], [0, 1], [0, 0.02]])
    np.testing.assert_allclose(with_sharp_corners(cut), np.array([[1, 0], [1, 1], [0, 1], [0, 0]]), atol=1e-9)
    np.testing.assert_allclose(with_sharp_corners(square), square)
    notch = np.array([[0, 0], [1, 0], [1, 1], [0.52, 1], [0.52, 0.5], [0.48, 0.5], [0.48, 1], [0, 1]])
    assert len(with_sharp_corners(notch)) == len(notch)  # long sides that are parallel never meet


def test_a_polygon_keeps_its_corners_and_loses_points_on_its_sides():
    side = np.linspace([0, 0], [1, 0], 40, endpoint=False)
    outline = np.vstack([side, [[1, 0], [1, 1], [0, 1]]])
    assert len(simplified(outline)) == 4


@pytest.mark.parametrize(
    ("text", "name"), [("a b-c", "a_b_c"), ("1st", "m_1st"), ("é", "m"), ("fork/left", "fork_left")]
)
def test_names_fit_topics_and_keypoints(text, name):
    assert safe_name(text) == name


def test_two_markers_of_one_name_are_refused(drawing):
    twice = svg_markers(drawing(DRAWING)) * 2
    with pytest.raises(ConfigError, match="are called 'side'"):
        object_of("toy", twice)

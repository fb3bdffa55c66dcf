"""`artrec trace`: outlines measured by images in which objects are found."""

import argparse
import re

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError, SourceError
from artrec_ros.core.model.found import Detection, ImagePose, Instance
from artrec_ros.core.model.target import Target
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.tools import trace
from artrec_ros.tools.training.outline_map import Traced
from artrec_ros.tools.training.seen_outlines import SeenOutlines

LEVER = """format: artrec_object/1
name: lever
markers:
  plate:
    outline: [[-0.08, -0.02], [0.08, -0.02], [0.08, 0.02], [0.06, 0.02], [0.06, DEEP], [0.04, DEEP], [0.04, 0.02], [-0.08, 0.02]]
    axis: [[-0.08, 0], [0.08, 0]]
components:
  lever: {required: true, label: red, markers: {plate: {pose: {}}}}
"""  # noqa: E501
PARAMETERS = """/**:
  ros__parameters:
    objects: [lever]
    lever: {object_file: lever.yaml, label: 2}
    image: {kind: labels, classes: [red], red: {label: 2}}
"""
SCALE, SIZE = 700.0, (320, 240)


def run(*arguments):
    parser = argparse.ArgumentParser()
    trace.add_parser(parser.add_subparsers())
    args = parser.parse_args(["trace", *map(str, arguments)])
    return args.run(args)


def outline(deep):
    notch = [(0.06, 0.02), (0.06, 0.02 - deep), (0.04, 0.02 - deep), (0.04, 0.02)]
    return np.array([(-0.08, -0.02), (0.08, -0.02), (0.08, 0.02), *notch, (-0.08, 0.02)])


def at(points, turn, middle):
    """Pixels; `turn` is counter-clockwise in the image."""
    c, s = np.cos(turn), np.sin(turn)
    return np.asarray(points) @ np.array([[c, -s], [-s, -c]]) * SCALE + middle


def image(deep, n):
    """(H, W) class numbers of a lever with such a notch."""
    corners = at(outline(deep), 0.7 * n, (160 + 3 * n % 7, 120))
    zoom, bits = 4, 4
    large = cv2.fillPoly(
        np.zeros((zoom * SIZE[1], zoom * SIZE[0]), np.uint8),
        [(((corners + 0.5) * zoom - 0.5) * (1 << bits)).round().astype(np.int32)], 2, shift=bits,
    )  # fmt: skip
    return large[zoom // 2 :: zoom, zoom // 2 :: zoom].copy()


@pytest.fixture
def setup(tmp_path):
    """A folder with images of a deep notch, an object file with a shallow one, and parameters."""
    (tmp_path / "lever.yaml").write_text(LEVER.replace("DEEP", "0.014"))
    (tmp_path / "params.yaml").write_text(PARAMETERS)
    (tmp_path / "images").mkdir()
    for n in range(18):
        cv2.imwrite(str(tmp_path / "images" / f"{n:04d}.png"), image(0.02, n))
    return tmp_path


def test_a_notch_is_measured_and_what_holds_stays(setup, capsys):
    out, picture = setup / "seen.yaml", setup / "seen.png"
    assert run(setup / "images", "--params-file", setup / "params.yaml", "-o", out, "--picture", picture) == 0
    told = capsys.readouterr().out
    assert "lever/plate: in 18 images up to 1" in told and "In 9 finds in images that did not measure: what" in told
    measured = load_object(out, {"red": 2}).component("lever").marker("plate").outline
    inside = measured[(np.abs(measured[:, 0] - 0.05) < 0.008)]
    assert inside[:, 1] == pytest.approx(0.0, abs=0.0015)  # the notch's ground
    for corner in [(-0.08, -0.02), (0.08, -0.02), (0.08, 0.02), (-0.08, 0.02)]:
        assert np.abs(measured - corner).sum(axis=1).min() < 1e-9
    assert "label: red" in out.read_text()
    assert cv2.imread(str(picture)).shape == (360, 360, 3)


def test_what_is_drawn_as_it_is_seen_is_copied(setup, capsys):
    (setup / "lever.yaml").write_text(LEVER.replace("DEEP", "0.0"))
    assert run(setup / "images", "--params-file", setup / "params.yaml", "-o", setup / "seen.yaml") == 0
    told = capsys.readouterr().out
    assert "may be noise: it holds" in told and "holds as it is" in told
    before, after = (
        load_object(setup / name, {"red": 2}).markers["lever", "plate"] for name in ("lever.yaml", "seen.yaml")
    )
    np.testing.assert_array_equal(before.outline, after.outline)


def test_images_that_cannot_be_used_are_named_and_passed_over(setup, capsys):
    (setup / "images" / "0003.png").write_bytes(b"no picture")
    assert run(setup / "images", "--params-file", setup / "params.yaml", "-o", setup / "seen.yaml") == 0
    told = capsys.readouterr()
    assert "0003.png" in told.err and "in 17 images" in told.out
    for path in (setup / "images").iterdir():
        path.write_bytes(b"no picture")
    with pytest.raises(SourceError, match="no image that can be used"):
        run(setup / "images", "--params-file", setup / "params.yaml", "-o", setup / "none.yaml")
    assert not (setup / "none.yaml").exists()


def test_where_half_of_the_images_are_too_few_all_of_them_judge(setup, capsys):
    for path in sorted((setup / "images").iterdir())[10:]:
        path.unlink()
    assert run(setup / "images", "--params-file", setup / "params.yaml", "-o", setup / "seen.yaml") == 0
    assert "In 10 finds in images that measured, too, for 16 are too few" in capsys.readouterr().out
    measured = load_object(setup / "seen.yaml", {"red": 2}).markers["lever", "plate"].outline
    assert measured[np.abs(measured[:, 0] - 0.05) < 0.008, 1] == pytest.approx(0.0, abs=0.002)


def test_a_hole_and_images_of_one_place_are_told(setup, capsys):
    for path in (setup / "images").iterdir():
        labels = image(0.02, 0)
        cv2.circle(labels, at([(-0.03, 0.0)], 0.0, (160, 120))[0].round().astype(int).tolist(), 6, 0, -1)
        cv2.imwrite(str(path), labels)
    assert run(setup / "images", "--params-file", setup / "params.yaml", "-o", setup / "seen.yaml") == 0
    told = capsys.readouterr().out
    assert re.search(r"has a hole at x -(29|30), y -?0 mm", told) and "lies in one place in all images" in told


def test_too_few_images_measure_nothing(setup, capsys):
    for path in sorted((setup / "images").iterdir())[6:]:
        path.unlink()
    with pytest.raises(SourceError, match="nothing is measured, and nothing is written"):
        run(setup / "images", "--params-file", setup / "params.yaml", "-o", setup / "seen.yaml")
    assert "lever/plate: not measured; 8 images or more" in capsys.readouterr().out
    assert not (setup / "seen.yaml").exists()


def test_several_objects_in_an_image_are_one_image(setup, capsys):
    """Glare or a shadow in it may lie on all of them."""
    for path in sorted((setup / "images").iterdir())[6:]:
        path.unlink()
    for n, path in enumerate(sorted((setup / "images").iterdir())):
        cv2.imwrite(str(path), np.hstack([image(0.02, n), image(0.02, n + 9)]))
    with pytest.raises(SourceError, match="nothing is measured"):
        run(setup / "images", "--params-file", setup / "params.yaml", "-o", setup / "seen.yaml")
    assert "lever/plate: not measured; 8 images or more" in capsys.readouterr().out


def test_of_several_objects_one_is_chosen_and_discs_have_no_shape_to_measure(setup):
    disc = "format: artrec_object/1\nname: dot\nmarkers: {dot: {disc: {radius: 0.02}, axis: [[0, 0], [0.01, 0]]}}\n"
    (setup / "dot.yaml").write_text(disc + "components: {dot: {required: true, markers: {dot: {pose: {}}}}}\n")
    both = PARAMETERS.replace("[lever]", "[lever, dot]").replace(
        "    image:", "    dot: {object_file: dot.yaml, label: 3}\n    image:"
    )
    (setup / "params.yaml").write_text(both)
    arguments = setup / "images", "--params-file", setup / "params.yaml", "-o", setup / "seen.yaml"
    with pytest.raises(ConfigError, match="--object: the parameters have several"):
        run(*arguments)
    with pytest.raises(ConfigError, match=r"none of the parameters' objects \(lever, dot\)"):
        run(*arguments, "--object", "lamp")
    with pytest.raises(ConfigError, match="no flat marker but discs"):
        run(*arguments, "--object", "dot")


def test_what_another_marker_lies_on_stays_as_it_is_drawn(setup):
    """In all images something of another class lies on one end, and was found there."""
    model = load_object(setup / "lever.yaml", {"red": 2})
    target, seen = Target("lever", model, 2), SeenOutlines(model)
    for n in range(12):
        turn, middle = 0.5 * n, np.array([160.0, 120.0])
        labels = cv2.fillPoly(
            np.zeros(SIZE[::-1], np.uint8), [at(outline(0.006), turn, middle).round().astype(np.int32)], 2
        )
        cover = at([(-0.09, -0.03), (-0.05, -0.03), (-0.05, 0.03), (-0.09, 0.03)], turn, middle)
        cv2.fillPoly(labels, [cover.round().astype(np.int32)], 5)
        own = Instance(
            "lever", "plate", 0.9, *middle, -turn, SCALE, at(model.markers["lever", "plate"].outline, turn, middle)
        )
        other = Instance("cover", "cover", 0.9, *middle, 0.0, SCALE, cover)
        found, beside = (
            Detection(name, 0, 0.9, ImagePose(*middle, -turn, SCALE), (part,))
            for name, part in (("lever", own), ("cover", other))
        )
        seen.add(n, labels, None, target, found, [found, beside])
    (traced,) = seen.traced().values()
    assert not traced.differs and traced.images == 12


@pytest.mark.parametrize("others", [0, 1])
def test_a_lone_marker_keeps_its_length_where_it_was_drawn_too_narrow(setup, others):
    """Found by its sides it seems larger than it is, and was measured too short; of several distances tell the size."""
    text = LEVER.replace("DEEP", "0.014")
    if others:
        text += "  end: {label: blue, markers: {end: {marker: plate, pose: {xyz: [0.3, 0, 0]}}}}\n"
    (setup / "lever.yaml").write_text(text)
    target = Target("lever", load_object(setup / "lever.yaml", {"red": 2, "blue": 3}), 2)
    drawn, seen, wide = target.model.markers["lever", "plate"].outline, SeenOutlines(target.model), 1.25
    for n in range(12):
        turn, middle = 0.5 * n, np.array([160.0, 120.0])
        true = at(drawn * (1, wide), turn, middle).round().astype(np.int32)
        labels = cv2.fillPoly(np.zeros(SIZE[::-1], np.uint8), [true], 2)
        found_as = at(wide * drawn, turn, middle)
        own = Instance("lever", "plate", 0.9, *middle, -turn, wide * SCALE, found_as)
        found = Detection("lever", 0, 0.9, ImagePose(*middle, -turn, wide * SCALE), (own,))
        seen.add(n, labels, None, target, found, [found])
    traced = next(t for t in seen.traced().values())
    length, width = np.ptp(traced.outline, axis=0)
    assert length == pytest.approx(0.16 if not others else 0.16 / wide, rel=0.05)
    assert length / width == pytest.approx(0.16 / (0.04 * wide), rel=0.05)


def test_axes_whose_ends_come_to_lie_outside_are_named(setup):
    """An axis may leave its marker where it is drawn so; not because its outline is measured."""
    model = load_object(setup / "lever.yaml", {"red": 2})
    drawn = model.markers["lever", "plate"]

    def told(outline):
        rest = {"off_m": 0.02, "at": np.zeros(2), "least_m": 0.001, "hole": None, "in_one_place": False}
        picture = {"level": np.zeros((2, 2), np.uint8), "zoom": 1.0, "corner": np.zeros(2)}
        seen = Traced(drawn, 9, outline, **rest, **picture)
        return [line for line in trace._lines(model, {drawn.outline.tobytes(): seen}) if "axis" in line]

    assert told(drawn.outline) == []
    (line,) = told(drawn.outline * (0.75, 1.0))
    assert "lever/plate" in line and "20 mm" in line

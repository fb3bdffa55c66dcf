"""`artrec model`: object files made from drawings and pictures, and how the command is used."""

import cv2
import numpy as np
import pytest
from model_runs import QUADRUPED, run

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.objects.object_reader import load_object


def test_a_drawing_becomes_an_object_file(tmp_path, capsys):
    pytest.importorskip("svgelements")
    (tmp_path / "d.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 100 50">'
        '<g id="base"><path id="side" d="M 10 10 h 60 l 10 20 h -70 z"/></g></svg>'
    )
    assert run(tmp_path / "d.svg", "-o", tmp_path / "my-toy.yaml") == 0
    made = load_object(tmp_path / "my-toy.yaml")
    assert made.name == "my_toy" and made.required.name == "base"
    assert "no pose" in capsys.readouterr().out
    with pytest.raises(ConfigError, match="--overwrite"):
        run(tmp_path / "d.svg", "-o", tmp_path / "my-toy.yaml")
    assert run(tmp_path / "d.svg", "-o", tmp_path / "my-toy.yaml", "--overwrite") == 0


def test_pictures_become_components(tmp_path, capsys):
    for name in ("foot", "arm"):
        image = np.zeros((60, 80), np.uint8)
        cv2.rectangle(image, (20, 20), (50, 35), 2, -1)
        cv2.imwrite(str(tmp_path / f"{name}.png"), image)
    pictures = [tmp_path / "foot.png", tmp_path / "arm.png"]
    assert run(*pictures, "--width", 0.1, 0.2, "--name", "lamp", "-o", tmp_path / "lamp.yaml") == 0
    told = [line for line in capsys.readouterr().out.splitlines() if "A slant does not show in one side" in line]
    assert len(told) == 2 and told[0].startswith("warning: foot.png: with its width of 0.1 m as given it is 0.05")
    assert "--height" in told[0] and "--corners" in told[0]
    assert run(*pictures, "--width", 0.1, 0.2, "--height", 0.0516, 0.1032) == 0
    told = capsys.readouterr().out.splitlines()
    assert sum("as given, and the picture agrees" in line for line in told) == 2
    assert not [line for line in told if line.startswith("warning: foot.png")]
    made = load_object(tmp_path / "lamp.yaml")
    assert (made.name, [c.name for c in made.components]) == ("lamp", ["foot", "arm"])
    assert [np.ptp(c.markers[0].outline[:, 0]) for c in made.components] == pytest.approx([0.1, 0.2], abs=1e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([QUADRUPED, QUADRUPED], "several pictures, or one"),
        (["a.doc"], "'.doc' is no kind of file"),
        (["a.urdf"], "go together"),
        ([QUADRUPED, "--markers", QUADRUPED], "go together"),
        (["a.png"], "--width: 0 given for 1"),
        (["a.png", "--width", "-1"], "--width"),
        (["a.png", "b.png", "c.png", "--width", "1", "2"], "--width: 2 given for 3"),
        (["a.png", "b.png", "c.png", "--width", "1", "--height", "1", "2"], "--height: 2 given for 3"),
        (["a.png", "--width", "1", "--height", "0"], "--height"),
        (["a.png", "--rectangle", "1", "2"], "--corners and --rectangle go together"),
        (["a.png", "b.png", "--rectangle", "1", "1", "--corners", *"00901099"], "--corners: given 1 times for 2"),
        (["a.png", "--rectangle", "1", "1", "--corners", *"00099990"], "do not go round a rectangle clockwise"),
        (["a.png", "--rectangle", "1", "2", "--corners", *"00909404"], "slant of 77 degrees"),
        ([QUADRUPED, "--height", "1"], "are for pictures"),
        ([QUADRUPED, "--distance", "0"], "--distance"),
        ([QUADRUPED, "--label", "300"], "--label: 300"),
        ([QUADRUPED, "--sheet", "a.tif"], "must end in .png"),
    ],
)
def test_wrong_usage_is_told(arguments, message):
    with pytest.raises(ConfigError, match=message):
        run(*arguments)


def test_a_urdfs_markers_keep_the_classes_that_their_file_gives_by_name(tmp_path):
    """They were dropped without a word, and colours were learned of one class alone."""
    (tmp_path / "m.yaml").write_text(
        "format: artrec_object/1\nname: two\ncomponents:\n"
        "  a: {required: true, label: yellow, box: {size: [0.3, 0.2, 0.1]}}\n"
        "  b: {label: 3, box: {size: [0.1, 0.2, 0.5]}}\n"
    )
    (tmp_path / "two.urdf").write_text(
        '<robot name="two"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/>'
        '<child link="b"/><origin xyz="0 0 1"/><axis xyz="1 0 0"/><limit lower="-1" upper="1"/></joint></robot>'
    )
    out = tmp_path / "two.yaml"
    assert run(tmp_path / "two.urdf", "--markers", tmp_path / "m.yaml", "--body-label", 6, "-o", out) == 0
    made = load_object(out, {"yellow": 5})
    assert [c.labels(1) for c in made.components] == [(5,), (3,)]
    assert [c.body_label for c in made.components] == [6, 6]

"""Parameters that change nothing are told by name, with the way of recognition that reads them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from artrec_ros.io.parameters.parameter_file import setup_from_flat
from artrec_ros.io.parameters.unread import unread

FLAT_OBJECT = """
format: artrec_object/1
name: toy
markers: {dot: {disc: {radius: 0.05}}}
components: {base: {required: true, markers: {dot: {}}}}
"""
PLATE_OBJECT = FLAT_OBJECT.replace("dot: {}", "dot: {pose: {xyz: [0, 0, 0]}}").replace("toy", "plate")
TILTED = "far: {marker: dot, pose: {rpy: [0.3, 0, 0]}}"
SPATIAL_OBJECT = PLATE_OBJECT.replace("0]}}}", f"0]}}}}, {TILTED}}}").replace("plate", "solid")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "flat.yaml").write_text(FLAT_OBJECT)
    (tmp_path / "spatial.yaml").write_text(SPATIAL_OBJECT)
    (tmp_path / "plate.yaml").write_text(PLATE_OBJECT)
    return tmp_path


def told(folder: Path, files: list[str], **values: Any) -> list[str]:
    objects = {f"{f}.object_file": f"{f}.yaml" for f in files} | {f"{f}.label": n + 1 for n, f in enumerate(files)}
    given = {name.replace("__", "."): value for name, value in values.items()}
    return unread(setup_from_flat({"objects": files, **objects, **given}, folder))


@pytest.mark.parametrize(
    ("files", "values", "parts"),
    [
        (
            ["flat"],
            {"recognizer__min_probability": 0.5},
            ("in space and of flat objects that face the camera alone", "no object has a place"),
        ),
        (["flat"], {"expert__paper__match": 0.5}, ("by profile paper alone", "recognizer.profile is default")),
        (["spatial"], {"recognizer__min_match": 0.5}, ("where images are calibrated", "in the image plane alone")),
        (["spatial"], {"recognizer__min_probability": 0.5}, ("is read only where images are calibrated",)),
        (
            ["plate"],
            {"recognizer__min_match": 0.5},
            ("in the image plane alone, and all objects are found as a whole",),
        ),
        (["plate"], {"expert__facing__turns": 20}, ("where images are calibrated", "face the camera alone")),
        (["spatial"], {"expert__facing__turns": 20}, ("camera alone, and none of those with such places is flat",)),
        (["flat"], {"expert__facing__turns": 20}, ("camera alone, and no object has a place",)),
        (
            ["plate"],
            {
                "expert__recall__strayed": 0.4,
                "scene__plane__image_points": [0.0, 0.0, 99.0, 0.0, 99.0, 99.0, 0.0, 99.0],
                "scene__plane__field_points": [0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
            },
            ("in space alone, and all those with such places are flat",),
        ),
        (["plate"], {"expert__guesses__root_keep": 9}, ("is read only where images are calibrated",)),
        (["flat"], {"recognizer__max_range_m": 2.0}, ("is read only where images are calibrated",)),
        (["spatial"], {"recognizer__min_range_m": 2.0}, ("is read only where images are calibrated",)),
        (["flat", "spatial"], {"recognizer__max_range_m": 2.0}, ("is read only where images are calibrated",)),
    ],
)
def test_what_is_not_read_is_told(folder: Path, files: list[str], values: dict[str, Any], parts: tuple[str]) -> None:
    (line,) = told(folder, files, **values)
    assert "\n" not in line
    for part in (next(iter(values)).replace("__", "."), *parts):
        assert part in line


@pytest.mark.parametrize(("name", "there"), [("expert.recall.limbs", True), ("expert.facing.turns", False)])
def test_only_of_images_that_are_there_it_is_told(folder: Path, name: str, there: bool) -> None:
    """A plate is found in space where images are calibrated, and else as it faces the camera."""
    values = {"objects": ["plate"], "plate.object_file": "plate.yaml", "plate.label": 1, name: 20}
    setup = setup_from_flat(values, folder)
    assert len(unread(setup)) == 1 and len(unread(setup, {not there})) == 1
    assert unread(setup, {there}) == []


def test_of_those_that_are_tried_it_is_told_whatever_they_are(folder: Path) -> None:
    """A search changes them later: at their defaults they are as little read."""
    values = {"objects": ["spatial"], "spatial.object_file": "spatial.yaml", "spatial.label": 1}
    setup = setup_from_flat({**values, "recognizer.min_scale": 3.0}, folder)
    (line,) = unread(setup, {True}, ["recognizer.min_match", "recognizer.min_probability"])
    assert line.startswith("recognizer.min_match changes nothing where images are calibrated")


def test_profile_paper_reads_its_own_values_and_few_others(folder: Path) -> None:
    names = {"recognizer__min_match": 0.5, "recognizer__min_scale": 3.0, "recognizer__max_range_m": 1.0}
    lines = told(folder, ["flat"], recognizer__profile="paper", expert__paper__match=0.5, **names)
    assert [line.split()[0] for line in lines] == [name.replace("__", ".") for name in names] or len(lines) == 3
    assert all("recognizer.profile is paper" in line for line in lines)


def test_without_whole_objects_nothing_is_read_in_space(folder: Path) -> None:
    (line,) = told(folder, ["spatial"], recognizer__whole_object=False, recognizer__min_probability=0.5)
    assert "recognizer.whole_object is false" in line


@pytest.mark.parametrize(
    ("files", "values"),
    [
        (["flat"], {"recognizer__min_match": 0.5, "recognizer__min_components": 3, "image__rectified": True}),
        (["spatial"], {"recognizer__min_scale": 5.0, "recognizer__min_components": 3, "tracking__speed": 2.0}),
        (["flat", "spatial"], {"recognizer__min_match": 0.5}),
        (["plate"], {"recognizer__min_probability": 0.5, "recognizer__min_scale": 5.0, "expert__fit__edge_vote": 2.0}),
        (["plate", "flat"], {"recognizer__min_identity_probability": 0.9, "recognizer__min_match": 0.5}),
        (["spatial"], {"recognizer__min_match": 0.55, "expert__paper__match": 0.4}),  # at their defaults
        (["spatial"], {"recognizer__profile": "paper", "expert__paper__match": 0.5}),
    ],
)
def test_what_is_read_is_not_told(folder: Path, files: list[str], values: dict[str, Any]) -> None:
    assert told(folder, files, **values) == []


def test_what_tracking_would_read_is_told_where_it_is_off(folder: Path) -> None:
    off = {"tracking__enabled": False, "tracking__smooth": True}
    assert told(folder, ["spatial"], **off) == ["tracking.smooth changes nothing here: tracking.enabled is false"]
    assert told(folder, ["spatial"], tracking__enabled=False) == told(folder, ["spatial"], tracking__smooth=True) == []

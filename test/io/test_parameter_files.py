"""Parameter files: the sections of nodes, types, mistakes, and that the resolved values give the same set-up."""

from __future__ import annotations

import array
import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from artrec_ros.core.base.config import AlignmentConfig, RecognizerConfig, rooms_of
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.parameters.parameter_file import load_parameters, setup_from_flat
from artrec_ros.io.parameters.sections import check_sections, read_flat
from artrec_ros.io.parameters.specs import all_specs, expert_rooms, specs_of

ROOT = Path(__file__).resolve().parents[2]
OBJECT = """
format: artrec_object/1
name: toy
markers: {dot: {disc: {radius: 0.05}}}
components: {base: {required: true, label: pale, markers: {dot: {}}}}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "toy.yaml").write_text(OBJECT.replace(" label: pale,", ""))
    (tmp_path / "named.yaml").write_text(OBJECT)
    return tmp_path


FLAT: dict[str, Any] = {"objects": ["red"], "red.object_file": "toy.yaml", "red.label": 3}
COLOUR = {
    "image.kind": "colour",
    "image.classes": ["pale", "red"],
    "image.pale.label": 7,
    "image.pale.saturation": [0, 0.2],
    "image.red.label": 3,
    "image.red.hue": [340, 20],
}


def _write(folder: Path, text: str) -> Path:
    path = folder / "node.yaml"
    path.write_text(text)
    return path


def _section(name: str, **values: Any) -> str:
    return yaml.safe_dump({name: {"ros__parameters": values}})


def test_each_of_several_files_names_files_from_its_own_folder(folder: Path) -> None:
    """But all from `config_dir`, where one gives it."""
    first, more = _write(folder, _section("/**", **FLAT)), folder / "more" / "blue.yaml"
    more.parent.mkdir()
    (more.parent / "toy.yaml").write_text(OBJECT.replace("name: toy", "name: other").replace(" label: pale,", ""))
    blue = {"objects": ["red", "blue"], "blue.object_file": "toy.yaml", "blue.label": 4}
    more.write_text(_section("/**", **blue))
    assert [t.model.name for t in load_parameters(first, more).targets] == ["toy", "other"]
    more.write_text(_section("/**", **blue, config_dir=str(folder)))
    assert [t.model.name for t in load_parameters(first, more).targets] == ["toy", "toy"]


def test_nested_and_dotted_names_are_the_same(folder: Path) -> None:
    nested = _section("/**", objects=["red"], red={"object_file": "toy.yaml", "label": 3})
    first = load_parameters(_write(folder, nested))
    second = load_parameters(_write(folder, _section("/**", **FLAT)))
    assert first.resolved == second.resolved
    assert [(t.name, t.label, t.model.name, t.constraints) for t in first.targets] == [("red", 3, "toy", None)]


def test_given_values_are_used_and_the_others_keep_their_defaults(folder: Path) -> None:
    setup = setup_from_flat({**FLAT, "recognizer.time_budget_ms": 50, "image.blank": [1, 2, 3, 4]}, folder)
    assert setup.recognizer.time_budget_ms == 50.0 and isinstance(setup.recognizer.time_budget_ms, float)
    assert setup.image.blank == (1, 2, 3, 4)
    assert setup.recognizer.min_blob_px == RecognizerConfig().min_blob_px


def test_colour_classes_and_labels_by_name(folder: Path) -> None:
    setup = setup_from_flat({**FLAT, **COLOUR, "red.object_file": "named.yaml"}, folder)
    assert list(setup.image.classes) == ["pale", "red"]
    assert setup.image.classes["pale"].saturation == (0.0, 0.2)
    assert setup.targets[0].model.required.label == 7


def test_resolved_values_give_the_same_setup_from_anywhere(
    folder: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    setup = setup_from_flat({**FLAT, **COLOUR, "use_sim_time": True}, folder)
    elsewhere = tmp_path_factory.mktemp("elsewhere") / "saved.yaml"
    elsewhere.write_text(setup.to_yaml())
    again = load_parameters(elsewhere)
    assert again.resolved == setup.resolved
    assert (again.image, again.recognizer, again.node) == (setup.image, setup.recognizer, setup.node)
    assert Path(setup.resolved["red.object_file"]) == folder / "toy.yaml"
    assert setup.resolved["recognizer.profile"] == "default" and setup.resolved["use_sim_time"] is True
    assert all(value != [] for value in setup.resolved.values())


def test_arrays_of_the_ros_client_are_lists(folder: Path) -> None:
    setup = setup_from_flat({**FLAT, **COLOUR, "image.red.hue": array.array("d", [340.0, 20.0])}, folder)
    assert setup.image.classes["red"].hue == (340.0, 20.0)


def test_a_nodes_own_section_goes_before_the_wildcard(folder: Path) -> None:
    text = _section("artrec_node", **{"red.label": 4}) + _section("/**", **FLAT) + _section("camera", rate=15)
    flat = read_flat(_write(folder, text))
    assert flat["red.label"] == 4 and flat["objects"] == ["red"] and "rate" not in flat


@pytest.mark.parametrize("name", ["/**", "artrec_node", "/robot/artrec", "/robot/finder", "finder"])
def test_sections_by_any_name(folder: Path, name: str) -> None:
    assert load_parameters(_write(folder, _section(name, **FLAT))).targets[0].label == 3


def test_a_nodes_section_may_stand_under_its_namespace(folder: Path) -> None:
    text = yaml.safe_dump({"robot": {"finder": {"ros__parameters": FLAT}}})
    assert load_parameters(_write(folder, text)).targets[0].label == 3


def test_config_dir_is_where_paths_start(folder: Path) -> None:
    (folder / "sub").mkdir()
    path = folder / "sub" / "node.yaml"
    path.write_text(_section("/**", **FLAT, config_dir=".."))
    assert load_parameters(path).targets[0].model.name == "toy"


@pytest.mark.parametrize(
    ("name", "matches"),
    [
        ("/**", 1),
        ("/*/artrec_node", 1),
        ("artrec_node", 0),
        ("/robot/artrec_node", 1),
        ("robot/artrec_node", 1),
        ("a", 0),
        ("/**/artrec_node", 1),
        ("/**/camera_node", 0),
        ("/other/**", 0),
        ("/robot/**", 1),
    ],
)
def test_a_file_of_other_nodes_is_told(folder: Path, name: str, matches: int) -> None:
    path = _write(folder, _section(name, **FLAT))
    try:
        check_sections([path], "/robot/artrec_node")
    except ConfigError as error:
        assert not matches and f"node.yaml: no section matches the node /robot/artrec_node (there: {name})" in str(
            error
        )
    else:
        assert matches


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("objects: [red]\n", ("no parameters found", "'/**:'", "'ros__parameters:'")),
        ("a: {b: {c: 1}}\n", ("no parameters found",)),
        ("ros__parameters: {objects: [red]}\n", ("node's name", "/**")),
        ("/**: {ros__parameters: {}}\n", ("objects", "missing")),
        ("/**: {ros__parameters: {objects: []}}\n", ("objects: the list is empty; it lists the objects to look for",)),
        (
            "/**: {ros__parameters: {scene: {region: [0, 0, 10.5]}}}",
            ("yaml: scene.region: ROS reads no", "write 0.0"),
        ),
        ("/**: {ros__parameters: {objects: [red, 2]}}", ("node.yaml: objects: ROS reads no list of items of several",)),
        ("/**: {ros__parameters: {red: {label: 3}, red.label: 4}}\n", ("red.label", "twice")),
        (
            "/**: {ros__parameters: {objects: [red], recognizer:   # min_blob_px: 20\n}}",
            ("node.yaml: recognizer: has no value", "ROS starts no node by that, or takes it for text; leave it out"),
        ),
        ("artrec_a: {ros__parameters: {}}\nartrec_b: {ros__parameters: {}}\n", ("artrec_a, artrec_b", "keep one")),
    ],
)
def test_bad_sections_are_refused(folder: Path, text: str, parts: tuple[str, ...]) -> None:
    path = _write(folder, text)
    with pytest.raises(ConfigError) as caught:
        load_parameters(path)
    for part in (str(path), *parts):
        assert part in str(caught.value)


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ({"objects": []}, ("objects", "empty")),
        ({"objects": "red"}, ("objects", "list")),
        ({"objects": ["red", "red"]}, ("objects[1]", "twice")),
        ({"objects": ["image"]}, ("objects[0]", "choose another")),
        ({"objects": ["expert"]}, ("objects[0]", "choose another")),
        ({"expert.alignment.coarse_kep": 3}, ("expert.alignment.coarse_kep", "'expert.alignment.coarse_keep'")),
        ({"expert.alignment.coarse_keep": 0}, ("node.yaml: expert.alignment.coarse_keep", "least value 1")),
        ({"recognizer.min_range_m": 3, "recognizer.max_range_m": 2}, ("node.yaml: recognizer.max_range_m", "below")),
        ({"objects": ["tracking"]}, ("objects[0]", "choose another")),
        ({"tracking.max_gap": 2.0}, ("tracking.max_gap", "'tracking.max_gap_s'")),
        ({"tracking.steady_s": 0.0}, ("tracking.steady_s", "least value 0.001")),
        ({"objects": ["red dog"]}, ("objects[0]", "letters")),
        ({"red.lable": 3}, ("red.lable", "'red.label'")),
        ({"blue.label": 3}, ("blue.label", "'blue' is not in objects (known: red)")),
        ({"recognizer.profil": "paper"}, ("recognizer.profil", "'recognizer.profile'")),
        ({"recognizer.profile": "papr"}, ("recognizer.profile", "'paper'")),
        ({"recognizer.time_budget_ms": "50"}, ("recognizer.time_budget_ms", "number")),
        ({"recognizer.time_budget_ms": 0}, ("recognizer.time_budget_ms", "least value 1")),
        ({"recognizer.min_blob_px": 2.5}, ("recognizer.min_blob_px", "whole number")),
        ({"expert.blobs.anchor_tolerances_px": []}, ("expert.blobs.anchor_tolerances_px", "empty")),
        ({"image.kind": "labels", "image.blank": [1, 2, 3]}, ("image.blank", "whole rectangles")),
        ({"image.kind": "labels", "image.blank": [0, 0, 10**20, 10]}, ("image.blank[2]", "greatest value 2.1")),
        ({"image.kind": "color"}, ("image.kind", "'colour'")),
        ({"image.kind": "colour"}, ("image.classes",)),
        ({**COLOUR, "image.classes": ["pale"]}, ("image.red",)),
        ({**COLOUR, "image.classes": ["pale", "kind"]}, ("image.classes[1]", "choose another")),
        ({**COLOUR, "image.red.hue": [10]}, ("image.red.hue", "pairs")),
        ({**COLOUR, "red.label": 4}, ("red.label", "3 (red)")),
        ({"red.label": 0}, ("red.label", "least value 1")),
        ({"red.label": None}, ("red.label", "whole number")),
        ({"red.object_file": "none.yaml"}, ("red.object_file", "none.yaml")),
        ({"red.object_file": ""}, ("red.object_file",)),
        ({"red.object_file": "package://no_such_package/x.yaml"}, ("red.object_file", "no_such_package")),
        ({"red.object_file": "named.yaml"}, ("named.yaml", "'pale'")),
        ({"red.constraint_file": "none.yaml"}, ("red.constraint_file", "none.yaml")),
        ({"red.constraint_file": "/dev/null"}, ("red.constraint_file", "/dev/null is a folder, pipe or device")),
        ({"red.constraint_file": "toy.yaml"}, ("toy.yaml", "artrec_constraints/1")),
        ({"image_transport": "theora"}, ("image_transport", "compressed")),
    ],
)
def test_mistakes_are_refused_by_their_key(folder: Path, change: dict[str, Any], parts: tuple[str, ...]) -> None:
    with pytest.raises(ConfigError) as caught:
        setup_from_flat({**FLAT, **change}, folder, "node.yaml")
    assert "\n" not in str(caught.value)
    for part in parts:
        assert part in str(caught.value)


def test_missing_keys_are_named_and_said_what_they_are(folder: Path) -> None:
    for key, what in (("red.object_file", "what the object is"), ("image.pale.label", "class number its pixels get")):
        values = {**FLAT, **COLOUR}
        del values[key]
        with pytest.raises(ConfigError, match=f"node.yaml: {key}: .*missing: {what}"):
            setup_from_flat(values, folder, "node.yaml")


def test_specs_carry_types_and_bounds() -> None:
    specs = all_specs(["red"], ["pale"])
    assert specs["recognizer.time_budget_ms"].type is float and specs["recognizer.time_budget_ms"].unit == "ms"
    assert specs["image.blank"].is_list and specs["image.blank"].type is int
    assert {"red.label", "image.pale.hue", "objects", "image.classes", "image_transport"} <= set(specs)
    assert (
        len(specs_of(RecognizerConfig)) + len(rooms_of(RecognizerConfig)) == len(vars(RecognizerConfig())) - 1
    )  # the scene, which has groups of its own


def test_every_value_of_a_room_is_described_and_says_where_it_comes_from() -> None:
    experts = [s for s in all_specs([], []).values() if s.is_expert]
    assert len(experts) == sum(len(dataclasses.fields(room)) for room in expert_rooms().values())
    for spec in experts:
        assert spec.description and spec.origin and spec.paths, spec.name
        assert isinstance(spec.default, tuple) or spec.low is not None or spec.type in (bool, str), spec.name


def test_rooms_are_called_in_messages_as_in_files() -> None:
    for name, room in expert_rooms().items():
        for spec in specs_of(room, f"expert.{name}."):
            if spec.low is not None and not spec.is_list:
                with pytest.raises(ConfigError, match=f"^{spec.name}: "):
                    room(**{spec.name.rpartition(".")[2]: spec.low - 1})


def test_values_for_experts_are_read_and_only_those_given_are_resolved(folder: Path) -> None:
    given = {"expert.alignment.coarse_keep": 100, "expert.blobs.anchor_tolerances_px": [1, 3]}
    setup = setup_from_flat({**FLAT, **given}, folder)
    assert setup.recognizer.alignment == AlignmentConfig(coarse_keep=100)
    assert setup.recognizer.blobs.anchor_tolerances_px == (1.0, 3.0)
    assert {k for k in setup.resolved if k.startswith("expert.")} == set(given)
    assert not [k for k in setup_from_flat(FLAT, folder).resolved if k.startswith("expert.")]
    saved = folder / "saved.yaml"
    saved.write_text(setup.to_yaml())
    assert load_parameters(saved).recognizer == setup.recognizer
    assert setup.changed({"expert.paper.match": 0.5}).recognizer.paper.match == 0.5


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("recognizer.coarse_keep", "expert.alignment.coarse_keep"),
        ("recognizer.tolerance_px", "expert.alignment.tolerance_px"),
        ("recognizer.paper_tolerance_px", "expert.paper.tolerance_px"),
        ("recognizer.min_votes", "expert.verdict.min_votes"),
    ],
)
def test_a_name_that_was_public_leads_to_where_it_is_now(folder: Path, old: str, new: str) -> None:
    for warn in (None, [].append):  # the node, too: it would be dropped there
        with pytest.raises(ConfigError, match=f"node.yaml: {old}: .* {new}$"):
            setup_from_flat({**FLAT, old: 1}, folder, "node.yaml", warn=warn)


def test_a_setup_builds_its_recognizer(folder: Path) -> None:
    result = setup_from_flat(FLAT, folder).build().recognize(np.zeros((40, 60), np.uint8))
    assert result.size == (60, 40) and result.detections == ()


@pytest.mark.parametrize("name", ["aibo", "pendulum", "vss"])
def test_shipped_parameter_files_load(name: str) -> None:
    setup = load_parameters(ROOT / "config" / f"{name}.yaml")
    assert setup.targets and all(t.constraints is not None for t in setup.targets)


def test_a_changed_number_reads_no_file_again(folder: Path) -> None:
    setup = setup_from_flat(FLAT, folder)
    Path(setup.resolved["red.object_file"]).unlink()
    changed = setup.changed({"recognizer.time_budget_ms": 50.0})
    assert changed.recognizer.time_budget_ms == 50
    assert all(new is old for new, old in zip(changed.targets, setup.targets, strict=True))
    with pytest.raises(ConfigError, match="there is no file"):
        setup.changed({"red.label": 9})


def test_unknown_parameters_are_told_where_somebody_listens(folder: Path) -> None:
    told: list[str] = []
    flat = {**FLAT, "recognizer.profil": "paper", "exposure": 3}
    setup = setup_from_flat(flat, folder, "node.yaml", warn=told.append)
    assert setup.recognizer.profile == "default"
    assert len(told) == 2 and all(line.startswith("node.yaml: ") for line in told)
    assert "recognizer.profil" in told[0] and "did you mean 'recognizer.profile'?" in told[0]
    assert "exposure" in told[1]


PLANE = {
    "scene.plane.image_points": [100, 400, 500, 400, 460, 60, 140, 60],
    "scene.plane.field_points": [0, 0, 1, 0, 1, 1, 0, 1],
}


def test_the_scene_is_read_kept_and_changed(folder: Path) -> None:
    region = [0, 0, 600, 0, 600, 400]
    setup = setup_from_flat({**FLAT, **PLANE, "scene.region": region, "scene.plane.frame_id": "hall"}, folder)
    scene = setup.recognizer.scene
    assert (scene.region, scene.plane.frame_id, len(scene.plane.field_points)) == (tuple(region), "hall", 8)
    again = load_parameters(_write(folder, setup.to_yaml()))
    assert again.recognizer == setup.recognizer
    moved = setup.changed({"scene.region": [], "scene.plane.scale_tolerance": 0.1})
    assert (moved.recognizer.scene.region, moved.recognizer.scene.plane.scale_tolerance) == ((), 0.1)
    assert moved.changed({name: [] for name in PLANE}).recognizer.scene.plane.is_given is False


@pytest.mark.parametrize(
    ("values", "part"),
    [
        ({"scene.region": [0, 0, 5, 5]}, "scene.region: 4 numbers are given"),
        ({"scene.plane.image_points": PLANE["scene.plane.image_points"]}, "and field_points 0"),
        (PLANE | {"scene.plane.field_points": [0, 0, 1, 0, 1, -1, 0, -1]}, "the field is mirrored"),
        (PLANE | {"scene.plane.frame_id": ""}, "scene.plane.frame_id: is empty"),
        (PLANE | {"scene.plane.frame_id": "/field"}, "'/field' is no frame that tf looks up"),
        (PLANE | {"scene.plane.frame_id": "the field"}, "'the field' is no frame that tf looks up"),
        ({"scene.plane.image_point": [1.0]}, "image_points"),
    ],
)
def test_a_scene_that_cannot_be_is_refused_at_the_start_and_while_it_runs(
    folder: Path, values: dict[str, Any], part: str
) -> None:
    with pytest.raises(ConfigError) as error:
        setup_from_flat({**FLAT, **values}, folder)
    assert part in str(error.value) and "\n" not in str(error.value)
    with pytest.raises(ConfigError):
        setup_from_flat(FLAT, folder).changed(values)


def test_classes_without_a_colour_are_told(folder: Path) -> None:
    def told(**changes: Any) -> list[str]:
        return setup_from_flat({**FLAT, **COLOUR, **changes}, folder).lacks()

    assert not told()  # one by saturation, one by hue
    (line,) = told(**{"image.red.hue": []})
    assert line.startswith("image.classes: no colour is given for red") and "artrec learn-colours" in line
    assert not told(**{"image.red.hue": [], "image.red.rgb": [200, 10, 10]})
    assert not setup_from_flat(FLAT, folder).lacks()

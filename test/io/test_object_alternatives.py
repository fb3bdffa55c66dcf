"""Alternative classes and identities in object files: what is read, and that each mistake is refused by its key."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml
from changes import changed

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.model.identities import identities_of
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.io.objects.object_writer import object_yaml

SHIPPED = Path(__file__).resolve().parents[2] / "config" / "objects" / "mirosot.yaml"
GOOD: dict[str, Any] = {
    "format": "artrec_object/1",
    "name": "robot",
    "classes": {"pink": 7},
    "markers": {"patch": {"rectangle": {"width": 0.04, "height": 0.04}}},
    "components": {
        "team": {"required": True, "markers": {"patch": {"pose": {}}}},
        "left": {"classes": {"g": "green", "p": "pink"}, "markers": {"a": {"marker": "patch", "pose": {}}}},
        "right": {"classes": {"g": 4, "r": 5}, "markers": {"b": {"marker": "patch", "pose": {}}}},
    },
    "identities": {"one": {"left": "g", "right": "r"}, "two": {"right": "g", "left": "p"}},
    "unique": True,
}


def _load(folder: Path, content: dict[str, Any], labels: dict[str, int] | None = None) -> Any:
    path = folder / "robot.yaml"
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    return load_object(path, labels)


def test_alternatives_and_identities_are_read(tmp_path: Path) -> None:
    model = _load(tmp_path, GOOD, {"green": 4})
    team, left, right = model.components
    assert not team.classes and left.classes == {"g": 4, "p": 7} and right.classes == {"g": 4, "r": 5}
    assert (team.labels(2), left.labels(2), right.labels(2)) == ((2,), (4, 7), (4, 5))
    assert [(i.name, i.classes) for i in model.identities] == [
        ("one", {"left": "g", "right": "r"}),
        ("two", {"left": "p", "right": "g"}),
    ]
    assert model.unique and left.label is None


@pytest.mark.parametrize("left_out", [("identities",), ("unique",), ("identities", "unique")])
def test_identities_and_whether_they_are_unique_may_be_left_out(tmp_path: Path, left_out: tuple[str, ...]) -> None:
    model = _load(tmp_path, {k: v for k, v in GOOD.items() if k not in left_out}, {"green": 4})
    assert len(model.identities) == 2 * ("identities" not in left_out)
    assert model.unique == ("unique" not in left_out)


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    model = _load(tmp_path, GOOD, {"green": 4})
    (tmp_path / "again.yaml").write_text(object_yaml(model))
    again = load_object(tmp_path / "again.yaml")
    assert [c.classes for c in again.components] == [c.classes for c in model.components]
    assert (again.identities, again.unique) == (model.identities, model.unique)
    assert object_yaml(again) == object_yaml(model)


@pytest.mark.parametrize("path", [SHIPPED, None], ids=["shipped", "own"])
def test_names_of_classes_may_stay_open_where_labels_do_not_matter(tmp_path: Path, path: Path | None) -> None:
    """What trains, draws or inspects an object reads its file alone."""
    model = load_object(path) if path else _load(tmp_path, GOOD)
    assert model.unique and model.identities and model.is_flat
    left = model.component("left")
    assert left.classes["g"] is None and left.labels(2) == ((2,) if path else (7,))


@pytest.mark.parametrize(
    ("change", "value", "parts"),
    [
        ("components/left/classes", {"g": "green"}, ("components.left.classes", "two classes or more", "has a label")),
        ("components/left/classes", {}, ("components.left.classes", "two classes or more")),
        ("components/left/classes", ["green", "pink"], ("components.left.classes",)),
        ("components/left/classes/g", "gren", ("components.left.classes.g", "'gren' is not known", "'green'")),
        ("components/left/classes/g", 253, ("components.left.classes.g", "greatest value 252")),
        ("components/left/classes/g", 0, ("components.left.classes.g", "least value 1")),
        ("components/left/classes/g", 7, ("components.left", "component 'left'", "the same label")),
        ("components/left/classes/a b", 9, ("components.left", "class 'a b'", "a name has")),
        ("components/left/label", 9, ("components.left", "either one label or alternative classes")),
        ("identities/one", {"left": "g"}, ("identity 'one'", "each component that has alternatives: left, right")),
        ("identities/one/team", "g", ("identity 'one'", "each component that has alternatives: left, right")),
        ("identities/one/left", "r", ("identity 'one'", "component 'left' has no class 'r'", "it has g, p")),
        ("identities/one/left", 4, ("identities.one.left",)),
        ("identities/one", "g", ("identities.one",)),
        ("identities/a b", {"left": "g", "right": "g"}, ("identity 'a b'", "a name has")),
        ("identities/two", {"left": "g", "right": "r"}, ("'one' and 'two' are the same",)),
        ("unique", "yes", ("unique", "true or false")),
        ("unic", True, ("unic: unknown key", "'unique'")),
    ],
)
def test_mistakes_are_refused_by_their_key(tmp_path: Path, change: str, value: Any, parts: tuple[str, ...]) -> None:
    with pytest.raises(ConfigError) as caught:
        _load(tmp_path, changed(GOOD, change, value), {"green": 4})
    message = str(caught.value)
    assert str(tmp_path / "robot.yaml") in message and "\n" not in message
    for part in parts:
        assert part in message


def test_identities_without_alternatives_are_refused(tmp_path: Path) -> None:
    bare = changed(changed(GOOD, "components/left/classes", None), "components/right/classes", None)
    with pytest.raises(ConfigError, match="each component that has alternatives: none has"):
        _load(tmp_path, bare)


def test_an_object_without_alternatives_may_occur_once(tmp_path: Path) -> None:
    bare = changed(changed(GOOD, "components/left/classes", None), "components/right/classes", None)
    model = _load(tmp_path, changed(bare, "identities", None))
    assert model.unique and not model.identities


def test_more_combinations_than_can_be_told_apart_want_to_be_listed(tmp_path: Path) -> None:
    classes = dict(zip("abcdef", range(1, 7), strict=True))
    part = {"classes": classes, "markers": {"a": {"marker": "patch", "pose": {}}}}
    team = GOOD["components"]["team"]
    open_ = {k: v for k, v in GOOD.items() if k != "identities"}
    parts = {f"p{n}": copy.deepcopy(part) for n in range(8)}  # YAML would write one as an alias
    with pytest.raises(ConfigError, match="8 components make 1679616 combinations, .* list those that do under 'ident"):
        _load(tmp_path, {**open_, "components": {"team": team, **parts}})
    one = {"one": dict.fromkeys(parts, "a")}
    assert len(_load(tmp_path, {**GOOD, "identities": one, "components": {"team": team, **parts}}).identities) == 1
    few = dict(list(parts.items())[:4])
    assert len(identities_of(_load(tmp_path, {**open_, "components": {"team": team, **few}}))) == 6**4


def test_a_name_that_is_no_text_is_told_by_its_key(tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as caught:
        _load(tmp_path, {**GOOD, "name": 12}, {"green": 4})
    assert str(caught.value) == f"{tmp_path / 'robot.yaml'}: name: must be text, not 12"

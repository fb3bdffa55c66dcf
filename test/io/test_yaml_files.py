"""Strict YAML: every bad value is refused in one line that names file, key and what would be valid."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import yaml

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.base import yaml_loader
from artrec_ros.io.base.yaml_files import Value, load_value, load_yaml, nearest


def _refusal(call, *parts: str) -> str:
    with pytest.raises(ConfigError) as caught:
        call()
    message = str(caught.value)
    assert "\n" not in message
    for part in parts:
        assert part in message
    return message


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("a: 1\nb: 2\na: 3\n", ("line 3", "'a'", "twice")),
        ("a: [1, 2\n", ("line",)),
        ("a:\n\tb: 1\n", ("line 2", "a tab: YAML wants spaces")),
        ("a: &x 1\nb: *x\n", ("line 2", "aliases")),
        ("", ("empty",)),
        ("a: 1\n---\nb: 2\n", ("line 2", "a second document begins; one file holds one: leave out '---'")),
        ("a: !!python/object:os.system 1\n", ("line 1",)),
        ("[" * 500_000, ("line 1", "nested more than 100 deep")),
        ("\n".join(" " * i + "a:" for i in range(1200)), ("nested more than 100 deep",)),
        ("a: !!bool foo\n", ("a value in it is none of its kind",)),
        ("a: !!int ''\n", ("a value in it is none of its kind",)),
        ("a: !!timestamp foo\n", ("a value in it is none of its kind",)),
        ("a: " + "9" * 5000, ("a value in it is none of its kind, or too long",)),
        ("a:\n  <<: {b: 1}\n", ("line 2", "merge keys (<<) are not read; write the values out")),
        ("a: 0b11\n", ("line 1", "'0b11' is no number to ROS; write 3, or put it in quotes")),
        ("b: 2\na: 1:30\n", ("line 2", "'1:30' is no number to ROS; write 90, or put it in quotes")),
        ("a: [1_000.0]\n", ("line 1", "'1_000.0' is no number to ROS; write 1000.0")),
        ("a: 1 # " + "x" * 2**20, ("bytes, more than",)),
        ("version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 3\n", ("git lfs pull",)),
    ],
)
def test_bad_yaml_names_the_file_and_line(tmp_path: Path, text: str, parts: tuple[str, ...]) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    _refusal(lambda: load_value(path), str(path), *parts)


def test_unreadable_files_are_refused(tmp_path: Path) -> None:
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x00\x80")
    _refusal(lambda: load_value(tmp_path / "none.yaml"), "none.yaml", "no such file")
    _refusal(lambda: load_value(binary), "binary.yaml", "UTF-8")
    _refusal(lambda: load_value(tmp_path), str(tmp_path), "a folder")


def test_what_is_no_regular_file_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")
    (tmp_path / "endless.yaml").symlink_to("/dev/zero")
    _refusal(lambda: load_value(tmp_path / "pipe.yaml"), "pipe.yaml", "a pipe or device")
    _refusal(lambda: load_value(tmp_path / "endless.yaml"), "endless.yaml", "a pipe or device")


def test_numbers_are_those_of_yaml_1_2_and_ros(tmp_path: Path) -> None:
    path = tmp_path / "v.yaml"
    path.write_text("a: 1e-3\nb: -2E4\nc: 1.5e2\nd: -.05\ne: +.5\nf: .25\ng: [-.07, .07]\n")
    values = load_value(path).entries()
    assert [values[k].number() for k in "abcdef"] == [1e-3, -2e4, 150.0, -0.05, 0.5, 0.25]
    np.testing.assert_array_equal(values["g"].vector(2), [-0.07, 0.07])


@pytest.mark.parametrize(
    ("line", "parts"),
    [
        ("", ("format", "missing", "kind/1")),
        ("format: kind/2", ("kind/2", "version 1")),
        ("format: other/1", ("other/1", "another kind", "kind/1")),
        ("format: 1", ("format", "text")),
    ],
)
def test_format_is_checked(tmp_path: Path, line: str, parts: tuple[str, ...]) -> None:
    path = tmp_path / "f.yaml"
    path.write_text(f"{line}\nname: x\n")
    _refusal(lambda: load_yaml(path, "kind/1"), str(path), *parts)


def test_format_is_not_among_the_values(tmp_path: Path) -> None:
    path = tmp_path / "f.yaml"
    path.write_text("format: kind/1\nname: x\n")
    assert load_yaml(path, "kind/1").raw == {"name": "x"}


def _value(raw: object) -> Value:
    return Value(Path("file.yaml"), "a.b", raw)


@pytest.mark.parametrize(
    ("call", "parts"),
    [
        (lambda: _value({"colour": 1}).fields(optional=("color", "size")), ("a.b.colour", "'color'", "size")),
        (lambda: _value({"size": 1}).fields(required=("size", "name")), ("a.b.name", "missing")),
        (lambda: _value([1]).fields(), ("a.b:", "mapping")),
        (lambda: _value({True: 1}).entries(), ("True", "quotes")),
        (lambda: _value("1").number(), ("'1'", "a number")),
        (lambda: _value(True).number(), ("True", "a number")),
        (lambda: _value(float("nan")).number(), ("finite",)),
        (lambda: _value(5).number(low=6), ("5", "least", "6")),
        (lambda: _value(5).number(high=4), ("5", "greatest", "4")),
        (lambda: _value(0).number(above=0), ("greater than 0",)),
        (lambda: _value(1.5).integer(), ("1.5", "whole number")),
        (lambda: _value(None).text(), ("nothing", "text")),
        (lambda: _value("rde").text(("red", "blue")), ("'red'", "blue")),
        (lambda: _value("yes").boolean(), ("true or false",)),
        (lambda: _value([1, 2]).vector(3), ("3 numbers",)),
        (lambda: _value([1, "x"]).vector(2), ("a.b[1]", "'x'")),
        (lambda: _value([[0, 0], [1, 1]]).points(3), ("3 points", "has 2")),
        (lambda: _value([[0, 0], [1, 1, 1]]).points(2), ("a.b[1]", "2 numbers")),
    ],
)
def test_bad_values_name_their_place(call, parts: tuple[str, ...]) -> None:
    _refusal(call, "file.yaml: a.b", *parts)


@pytest.mark.parametrize("raw", [10**400, -(10**400), 1 << 20000], ids=["long", "negative", "very long"])
def test_whole_numbers_beyond_all_others_are_refused(raw: int) -> None:
    _refusal(Value(Path("f.yaml"), "a", raw).number, "f.yaml: a", "a finite number")
    _refusal(Value(Path("f.yaml"), "a", raw).text, "f.yaml: a", "must be text")


def test_good_values_come_back() -> None:
    assert _value(3).number(0, 3) == 3.0
    assert _value(3).integer(3) == 3
    assert _value([[0, 1], [2.5, 3], [4, 5]]).points(3).tolist() == [[0, 1], [2.5, 3], [4, 5]]
    assert set(_value({"x": 1}).fields(required=("x",), optional=("y",))) == {"x"}


def test_nearest_names_all_that_is_known() -> None:
    assert nearest("labl", ["label", "axis"]) == "; did you mean 'label'? (known: label, axis)"
    assert "did you mean" not in nearest("zzz", ["label"])
    assert "none" in nearest("zzz", [])


def test_nearest_is_near_by_what_names_do_not_share() -> None:
    known = [f"recognizer.{name}" for name in ("min_match", "memory", "threads")]
    assert "did you mean" not in nearest("recognizer.colour", known)
    assert nearest("recognizer.memry", known).startswith("; did you mean 'recognizer.memory'?")
    assert "did you mean 'recognizer.memory'?" in nearest("recogniser.memory", known)
    assert nearest("zzz", [f"n{i}" for i in range(20)]).endswith("n11 and 8 more)")


def test_a_file_is_parsed_once_however_often_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parsed, load = [], yaml.load
    monkeypatch.setattr(yaml_loader.yaml, "load", lambda text, loader: parsed.append(text) or load(text, loader))
    path = tmp_path / "a.yaml"
    for text in ("once: 1\n", "once: 1\n", "once: 2\n"):
        path.write_text(text)
        assert load_value(path).raw == {"once": int(text[-2])}
    assert parsed == ["once: 1\n", "once: 2\n"]

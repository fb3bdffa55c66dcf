"""YAML as ROS reads it."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

import yaml

_DEEPEST = 100
TOO_DEEP, OF_LIBYAML = f"is nested more than {_DEEPEST} deep", "maximum nesting depth"  # newer ones count, too

_MERGE = "tag:yaml.org,2002:merge"

_SafeLoader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml, where PyYAML was built with it


class _Loader(_SafeLoader):
    """YAML as ROS reads it: no repeated keys; 1e-3 is a number."""

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        seen: set[str] = set()
        for key, _ in node.value:
            name = str(key.value)
            if name in seen:
                problem = f"the key '{name}' is given twice; keep one"
                raise yaml.constructor.ConstructorError(None, None, problem, key.start_mark)
            if key.tag == _MERGE:  # whose value PyYAML would spread, and ROS takes for a parameter's name
                problem = "merge keys (<<) are not read; write the values out"
                raise yaml.constructor.ConstructorError(None, None, problem, key.start_mark)
            seen.add(name)
        return super().construct_mapping(node, deep)


def _check_events(text: str) -> None:
    """Refuses aliases, which ROS does not read, and nesting that would overrun the C loader's stack."""
    depth = 0
    for event in yaml.parse(text, _SafeLoader):
        mark: Any = event.start_mark
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if isinstance(event, yaml.AliasEvent):
            problem = "aliases are not read; write the value out"
            raise yaml.constructor.ConstructorError(None, None, problem, mark)
        if depth > _DEEPEST:
            raise yaml.constructor.ConstructorError(None, None, TOO_DEEP, mark)


# YAML 1.2 and ROS: no dot is needed before the exponent, no digit before the dot, be there a sign or not
_FLOAT = re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$|^[-+]\.\d+$")
_Loader.add_implicit_resolver("tag:yaml.org,2002:float", _FLOAT, list("-+.0123456789"))


_NOT_OF_ROS = re.compile(r"[:_]|^[-+]?0b")  # in numbers


def _number(loader: Any, node: Any) -> Any:
    """A number in a form that ROS takes for one, too: YAML 1.1 has others, such as 1:30, which is 90 there."""
    number = loader.construct_yaml_float(node) if node.tag.endswith("float") else loader.construct_yaml_int(node)
    if _NOT_OF_ROS.search(node.value):
        problem = f"'{node.value}' is no number to ROS; write {number}, or put it in quotes if it is text"
        raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark)
    return number


class _OthersLoader(_Loader):
    """Files that others write, too: what is no number to ROS is text in them, as a time of day is."""


def _number_or_text(loader: Any, node: Any) -> Any:
    return node.value if _NOT_OF_ROS.search(node.value) else _number(loader, node)


for _kind in ("int", "float"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_kind}", _number)
    _OthersLoader.add_constructor(f"tag:yaml.org,2002:{_kind}", _number_or_text)


@lru_cache(maxsize=8)  # one command reads a file for this and for that: a fifth of a second, of many pairs
def parsed_yaml(text: str, *, others: bool) -> Any:
    """The content, which nobody changes. :param others: the file may be of others' making."""
    _check_events(text)
    return yaml.load(text, _OthersLoader if others else _Loader)

"""Prints what is made from the code: docs/parameters.md, docs/expert_parameters.md, docs/topics.md and
config/all_parameters.yaml.

python -m artrec_ros.tools.reference parameters|expert|topics|yaml
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence

from ..core.base.config import (
    PATHS,
    ClassConfig,
    FloorConfig,
    ImageConfig,
    NodeConfig,
    ObjectConfig,
    PlaneConfig,
    RecognizerConfig,
    SceneConfig,
    TrackingConfig,
)
from ..io.messages.node_topics import INPUTS, OUTPUTS, NodeTopic
from ..io.parameters.specs import LIVE, Spec, expert_rooms, offline_rooms, specs_of
from .reference_texts import EXPERT, PARAMETERS, TOPICS, YAML

_SECTIONS: tuple[tuple[str, str, type], ...] = (
    ("Objects", "`objects` lists names; these become topics. Each has, under its name:", ObjectConfig),
    ("Images", "Under `image`:", ImageConfig),
    ("Classes", "`image.classes` lists names, the first wins a pixel. Each has, under `image.NAME`:", ClassConfig),
    ("Recogniser", "Under `recognizer`:", RecognizerConfig),
    (
        "Scene",
        "What is known of the scene ([field.md](field.md)); all of it is optional. Under `scene`:",
        SceneConfig,
    ),
    (
        "Plane",
        "Its points are changed both at once (`ros2 param load`, `set_parameters_atomically`). Under `scene.plane`:",
        PlaneConfig,
    ),
    ("Floor", "Of calibrated images, for objects that are found in space. Under `scene.floor`:", FloorConfig),
    ("Tracking", "Under `tracking`:", TrackingConfig),
    ("Node", "At the top level:", NodeConfig),
)

_COLUMNS = ("name", "type", "default", "valid", "meaning")
_WAYS = {"plane": "image plane", "space": "space", "facing": "facing", "paper": "paper"}
_TYPES = {int: "integer", float: "number", str: "text", bool: "true/false"}


_PATHS = {"object_file": "objects/quadruped.yaml", "constraint_file": "constraints/quadruped.yaml", "label": 3}


def parameters_page() -> str:
    """docs/parameters.md."""
    parts = [PARAMETERS.replace("{live}", ", ".join(f"`{name}`" for name in LIVE))]
    for title, intro, config in _SECTIONS:
        specs = specs_of(config)
        read = any(spec.paths != PATHS for spec in specs)
        rows = [(*_row(spec), _read(spec)) if read else _row(spec) for spec in specs]
        parts.append(f"## {title}\n\n{intro}\n\n{_table((*_COLUMNS, 'read') if read else _COLUMNS, rows)}")
    return "\n".join(parts)


def expert_page() -> str:
    """docs/expert_parameters.md."""
    parts = [EXPERT]
    for name, config in expert_rooms().items():
        rows = [(*_row(spec), _read(spec), spec.origin) for spec in specs_of(config)]
        if rows:
            parts.append(
                f"{_about(name, config)} Under `expert.{name}`:\n\n{_table((*_COLUMNS, 'read', 'origin'), rows)}"
            )
    for name, config in offline_rooms().items():
        rows = [(*_row(spec), spec.origin) for spec in specs_of(config)]
        parts.append(f"{_about(name, config)} Not in parameter files.\n\n{_table((*_COLUMNS, 'origin'), rows)}")
    return "\n".join(parts)


def _about(name: str, config: type) -> str:
    return f"## {name}\n\n{' '.join(str(config.__doc__).split())}"


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _read(spec: Spec) -> str:
    return "always" if spec.paths == PATHS else ", ".join(_WAYS[way] for way in spec.paths)


def topics_page() -> str:
    """docs/topics.md."""
    return TOPICS.format(inputs=_topic_table(INPUTS), outputs=_topic_table(OUTPUTS))


def _topic_table(topics: Sequence[NodeTopic]) -> str:
    rows = [(f"`{t.name}`", t.type.replace("/msg", ""), str(t.depth), t.meaning) for t in topics]
    return _table(("topic", "type", "queue", ""), rows).rstrip("\n")


def parameters_yaml() -> str:
    """config/all_parameters.yaml."""
    parts = [YAML, _yaml_section("red", ObjectConfig, _PATHS), _yaml_section("image", ImageConfig)]
    parts += ["      # classes: [pale]\n", _yaml_section("pale", ClassConfig, None, "      # ")]
    parts += [_yaml_section("recognizer", RecognizerConfig), _yaml_section("scene", SceneConfig)]
    parts += [_yaml_section("plane", PlaneConfig, None, "      ")]
    parts += [_yaml_section("floor", FloorConfig, None, "      "), _yaml_section("tracking", TrackingConfig)]
    parts += [_yaml_line(spec, spec.default, "    ") for spec in specs_of(NodeConfig)]
    parts += ["    # expert:                      # the method's own numbers\n"]
    rooms = {name: room for name, room in expert_rooms().items() if specs_of(room)}
    return "".join([*parts, *(_yaml_section(name, room, None, "    #   ") for name, room in rooms.items())])


def _yaml_section(name: str, config: type, values: Mapping[str, object] | None = None, indent: str = "    ") -> str:
    lines = [_yaml_line(spec, (values or {}).get(spec.name, spec.default), indent + "  ") for spec in specs_of(config)]
    return "".join([f"{indent}{name}:\n", *lines])


def _yaml_line(spec: Spec, value: object, indent: str) -> str:
    # ROS takes 1 for an integer even where a number is declared: always with a point
    text = json.dumps(list(value) if isinstance(value, tuple) else value)
    limits = ", ".join(filter(None, [spec.unit, _valid(spec).replace("`", "")]))
    about = f"{spec.description} [{limits}]" if limits else spec.description
    unset = "# " if value == () and "#" not in indent else ""
    return f"{indent}{unset}{f'{spec.name}: {text}':<34}  # {about}\n"


def _row(spec: Spec) -> tuple[str, ...]:
    kind = _TYPES[spec.type] + (" list" if spec.is_list else "")
    meaning = f"{spec.description} [{spec.unit}]" if spec.unit else spec.description
    return f"`{spec.name}`", kind, _default(spec), _valid(spec), meaning


def _default(spec: Spec) -> str:
    if spec.default in ("", ()) or (spec.low is not None and not spec.is_list and spec.default < spec.low):
        return ""
    return f"`{_listed(spec.default)}`" if spec.is_list else f"`{spec.default}`"


def _listed(values: Sequence[object]) -> str:
    return "[" + ", ".join(map(str, values)) + "]"


def _valid(spec: Spec) -> str:
    if spec.choices:
        return ", ".join(f"`{c}`" for c in spec.choices)
    low, high = (None if bound is None else f"{bound:g}" for bound in (spec.low, spec.high))
    if low is not None and high is not None:
        return f"{low} to {high}" + (f", {spec.length} of them" if spec.length else "")
    return f"from {low}" if low is not None else f"to {high}" if high is not None else ""


_PAGES = {"parameters": parameters_page, "expert": expert_page, "topics": topics_page, "yaml": parameters_yaml}

if __name__ == "__main__":
    page = (sys.argv[1:] or ["parameters"])[0]
    if page not in _PAGES:
        sys.exit(f"usage: python -m artrec_ros.tools.reference {'|'.join(_PAGES)}")
    sys.stdout.write(_PAGES[page]())

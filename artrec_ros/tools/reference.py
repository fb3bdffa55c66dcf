"""Makes docs/parameters.md from the dataclasses of core/config.py; prints it."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from ..core.config import ClassConfig, ImageConfig, NodeConfig, ObjectConfig, RecognizerConfig, TrackingConfig
from ..io.specs import Spec, specs_of

_INTRO = """\
# Parameters

Made by `python -m artrec_ros.tools.reference`; the text comes from `artrec_ros/core/config.py`.

`artrec_node` and `artrec replay --params-file` read the same ROS parameter file. Offline it is read without ROS: a
section `/**:` applies to every node, the section of a node `artrec...` (or else of the one that has `objects`) goes
before it, other nodes' sections are passed over. Dots in names are nesting in YAML. A wrong name, type or value is
refused with its key and what would be valid.
`artrec replay` saves all parameters, defaults included, as `parameters.yaml` beside its results: again such a file.

```yaml
/**:
  ros__parameters:
    objects: [red, blue]
    red: {object_file: objects/quadruped.yaml, constraint_file: constraints/quadruped.yaml, label: 3}
    blue: {object_file: objects/quadruped.yaml, constraint_file: constraints/quadruped.yaml, label: 2}
    image: {kind: labels}
    recognizer: {time_budget_ms: 500.0}
```

Paths are relative to the parameter file (to `config_dir` where that is given), or `package://PACKAGE/PATH`.
"""

_SECTIONS: tuple[tuple[str, str, type], ...] = (
    ("Objects", "`objects` lists names; these become topics. Each has, under its name:", ObjectConfig),
    ("Images", "Under `image`:", ImageConfig),
    ("Classes", "`image.classes` lists names, the first wins a pixel. Each has, under `image.NAME`:", ClassConfig),
    ("Recogniser", "Under `recognizer`:", RecognizerConfig),
    ("Tracking", "Under `tracking`:", TrackingConfig),
    ("Node", "At the top level:", NodeConfig),
)

_HEAD = "| name | type | default | valid | meaning |\n| --- | --- | --- | --- | --- |\n"
_TYPES = {int: "integer", float: "number", str: "text", bool: "true/false"}


def parameters_page() -> str:
    """The page as Markdown."""
    parts = [_INTRO]
    for title, intro, config in _SECTIONS:
        rows = "\n".join(_row(spec) for spec in specs_of(config))
        parts.append(f"## {title}\n\n{intro}\n\n{_HEAD}{rows}\n")
    return "\n".join(parts)


def _row(spec: Spec) -> str:
    kind = _TYPES[spec.type] + (" list" if spec.is_list else "")
    meaning = f"{spec.description} [{spec.unit}]" if spec.unit else spec.description
    return f"| `{spec.name}` | {kind} | {_default(spec)} | {_valid(spec)} | {meaning} |"


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
        return f"{low} to {high}"
    return f"from {low}" if low is not None else f"to {high}" if high is not None else ""


if __name__ == "__main__":
    sys.stdout.write(parameters_page())

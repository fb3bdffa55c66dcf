"""What kind of file somebody gave, told by its content: so that an error can say what it is and what was wanted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

OBJECT, CONSTRAINTS, PARAMETERS = "an object file", "a constraint file", "a parameter file (ros__parameters)"
COCO, CALIBRATION = "a COCO file", "a camera calibration"
PLAN, SUMMARY = "the plan of a replay", "the summary of a replay"
METRICS, COMPARISON = "the metrics of an evaluation", "the comparison of an evaluation"
SEARCH, TUNING = "a search space of artrec tune", "the outcome of artrec tune"
RESULT, TRUTH, METADATA = "a result of a replay (detections.jsonl)", "truth (truth.jsonl)", "a bag's metadata.yaml"

_FORMATS = {
    "artrec_object": OBJECT,
    "artrec_constraints": CONSTRAINTS,
    "artrec_replay": PLAN,
    "artrec_metrics": METRICS,
    "artrec_search": SEARCH,
    "artrec_tuning": TUNING,
}
# a file that has all of these keys; the first fitting one counts
_KEYS = (
    (("images", "annotations", "categories"), COCO),
    (("camera_matrix",), CALIBRATION),
    (("rosbag2_bagfile_information",), METADATA),
    (("looked_for", "frames_with_error"), SUMMARY),
    (("stamp_ns", "objects", "rejected"), RESULT),
    (("stamp_ns", "objects"), TRUTH),
    (("markers", "components"), OBJECT),
    (("coverage", "pairs"), CONSTRAINTS),
)


def kind_of(content: Any) -> str | None:
    """With its article; None: none that this package knows.

    :param content: plain values, as YAML or JSON gave them; of lines of JSON, the first one.
    """
    if not isinstance(content, Mapping):
        return None
    name = str(content.get("format", "")).partition("/")[0]
    if name in _FORMATS:
        return COMPARISON if _FORMATS[name] == METRICS and "runs" in content else _FORMATS[name]
    if holds_parameters(content):
        return PARAMETERS
    return next((kind for keys, kind in _KEYS if all(key in content for key in keys)), None)


def kind_by_format(format: str) -> str | None:
    """Of a `format: NAME/VERSION` line."""
    return _FORMATS.get(format.partition("/")[0])


def mistaken(content: Any, wanted: str) -> str:
    """The text of an error about a file of another kind than `wanted`; empty: it may well be one, or is unknown."""
    kind = kind_of(content)
    return "" if kind is None or kind == wanted else f"is {kind}; {wanted} is wanted here"


def holds_parameters(content: Mapping[Any, Any]) -> bool:
    """At any depth: ROS nests them under namespaces."""
    return "ros__parameters" in content or any(
        holds_parameters(value) for value in content.values() if isinstance(value, Mapping)
    )

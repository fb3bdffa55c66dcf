"""Plain values by type hints: what fits comes back, what does not is named by its key."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, TypedDict

import numpy as np
import pytest

from artrec_ros.io.base.typed import Amount, Share, UnfitError, typed


@dataclass(frozen=True)
class Point:
    x: float
    y: float = 0.0
    made: int = field(default=0, init=False)


class Needed(TypedDict):
    name: str
    points: tuple[Point, ...]
    size: tuple[int, int] | None


class Whole(Needed, total=False):
    share: Share
    areas: dict[str, Amount]
    kind: Literal["a", "b"]


GOOD: dict[str, Any] = {"name": "n", "points": [{"x": 1}, {"x": 2, "y": 0.5, "more": 1}], "size": [3, 4], "unknown": []}


def test_what_fits_is_made() -> None:
    assert typed(GOOD, Whole) == {"name": "n", "points": (Point(1.0), Point(2.0, 0.5)), "size": (3, 4)}
    assert typed({**GOOD, "size": [3.0, 4]}, Whole)["size"] == (3, 4)  # as tables of numbers are written
    assert typed({**GOOD, "size": None, "share": 1, "areas": {"a": 0}, "kind": "b"}, Whole)["areas"] == {"a": 0.0}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"name": 3}, "name: must be text, not 3"),
        ({"points": {}}, "points: must be a list, not {}"),
        ({"points": [{"x": 1}, {}]}, "points[1].x: this key is missing"),
        ({"points": [{"x": True}]}, "points[0].x: must be a finite number, not True"),
        ({"points": [{"x": 10**400}]}, "points[0].x: must be a finite number, not 1000"),
        ({"size": [1]}, "size: must be a list of 2, not [1]"),
        ({"size": [1, 2.5]}, "size[1]: must be a whole number, not 2.5"),
        (
            {"size": [1, 2.0**53 + 2]},
            "size[1]: must be a whole number without point or exponent: with one, tho",
        ),
        ({"share": 1.5}, "share: must be at least 0 and at most 1, not 1.5"),
        ({"areas": {"a\n": -1}}, r"areas.'a\n': must be at least 0, not -1"),
        ({"kind": "c"}, "kind: must be one of 'a', 'b', not 'c'"),
    ],
)
def test_what_does_not_fit_is_named_by_its_key(change: dict[str, Any], said: str) -> None:
    with pytest.raises(UnfitError) as caught:
        typed({**GOOD, **change}, Whole)
    assert str(caught.value).startswith(said) and "\n" not in str(caught.value)


def test_a_dataclass_that_is_made_already_is_looked_through() -> None:
    point = Point(1.0, 2.0)
    assert typed(point, Point) is point
    with pytest.raises(UnfitError, match="y: must be a finite number, not 'up'"):
        typed(Point(1.0, "up"), Point)  # type: ignore[arg-type]
    with pytest.raises(UnfitError, match="must be a mapping"):
        typed(np.zeros(2), Point)

"""Like markers in rows: what else stands in rows is taken for them."""

from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.tools.inspecting.rows import in_rows


def board(places, sides=None, **more):
    """Squares (or rectangles) of 5 cm at places (n, 2), metres."""
    parts = []
    for n, (x, y) in enumerate(places):
        w = 0.05 if sides is None else sides[n]
        outline = np.array([(0, 0), (w, 0), (w, 0.05), (0, 0.05)])
        at = Pose.from_xyz_rpy((x, y, 0.0))
        square = Marker("square", outline, outline[0], outline[1], T_component_marker=at)
        parts.append(Component(f"s{n}", (square,), required=n == 0))
    return ObjectModel("board", tuple(parts), **more)


ROWS = [(0.1 * i, 0.1 * j) for i in range(4) for j in range(3)]


def test_rows_of_like_markers_are_told_with_what_helps() -> None:
    (line,) = in_rows(board(ROWS))
    assert line.startswith("moved along their rows, 9 of 12 markers lie where others did") and "unique: true" in line


@pytest.mark.parametrize(
    "model",
    [
        board(ROWS, unique=True),
        board(ROWS[:5]),
        board(ROWS, sides=np.geomspace(0.01, 0.2, 12)),
        board([(0.1 * n, 0.013 * n**2) for n in range(12)]),
        replace(board(ROWS), components=(
            replace(board(ROWS).components[0], bodies=(Box(Pose.identity(), np.array([0.5, 0.5, 0.01])),)),
            *board(ROWS).components[1:],
        )),
    ],
)  # fmt: skip
def test_what_is_alone_borne_or_in_no_rows_is_not(model: ObjectModel) -> None:
    assert not list(in_rows(model))

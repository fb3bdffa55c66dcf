"""Calibrations whose numbers were exchanged, or are another image's."""

import numpy as np
import pytest

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.tools.inspecting.camera_report import odd_calibration


@pytest.mark.parametrize(
    ("focal", "centre", "said"),
    [
        ((600, 610), (322, 236), None),
        ((600, 610), (236, 322), "exchanged"),
        ((600, 610), (612, 610), "far off its middle"),
        ((600, 610), (0, 0), "far off its middle"),
        ((322, 236), (322, 236), "square"),
    ],
)
def test_calibrations_that_are_hardly_meant_are_told(focal, centre, said):
    matrix = np.array([[focal[0], 0, centre[0]], [0, focal[1], centre[1]], [0, 0, 1]], float)
    lines = list(odd_calibration(Camera(matrix, np.zeros(0), (640, 480))))
    assert lines == [] if said is None else len(lines) == 1 and said in lines[0]

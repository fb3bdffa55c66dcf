from __future__ import annotations

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

import numpy as np
from sensor_msgs.msg import CameraInfo

from artrec_ros.node.calibration import Calibrations

SIZE = (640, 480)


def info(stamp_s: int, focal_px: float = 500.0, **fields: object) -> CameraInfo:
    msg = CameraInfo(width=SIZE[0], height=SIZE[1], distortion_model="plumb_bob", d=[0.0] * 5, **fields)
    msg.header.stamp.sec = stamp_s
    msg.k = [focal_px, 0.0, 320.0, 0.0, focal_px, 240.0, 0.0, 0.0, 1.0]
    msg.p = [focal_px - 10, 0.0, 310.0, 0.0, 0.0, focal_px - 10, 230.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    return msg


def focal(calibrations: Calibrations, stamp_s: int, *, rectified: bool = False) -> float | None:
    camera = calibrations.camera_for(stamp_s * 10**9, SIZE, rectified)
    return camera and float(camera.matrix[0, 0])


def test_a_change_holds_at_once_and_for_the_image_that_it_came_with() -> None:
    calibrations = Calibrations()
    assert focal(calibrations, 1) is None and "no camera_info" in calibrations.problem
    calibrations.receive(info(1))
    assert calibrations.problem == "", "it has come, though no image has asked for it yet"
    assert focal(calibrations, 1) == focal(calibrations, 7) == 500 and calibrations.problem == ""
    calibrations.receive(info(2, 700.0))
    assert focal(calibrations, 2) == focal(calibrations, 3) == 700
    assert focal(calibrations, 1) == 500, "an image that waited keeps its own"


def test_the_same_calibration_is_made_ready_once() -> None:
    calibrations = Calibrations()
    cameras = set()
    for stamp in range(5):
        calibrations.receive(info(stamp))
        cameras.add(id(calibrations.camera_for(stamp * 10**9, SIZE, False)))
    assert len(cameras) == 1


def test_rectified_images_have_p() -> None:
    calibrations = Calibrations()
    calibrations.receive(info(1))
    assert focal(calibrations, 1, rectified=True) == 490
    assert focal(calibrations, 1) == 500


def test_an_image_of_another_size_costs_the_next_one_nothing() -> None:
    calibrations = Calibrations()
    calibrations.receive(info(1))
    assert calibrations.camera_for(10**9, (320, 240), False) is None
    assert "640x480" in calibrations.problem and "320x240" in calibrations.problem
    assert focal(calibrations, 1) == 500


def test_what_is_lost_is_told_and_comes_back() -> None:
    calibrations = Calibrations()
    calibrations.receive(info(1))
    assert focal(calibrations, 1)
    bad = info(2)
    bad.k = np.full(9, np.nan)
    calibrations.receive(bad)
    assert focal(calibrations, 2) is None and "not finite" in calibrations.problem
    calibrations.receive(info(3))
    assert focal(calibrations, 3) == 500 and calibrations.problem == ""


def test_old_calibrations_do_not_pile_up() -> None:
    calibrations = Calibrations()
    for stamp in range(100):
        calibrations.receive(info(stamp, 500.0 + stamp))
    assert focal(calibrations, 3) == 599, "so old an image has the newest"

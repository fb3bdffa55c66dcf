"""An image has the calibration of its own stamp and camera, in whichever order the two come; what is not so is told."""

from __future__ import annotations

import threading
import time

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

from sensor_msgs.msg import CameraInfo

from artrec_ros.node import calibration
from artrec_ros.node.calibration import Calibrations
from artrec_ros.node.conversions import stamp_ns

SIZE = (640, 480)
LATE_S = 0.01


S = 10**9


def info(stamp: int, focal_px: float = 500.0, frame_id: str = "eye") -> CameraInfo:
    msg = CameraInfo(width=SIZE[0], height=SIZE[1], distortion_model="plumb_bob", d=[0.0] * 5)
    msg.header.frame_id = frame_id
    msg.header.stamp.sec, msg.header.stamp.nanosec = divmod(stamp, S)
    msg.k = [focal_px, 0.0, 320.0, 0.0, focal_px, 240.0, 0.0, 0.0, 1.0]
    return msg


def focal(calibrations: Calibrations, stamp: int, frame_id: str = "eye") -> float | None:
    """Of the image that has come now."""
    calibrations.meet(info(stamp, frame_id=frame_id).header)
    camera = calibrations.camera_for(stamp, SIZE, False, frame_id)
    return camera and float(camera.matrix[0, 0])


def focal_before(calibrations: Calibrations, msg: CameraInfo, late_s: float = LATE_S) -> float | None:
    """Of an image whose calibration comes so much later."""
    later = threading.Timer(late_s, calibrations.receive, [msg])
    later.start()
    found = focal(calibrations, stamp_ns(msg.header))
    later.join()
    return found


def waiting_s(calibrations: Calibrations, stamp: int) -> float:
    began_s = time.monotonic()
    focal(calibrations, stamp)
    return time.monotonic() - began_s


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """However busy the machine is."""
    monkeypatch.setattr(calibration, "_PATIENCE_S", 30.0)


@pytest.fixture
def zooming(patient: None) -> Calibrations:
    """Infos with images' stamps that come just after them, and have changed."""
    calibrations = Calibrations()
    for stamp in (1, 2):
        focal(calibrations, stamp)
        calibrations.receive(info(stamp, 500.0 + stamp))
    return calibrations


def test_of_a_camera_that_zooms_that_of_the_images_stamp_is_waited_for(zooming: Calibrations) -> None:
    for stamp in range(10, 20):
        assert focal_before(zooming, info(stamp, 700.0 + stamp)) == 700 + stamp


def test_a_fixed_cameras_images_wait_for_nothing(patient: None) -> None:
    calibrations = Calibrations()
    for stamp in range(1, 20):
        assert waiting_s(calibrations, stamp) < 10
        calibrations.receive(info(stamp))
    assert calibrations.doubt == ""


def test_infos_under_stamps_of_their_own_are_not_waited_for(patient: None) -> None:
    calibrations = Calibrations()
    for stamp in range(10, 30):
        calibrations.receive(info(stamp + 1000, 500.0 + stamp))
        assert waiting_s(calibrations, stamp) < 10
        assert focal(calibrations, stamp) == 500 + stamp, "the newest"
    assert "another stamp" in calibrations.doubt, "nobody can know whose it is"


def test_what_usually_comes_too_late_is_not_waited_for(zooming: Calibrations, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calibration, "_PATIENCE_S", 0.2)
    for stamp in range(10, 40):
        focal(zooming, stamp)  # and nothing comes
    began_s = time.monotonic()
    for stamp in range(40, 50):
        focal(zooming, stamp)
    assert time.monotonic() - began_s < 1, "ten times 0.2 s"


def test_an_image_that_was_taken_with_another_is_told_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    calibrations = Calibrations()
    calibrations.receive(info(1))
    assert focal(calibrations, 1) == focal(calibrations, 2) == 500
    calibrations.receive(info(2))
    assert focal(calibrations, 3) == 500 and calibrations.doubt == "", "the same under another stamp"
    calibrations.receive(info(3, 700.0))
    assert "another stamp" in calibrations.doubt
    monkeypatch.setattr(calibration, "_RECENT_S", 0.0)
    assert calibrations.doubt == ""


def test_the_images_camera_goes_before_others_however_new() -> None:
    calibrations = Calibrations()
    calibrations.receive(info(1, 500.0, "left"))
    for stamp in range(2, 100):
        calibrations.receive(info(stamp, 700.0, "right"))
    assert focal(calibrations, 99, "left") == 500 and calibrations.doubt == ""
    assert focal(calibrations, 99, "right") == focal(calibrations, 99, "") == 700 and calibrations.doubt == ""


def test_another_cameras_is_used_and_both_are_named() -> None:
    calibrations = Calibrations()
    calibrations.receive(info(1, 500.0, "right"))
    assert focal(calibrations, 1, "left") == 500
    assert "'right'" in calibrations.doubt and "'left'" in calibrations.doubt
    calibrations.receive(info(2, 700.0, ""))
    assert focal(calibrations, 1, "left") == 700 and calibrations.doubt == "", "whose it is is not said"


STAMPS = [100 * S + n * S // 5 for n in range(10)]  # of a recording that is played once and again


@pytest.mark.parametrize("infos_come_first", [True, False])
def test_played_again_images_have_no_calibration_of_their_stamp_from_before(
    patient: None, infos_come_first: bool
) -> None:
    calibrations = Calibrations()
    for stamp in STAMPS:
        calibrations.receive(info(stamp))
        assert focal(calibrations, stamp) == 500
    for stamp in STAMPS:
        if infos_come_first:
            calibrations.receive(info(stamp, 700.0))
            assert focal(calibrations, stamp) == 700
        else:
            assert focal_before(calibrations, info(stamp, 700.0)) == 700


def test_one_that_is_sent_once_holds_when_images_are_played_again() -> None:
    calibrations = Calibrations()
    calibrations.receive(info(1))
    assert [focal(calibrations, stamp) for stamp in (*STAMPS, *STAMPS)] == [500] * 20

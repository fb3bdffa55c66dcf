import numpy as np
import pytest

from artrec_ros.core.base.errors import SourceError
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.sources.opening import SourceOptions, open_sources

STAMP = 1_700_000_000_123_456_789
CAMERA = Camera(np.array([[200, 0, 15.5], [0, 210, 11.5], [0, 0, 1]]), np.array([0.1, 0, 0, 0, 0]), (32, 24), "eye")


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("channels", [(), (3,)])
def test_images_and_calibration_come_back_as_they_were(tmp_path, storage, channels):
    image = np.random.default_rng(0).integers(0, 256, (24, 32, *channels), np.uint8)
    with BagWriter(tmp_path / "bag", storage) as bag:
        bag.write_camera("/cam/camera_info", STAMP, CAMERA)
        bag.write_image("/cam/image", STAMP, "eye", image)
    with open_sources([tmp_path / "bag"], SourceOptions()) as sources:
        (frame,) = list(sources)
    assert frame.error is None and frame.stamp_ns == STAMP
    assert np.array_equal(frame.image, image)
    np.testing.assert_allclose(frame.camera.matrix, CAMERA.matrix)
    np.testing.assert_allclose(frame.camera.distortion, CAMERA.distortion)
    assert frame.camera.size == (32, 24) and frame.camera.frame_id == "eye"


def test_poses_come_back_as_they_were(tmp_path):
    from rosbags.highlevel import AnyReader

    pose = Pose(rotation_from_rotvec([0.2, -0.7, 1.1]), np.array([0.1, -0.2, 1.5]))
    with BagWriter(tmp_path / "bag") as bag:
        bag.write_poses("/truth/poses", STAMP, "eye", [pose])
        bag.write_poses("/truth/poses", STAMP + 1, "eye", [])
    with AnyReader([tmp_path / "bag"]) as reader:
        first, second = (reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages())
    assert first.header.frame_id == "eye" and first.header.stamp.nanosec == 123_456_789
    p, q = first.poses[0].position, first.poses[0].orientation
    np.testing.assert_allclose((p.x, p.y, p.z), pose.position)
    np.testing.assert_allclose((q.x, q.y, q.z, q.w), pose.quaternion)
    assert second.poses == []


def test_an_existing_folder_is_refused(tmp_path):
    with pytest.raises(SourceError, match="exists already"):
        BagWriter(tmp_path)

"""Calibrations: from messages with binning and regions, and from ROS' calibration files."""

from __future__ import annotations

import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.base.yaml_files import like_it
from artrec_ros.io.images.cameras import camera_from_info, load_camera

K = [500.0, 0, 320, 0, 510, 240, 0, 0, 1]

FILE = """
image_width: 640
image_height: 480
camera_name: head
camera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 510, 240, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, 0, 0, 0, 0]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
"""


def test_a_ray_hits_the_same_place_of_a_binned_part_of_the_image():
    whole = camera_from_info(640, 480, K, [], "plumb_bob")
    part = camera_from_info(640, 480, K, [], "plumb_bob", binning=(2, 2), roi=(100, 40, 400, 300))
    ray = np.array([0.1, -0.05, 1.0])
    u, v, _ = whole.matrix @ ray
    assert np.allclose((part.matrix @ ray)[:2], [(u - 100.5) / 2, (v - 40.5) / 2])
    assert whole.size == (640, 480) and part.size == (200, 150)


@pytest.mark.parametrize("binning", [(1, 1), (2, 2), (4, 2), (3, 5)])
def test_what_a_binned_image_shows_lies_where_its_camera_says(binning):
    """A bright patch whose middle is a point's place in the full image; pixels are combined by rectangles."""
    bx, by = binning
    x0, y0 = 17, 30  # of the region of interest
    ray = np.array([(140.25 - 100) / 300, (95.5 - 80) / 310, 1.0])
    matrix = [300.0, 0, 100, 0, 310, 80, 0, 0, 1]
    u, v, _ = camera_from_info(240, 180, matrix, [], "").matrix @ ray
    y, x = np.mgrid[:180, :240]
    full = np.exp(-((x - u) ** 2 + (y - v) ** 2) / (2 * 8.0**2))
    part = full[y0 : y0 + 150, x0 : x0 + 180].reshape(150 // by, by, 180 // bx, bx).mean(axis=(1, 3))
    camera = camera_from_info(240, 180, matrix, [], "", binning=binning, roi=(x0, y0, 180, 150))
    assert camera.size == part.shape[::-1]
    y, x = np.mgrid[: part.shape[0], : part.shape[1]]
    seen = [(part * x).sum() / part.sum(), (part * y).sum() / part.sum()]
    np.testing.assert_allclose((camera.matrix @ ray)[:2], seen, atol=1e-3)


@pytest.mark.parametrize(
    ("matrix", "distortion", "model", "said"),
    [
        ([0.0] * 9, [], "", "not calibrated"),
        ([-500.0, 0, 320, 0, 500, 240, 0, 0, 1], [], "", "K is of focal lengths -500 and 500 px; both are above 0"),
        (K, [0.0] * 4, "equidistant", "'equidistant' is not supported"),
        (K, [0.0] * 4, "equi\nx", r"'equi\\nx' is not supported"),
        (K, [0.0] * 4, "x" * 300_000, r"^distortion model 'x{56}\.\.\. is not supported"),
        (K, [0.0] * 7, "plumb_bob", "7 coefficients"),
        ([K[0], 2.0, *K[2:]], [], "", "no pinhole camera .K is with a skew of 2 px; 0 belongs there"),
        ([*K[:3], -3.0, *K[4:]], [], "", "no pinhole camera .K is with a skew of 3 px; 0 belongs there"),
        ([float("nan"), *K[1:]], [], "", "not finite"),
    ],
)
def test_unfit_calibrations_say_why(matrix, distortion, model, said):
    with pytest.raises(ConfigError, match=said):
        camera_from_info(640, 480, matrix, distortion, model)


def test_a_calibration_file(tmp_path):
    (tmp_path / "c.yaml").write_text(FILE)
    camera = load_camera(tmp_path / "c.yaml")
    assert np.array_equal(camera.matrix.reshape(-1), K)
    assert camera.distortion[0] == 0.1 and camera.size == (640, 480) and camera.frame_id == "head"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("image_width: 640", "", "image_width: missing"),
        ("image_width: 640", "image_width: wide", "image_width: numbers"),
        ("image_width: 640", "image_width: .nan", "image_width: finite numbers"),
        ("image_height: 480", "image_height: -.inf", "image_height: finite numbers"),
        ("data: [500,", f"data: [{10**400},", "camera_matrix: finite numbers"),
        ("240, 0, 0, 1]", "240, 0, 0]", "camera_matrix: 9 number"),
        ("plumb_bob", "fisheye", "'fisheye' is not supported"),
        ("image_width: 640", "image_width: [", "line 4"),
        ("image_height: 480", "image_height: 480\nimage_height: 240", "'image_height' is given twice"),
    ],
)
def test_errors_name_file_and_key(tmp_path, old, new, said):
    path = tmp_path / "c.yaml"
    path.write_text(FILE.replace(old, new))
    with pytest.raises(ConfigError, match=said) as caught:
        load_camera(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


P = [450.0, 0, 310, -45, 0, 450, 235, 0, 0, 0, 1, 0]


def test_of_rectified_images_p_holds_without_distortion_whatever_the_lens():
    camera = camera_from_info(640, 480, K, [0.1] * 4, "equidistant", binning=(2, 2), projection=P)
    assert np.array_equal(camera.matrix, [[225, 0, 154.75], [0, 225, 117.25], [0, 0, 1]])
    assert camera.distortion.size == 0 and camera.size == (320, 240)
    with pytest.raises(ConfigError, match="not calibrated .P"):
        camera_from_info(640, 480, K, [], "", projection=[0.0] * 12)


def test_a_file_of_a_rectified_camera(tmp_path):
    text = FILE.replace("rectification_matrix", f"projection_matrix: {{data: {P}}}\nrectification_matrix")
    (tmp_path / "c.yaml").write_text(text)
    assert load_camera(tmp_path / "c.yaml", rectified=True).matrix[0, 0] == 450
    (tmp_path / "c.yaml").write_text(FILE)
    with pytest.raises(ConfigError, match="projection_matrix: missing"):
        load_camera(tmp_path / "c.yaml", rectified=True)


@pytest.mark.parametrize("changes", [{"width": 0}, {"binning": (2**31, 1)}, {"matrix": [1e200, *K[1:]]}])
def test_implausible_calibrations_are_refused(changes):
    with pytest.raises(ConfigError):
        camera_from_info(**{"width": 640, "height": 480, "matrix": K, "distortion": [], "model": "", **changes})


@pytest.mark.parametrize(
    ("focal_px", "distortion", "said"),
    [
        (0.866, [], r"a focal length of 0.866 px and a width of 640 px make 180 degrees of view; was K divided by"),
        (20, [], "make 173 degrees"),
        (1e5, [], r"1e\+05 px and a width of 640 px make 0.367 degrees of view; are they those of one image"),
        (500, [1e6, 0, 0, 0, 0], r"no lens has a distortion coefficient of 1e\+06"),
        (500, [0, -1e6, 0, 0, 0], "no lens"),
        (500, [0.1, 0, 0, 0, 1e6], "no lens"),
        (500, [0.1, 0, 0, 1e3, 0], "no lens"),
    ],
)
def test_no_camera_sees_so_much_or_so_little(focal_px, distortion, said):
    matrix = [focal_px, 0, 320, 0, focal_px, 240, 0, 0, 1]
    with pytest.raises(ConfigError, match=said):
        camera_from_info(640, 480, matrix, distortion, "plumb_bob")


def test_both_axes_must_be_plausible():
    with pytest.raises(ConfigError, match=r"a focal length of 1.25 px and a height of 480 px make 179 degrees of view"):
        camera_from_info(640, 480, [600, 0, 320, 0, 1.25, 240, 0, 0, 1], [], "plumb_bob")


@pytest.mark.parametrize(
    ("matrix", "said"),
    [
        ([600, 0, 320, 0, 7000, 240, 0, 0, 1], r"focal lengths of 600 and 7e\+03 px"),
        ([600, 0, 1e6, 0, 600, 240, 0, 0, 1], r"the optical axis meets an image of 640x480 pixels at 1e\+06, 240"),
        ([600, 0, 320, 0, 600, 240, 0, 0, 0], "the last row of K is 0, 0, 0; 0, 0, 1 belongs there"),
    ],
)
def test_what_no_camera_has_is_no_calibration(matrix, said):
    """With such a one nothing would be found any more, not even in the image plane."""
    with pytest.raises(ConfigError, match=f"implausible.*{said}"):
        camera_from_info(640, 480, matrix, [], "plumb_bob")
    camera_from_info(640, 480, [600, 0, -100, 0, 4000, 900, 0, 0, 1], [], "plumb_bob")  # a part of a larger image
    camera_from_info(1920, 200, [1400, 0, 960, 0, 1400, 540, 0, 0, 1 - 1e-10], [], "plumb_bob")  # a strip of one


def test_what_else_stands_in_a_calibration_is_left_alone(tmp_path):
    path = tmp_path / "c.yaml"
    path.write_text(FILE + "calibrated_at: 12:30:45\nserial: 22_0345\n")
    assert load_camera(path, "c").size == (640, 480)


@pytest.mark.parametrize(
    ("focal_px", "distortion"),
    [
        (160, [-0.3, 0.08, 1e-3, -1e-3, -0.01]),  # 127 degrees of view
        (20000, [-40.0, 9e3, 0.01, 0.01, 0]),  # a telephoto lens, 1.8 degrees
        (640, [31.2, 11.4, 1e-4, -2e-4, 0.6, 31.5, 21.6, 3.4]),  # large ones that all but cancel each other
    ],
)
def test_lenses_that_there_are_pass(focal_px, distortion):
    matrix = [focal_px, 0, 320, 0, focal_px, 240, 0, 0, 1]
    assert camera_from_info(640, 480, matrix, distortion, "").size == (640, 480)


@pytest.mark.parametrize("roi", [(100, 0, 600, 480), (0, 100, 640, 400), (1, 0, 0, 0), (2**31, 0, 10, 10)])
def test_a_region_beyond_the_image_is_refused(roi):
    with pytest.raises(ConfigError, match=r"region of interest, .* reaches beyond its image of 640x480"):
        camera_from_info(640, 480, K, [], "", roi=roi)


def test_a_name_that_is_nearly_there_is_proposed(tmp_path):
    (tmp_path / "camera.yaml").write_text("x")
    assert "did you mean" in like_it(tmp_path / "camra.yaml") and "camera.yaml" in like_it(tmp_path / "camra.yaml")
    assert like_it(tmp_path / "other.txt") == like_it(tmp_path / "nowhere" / "camera.yaml") == ""

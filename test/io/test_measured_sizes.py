"""A marker photographed at a slant: told by two measured sides, and taken out by a rectangle around it."""

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.io.objects.marker_images import image_marker
from artrec_ros.io.objects.measured_sizes import KnownRectangle, ratio_tolerance
from artrec_ros.simulation.simulator import pinhole_camera

CAB = np.array([[100, 150], [600, 150], [700, 300], [600, 450], [300, 450], [250, 320], [100, 320]]) - (400.0, 300.0)
CAB = CAB * (0.25e-3, -0.25e-3)  # 0.15 x 0.075 m, x right, y up
SHEET = (0.297, 0.210)
CAMERA = pinhole_camera((1200, 900), 45)


def shot(slant_deg, about_deg=90.0, turn_deg=0.0, sheet=True, labels=False):
    """A picture of the marker on a sheet of paper on a table, and the sheet's corners in it.

    :param about_deg: of the axis in the picture's plane about which the sheet is turned; 90: an upright one.
    """
    about, turn = np.radians([about_deg, turn_deg])
    axis = np.radians(slant_deg) * np.array([np.cos(about), np.sin(about), 0.0])
    R = cv2.Rodrigues(axis)[0] @ cv2.Rodrigues(np.array([0, 0, turn]))[0]
    pose = Pose(R @ np.diag([1.0, -1.0, -1.0]), np.array([0.02, -0.01, 0.6]))
    half = np.array(SHEET) / 2
    corners = half * ([-1, 1], [1, 1], [1, -1], [-1, -1])
    seen = [project(CAMERA, pose.apply(np.column_stack([p, np.zeros(len(p))]))) for p in (corners, CAB)]
    fine = 4  # drawn finer, then shrunk: soft edges
    wide = np.full((900 * fine, 1200 * fine, 3), (60, 80, 110) if sheet else (225, 228, 230), np.uint8)
    for outline, colour in zip(seen, ((225, 228, 230), (40, 30, 200)), strict=True):
        cv2.fillPoly(wide, [np.rint(((outline + 0.5) * fine - 0.5) * 16).astype(np.int32)], colour, shift=4)
    small = cv2.resize(wide, (1200, 900), interpolation=cv2.INTER_AREA)
    if labels:
        return np.where(small[:, :, 0] < 50, 3, 1).astype(np.uint8), seen[0]
    noisy = cv2.GaussianBlur(small, (0, 0), 1.0) + np.random.default_rng(0).normal(0, 4, small.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8), seen[0]


def written(folder, *arguments, **named):
    image, corners = shot(*arguments, **named)
    cv2.imwrite(str(folder / "cab.png"), image)
    return folder / "cab.png", corners


def assert_is_cab(outline, within):
    gap = np.linalg.norm(outline[:, None] - CAB[None], axis=2)
    assert len(outline) == len(CAB)
    assert gap.min(axis=1).max() < within and gap.min(axis=0).max() < within


@pytest.mark.parametrize("turn_deg", [-1.0, 0.0, 1.0])
def test_a_straight_picture_agrees_with_both_sides(tmp_path, turn_deg):
    path, _ = written(tmp_path, 0.0, turn_deg=turn_deg, sheet=False)
    outline = image_marker(path, 0.15, height_m=0.075).marker.outline
    assert np.ptp(outline, axis=0) == pytest.approx([0.15, 0.075], rel=1e-6)  # both as measured
    assert_is_cab(outline, 3e-3)  # a turn of a degree stays


@pytest.mark.parametrize(("slant_deg", "about_deg"), [(22, 90), (30, 90), (22, 0), (-30, 0)])
def test_a_slant_shows_in_two_sides(tmp_path, slant_deg, about_deg):
    path, _ = written(tmp_path, slant_deg, about_deg, sheet=False)
    image_marker(path, 0.15)  # one side tells nothing
    with pytest.raises(ConfigError, match=r"cab\.png: .*not 0\.075 m: it was taken at a slant of some \d+") as told:
        image_marker(path, 0.15, height_m=0.075)
    assert float(str(told.value).split("slant of some ")[1].split()[0]) == pytest.approx(abs(slant_deg), abs=4)


def test_a_turned_strip_leaves_more_room_than_a_square():
    strip, square = (np.array([[0, 0], [w, 0], [w, 1], [0, 1]], float) for w in (10, 1))
    assert ratio_tolerance(square) == pytest.approx(0.02, abs=1e-9)  # its sides grow alike
    assert ratio_tolerance(strip) > 0.15  # 1 degree makes a strip of 10 x 1 one of 10 x 1.17


@pytest.mark.parametrize(("slant_deg", "about_deg"), [(0, 0), (20, 90), (35, 0), (35, 40), (45, 130)])
def test_a_rectangle_takes_a_slant_out(tmp_path, slant_deg, about_deg):
    path, corners = written(tmp_path, slant_deg, about_deg, turn_deg=20)
    sheet = KnownRectangle(np.round(corners), SHEET)
    assert sheet.slant_deg == pytest.approx(slant_deg, abs=3.5)
    assert_is_cab(image_marker(path, None, rectangle=sheet).marker.outline, 2e-3)
    image_marker(path, 0.15, height_m=0.075, rectangle=sheet)
    with pytest.raises(ConfigError, match=r"by its rectangle the marker's height is 0\.07\d* m, and not 0\.08 m"):
        image_marker(path, 0.15, height_m=0.08, rectangle=sheet)


def test_a_large_picture_is_straightened_as_well(tmp_path):
    image, corners = shot(30)
    cv2.imwrite(str(tmp_path / "cab.png"), cv2.resize(image, None, fx=3, fy=3))
    sheet = KnownRectangle((corners + 0.5) * 3 - 0.5, SHEET)
    assert_is_cab(image_marker(tmp_path / "cab.png", None, rectangle=sheet).marker.outline, 2e-3)


def test_a_label_image_is_straightened_without_new_classes(tmp_path):
    path, corners = written(tmp_path, 30, labels=True)
    sheet = KnownRectangle(corners, SHEET)
    image, _ = sheet.straightened(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), 1500, smooth=False)
    assert set(np.unique(image)) == {1, 3}
    assert np.ptp(image_marker(path, None, 3, rectangle=sheet).marker.outline, axis=0) == pytest.approx(
        [0.15, 0.075], rel=0.03
    )


def test_a_rectangle_that_is_none_is_refused(tmp_path):
    path, corners = written(tmp_path, 20)
    with pytest.raises(ConfigError, match="do not go round a rectangle clockwise"):
        KnownRectangle(corners[::-1], SHEET)
    with pytest.raises(ConfigError, match="do not go round"):
        KnownRectangle(corners[[0, 2, 1, 3]], SHEET)
    with pytest.raises(ConfigError, match="is its width, from first to second corner, given first"):
        KnownRectangle(corners, SHEET[::-1])
    with pytest.raises(ConfigError, match="not all within the picture of 1200 x 900 pixels"):
        image_marker(path, None, rectangle=KnownRectangle(corners + (900, 0), SHEET))

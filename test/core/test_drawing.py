"""Overlays show what was found where it was found, and leave the rest of the picture alone."""

from __future__ import annotations

import colorsys
from dataclasses import replace

import cv2
import numpy as np
import pytest

from artrec_ros.core.drawing import class_picture, draw_error, draw_result, object_colour
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import Detection, ImagePose, Instance
from artrec_ros.core.model.frame_result import FrameResult, Rejection

SQUARE = np.array([[80.0, 60], [120, 60], [120, 100], [80, 100]])
CAMERA = Camera(np.array([[200.0, 0, 100], [0, 200, 80], [0, 0, 1]]), np.zeros(5), (200, 160))
LABELS = np.zeros((160, 200), np.uint8)


def found(pose=None, contour=SQUARE, name="arm") -> FrameResult:
    parts = (Instance("base", "m", 0.9, 100, 80, 0.0, 100, contour),)
    return FrameResult((200, 160), (Detection(name, 0, 0.9, ImagePose(100, 80, 0, 100), parts, pose),))


def changed(result, image=LABELS, camera=None, zoom=3) -> np.ndarray:
    """(H, W): which of the image's pixels differ from the bare picture."""
    bare = draw_result(image, FrameResult((200, 160)), ["arm"], camera)
    differs = (draw_result(image, result, ["arm"], camera) != bare).any(axis=2)
    return differs.reshape(image.shape[0], zoom, image.shape[1], zoom).any(axis=(1, 3))


def test_small_images_are_enlarged_and_large_ones_are_not():
    assert draw_result(LABELS, FrameResult((200, 160)), []).shape == (480, 600, 3)
    assert draw_result(np.zeros((480, 640, 3), np.uint8), FrameResult((640, 480)), []).shape == (480, 640, 3)


def test_where_blobs_wait_and_nothing_else_is_said_the_picture_says_so():
    rows = np.flatnonzero(changed(FrameResult((200, 160), waiting=14)).any(axis=1))
    assert len(rows) and rows.min() > 140
    assert np.array_equal(changed(replace(found(), waiting=14)), changed(found()))


@pytest.mark.parametrize("size", [(1, 4000), (4000, 1), (3, 700)])
def test_long_images_are_not_enlarged_to_great_ones(size):
    assert draw_result(np.zeros(size, np.uint8), FrameResult(size[::-1]), []).shape[:2] == size


def test_the_image_given_stays_as_it_was():
    image = np.zeros((480, 640, 3), np.uint8)
    draw_result(image, found(), ["arm"])
    assert not image.any()


def test_the_outline_lies_where_the_contour_is():
    drawn = changed(found())
    assert drawn[60, 85:115].all() and drawn[100, 85:115].all() and drawn[65:95, 80].all() and drawn[65:95, 120].all()
    assert drawn[80, 101:110].all()  # the axis, along +x
    assert not drawn[85:95, 85:97].any() and not drawn[:, :60].any() and not drawn[110:].any()


def test_the_objects_frame_needs_pose_and_camera():
    pose = Pose.from_xyz_rpy([0.0, 0.0, 2.0])
    without = changed(found())
    assert np.array_equal(changed(found(pose)), without)
    with_frame = changed(found(pose), camera=CAMERA) & ~without
    assert with_frame[82:92, 99:102].any(axis=1).all()  # its y axis points down in the image, from (100, 80)


def test_what_is_expected_is_drawn_faintly():
    """A circle and the frame where it should be, and its name in brackets."""
    pose, nothing = Pose.from_xyz_rpy([0.0, 0.0, 2.0]), FrameResult((200, 160))
    seen = Detection("arm", 0, 0.9, ImagePose(100, 80, 0, 100), (), pose)
    one = FrameResult((200, 160), (replace(seen, predicted=True),))
    bare, faint = (draw_result(LABELS, r, ["arm"], CAMERA).astype(int) for r in (nothing, one))
    full = draw_result(LABELS, FrameResult((200, 160), (seen,)), ["arm"], CAMERA).astype(int)
    middle = np.s_[240:280, 295:305]  # its y axis
    assert 0 < np.abs(faint - bare)[middle].max() < 0.7 * np.abs(full - bare)[middle].max()
    circle = np.abs(faint - bare).any(axis=2)[225:256, 270:330]
    assert circle.any(axis=1).all()


@pytest.mark.parametrize("z", [-1.0, 0.0, 1e-9])
def test_a_frame_behind_the_camera_is_not_drawn(z):
    assert np.array_equal(changed(found(Pose.from_xyz_rpy([0, 0, z])), camera=CAMERA), changed(found()))


@pytest.mark.parametrize("contour", [np.zeros((0, 2)), SQUARE + 1e9, SQUARE - 1e9])
def test_contours_that_are_missing_or_far_off_do_no_harm(contour):
    assert draw_result(LABELS, found(contour=contour), ["arm"]).shape == (480, 600, 3)


def test_objects_have_colours_of_their_own():
    names = ["a", "b", "c"]
    assert len({object_colour(names, n) for n in names}) == 3
    assert object_colour(["x", *names], "a") == object_colour(names, "b")
    assert object_colour([], "unknown") == object_colour(names, "a")


def test_rejected_candidates_are_marked_once_a_place_and_never_on_an_object():
    near = [Rejection("arm", "too small", 0.1 * i, 30 + i, 130) for i in range(5)]
    one = changed(FrameResult((200, 160), rejected=tuple(near[-1:])))
    five = changed(FrameResult((200, 160), rejected=tuple(near)))
    assert one[130, 34] and five[130, 34] and not five[130, 30]
    on_object = FrameResult((200, 160), found().detections, (Rejection("arm", "taken", 0.5, 90, 90),))
    assert np.array_equal(changed(on_object), changed(found()))
    assert not changed(FrameResult((200, 160), rejected=(Rejection("arm", "no place"),))).any()


def test_a_blob_that_led_to_nothing_has_a_text_only_where_its_object_is_not_found():
    blob = Rejection("arm", "no candidate", 0.0, 30, 130)
    assert changed(FrameResult((200, 160), rejected=(blob,)))[130, 30]
    beside = FrameResult((200, 160), found().detections, (blob, replace(blob, object="leg", x=160)))
    drawn = changed(beside)
    assert not drawn[130, 30] and drawn[130, 160]
    predicted = replace(found().detections[0], predicted=True, components=())  # nobody has seen it
    assert changed(FrameResult((200, 160), (predicted,), (blob,)))[130, 30]


def texts(monkeypatch, image, result, names=("arm",)):
    """What is written in the overlay, and the boxes (left, top, right, bottom) in which it stands."""
    found = []

    def note(picture, text, corner, font, size, colour, thick, line):
        (width, height), below = cv2.getTextSize(text, font, size, thick)
        found.append((text, (corner[0], corner[1] - height, corner[0] + width, corner[1] + below), height))

    monkeypatch.setattr(cv2, "putText", note)
    draw_result(image, result, names)
    return found


def test_reasons_are_told_whole(monkeypatch):
    long = "component 'forearm' is wanted: its angle to 'base' is 1.93 rad, " * 3
    rejected = (Rejection("arm", "too small", 0.9, 150, 60), Rejection("arm", long, 0.5, 30, 60))
    told = " ".join(text for text, _, _ in texts(monkeypatch, LABELS, FrameResult((200, 160), rejected=rejected)))
    assert " ".join(long.split()) in told and "..." not in told


def test_reasons_that_differ_by_numbers_alone_are_told_once_and_every_place_has_its_cross(monkeypatch):
    reasons = ("probability 0.31 is below 0.4", "all of it lies in others", "probability 0.05 is below 0.4")
    places = zip(reasons, (0.3, 0.2, 0.1), (30, 90, 150), strict=True)
    result = FrameResult((200, 160), rejected=tuple(Rejection("arm", why, score, x, 80) for why, score, x in places))
    drawn = changed(result)
    assert all(drawn[80, x] for x in (30, 90, 150))
    assert [text for text, _, _ in texts(monkeypatch, LABELS, result)] == [f"arm: {why}" for why in reasons[:2]]


def test_reasons_keep_off_what_they_speak_of(monkeypatch):
    """What is turned down may be an object that is missed: each reason lies beside its place and all others."""
    image, places = np.zeros((480, 640), np.uint8), ((200, 200), (230, 225), (260, 240))
    whys = ("too small", "too large", "hidden")
    rejected = (Rejection("arm", w, 0.5, *at) for w, at in zip(whys, places, strict=True))
    told = texts(monkeypatch, image, FrameResult((640, 480), rejected=tuple(rejected)))
    assert len(told) == 3
    for _, (left, top, right, bottom), height in told:
        for x, y in places:
            assert max(left - x, x - right, top - y, y - bottom) > 2 * height


def test_the_best_candidates_reason_stands_along_the_bottom_where_there_is_no_room_beside_it():
    long = " ".join(["why"] * 400)
    bottom = changed(FrameResult((200, 160), rejected=(Rejection("arm", long, 0.5, 30, 60),)))[130:]
    assert bottom[:, :20].any() and bottom[:, -40:].any() and not bottom[:, -1].any()


def small_robots(count, spread, side=7.0):
    """A frame of small square objects close together."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * side
    places = np.random.default_rng(4).uniform(-spread, spread, (count, 2)) + (320, 240)
    parts = [(Instance("base", "m", 0.9, x, y, 0.0, 100, corners + (x, y)),) for x, y in places]
    made = (Detection("arm", n, 0.9, ImagePose(*p, 0, 100), parts[n]) for n, p in enumerate(places))
    return FrameResult((640, 480), tuple(made))


@pytest.mark.parametrize(("spread", "least"), [(200, 10), (60, 8), (20, 5)])
def test_names_lie_beside_objects_and_cover_neither_them_nor_each_other(monkeypatch, spread, least):
    result = small_robots(10, spread)
    boxes = [box for _, box, _ in texts(monkeypatch, np.zeros((480, 640), np.uint8), result)]
    objects = [(*d.components[0].contour.min(axis=0), *d.components[0].contour.max(axis=0)) for d in result.detections]
    assert len(boxes) >= least
    for n, (left, top, right, bottom) in enumerate(boxes):
        for other in [*boxes[n + 1 :], *objects]:
            assert right < other[0] or other[2] < left or bottom < other[1] or other[3] < top


def test_a_name_that_lies_apart_is_tied_to_its_object():
    crowd = small_robots(10, 40)
    image = np.zeros((480, 640), np.uint8)
    lines = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cv2, "line", lambda picture, start, end, *_: lines.append((start, end)))
        draw_result(image, crowd, ["arm"])
    contours = [np.float32(d.components[0].contour) for d in crowd.detections]
    assert lines and all(any(cv2.pointPolygonTest(c, np.float32(e), True) > -15 for c in contours) for _, e in lines)


def test_texts_grow_with_the_picture(monkeypatch):
    heights = [texts(monkeypatch, np.zeros((h, w, 3), np.uint8), found())[0][2] for h, w in ((480, 640), (1000, 1280))]
    assert heights[1] == pytest.approx(2 * heights[0], abs=2)


def hue(colour) -> float:
    return colorsys.rgb_to_hsv(*(c / 255 for c in reversed(colour)))[0] * 360


def test_objects_named_after_a_colour_are_drawn_in_it():
    names = ["red", "blue", "team_Green", "yellow_2", "infrared", "big-red"]
    red, blue, green, yellow, other, second = (object_colour(names, n) for n in names)
    for colour, degrees in ((red, 0), (blue, 215), (green, 120), (yellow, 55), (second, 0)):
        assert abs((hue(colour) - degrees + 180) % 360 - 180) < 15
    assert len({red, second, other}) == 3
    assert object_colour(["blue", "red"], "red") == red, "whatever the order"


def test_names_stay_within_the_picture():
    for x, y in ((0, 0), (199, 0), (0, 159), (199, 159)):
        parts = (Instance("base", "m", 0.9, x, y, 0.0, 100),)
        result = FrameResult((200, 160), (Detection("arm", 0, 0.9, ImagePose(x, y, 0, 100), parts),))
        assert 120 < changed(result).sum() < 2500


def test_every_label_has_one_colour_and_low_ones_differ():
    picture = class_picture(np.arange(256, dtype=np.uint16)[None] * 1)
    assert picture.shape == (1, 256, 3)
    assert len({tuple(c) for c in picture[0, :8]}) == 8
    assert np.array_equal(class_picture(np.array([[300]], np.uint16))[0, 0], picture[0, 255])


def test_classes_are_drawn_in_the_colours_that_they_are_named_after():
    labels = np.array([[0, 1, 2, 3, 9]])
    named = class_picture(labels, (("team_yellow", 1), ("green", 2), ("ball", 3)))[0].astype(int)
    blue, green, red = named[1]
    assert min(green, red) > 2 * blue, "yellow"
    assert named[2, 1] == named[2].max() > 1.5 * named[2, 2], "green"
    assert named.max() < 200, "muted: outlines stand out"
    plain = class_picture(labels)[0]
    assert (named[[0, 3, 4]] == plain[[0, 3, 4]]).all(), "what is named after no colour looks as ever"


def test_an_error_is_written_out():
    picture = draw_error((320, 240), "damaged image " * 10)
    assert picture.shape == (240, 320, 3) and (picture > 100).any()

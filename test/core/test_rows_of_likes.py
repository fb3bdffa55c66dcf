"""Objects with rows of like parts, of which joints slide some: a pose one place off along a row bends all else to where
it is seen for all that. What lacks a part is laid on its likes, too, and told as sure as it is among these."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import pytest
from settings import settings

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.simulation.simulator import pinhole_camera
from artrec_ros.simulation.surfaces import component_poses

SIZE, LABEL, PITCH = (640, 480), 1, 0.08
MEN = {"row": [2, 1, 0, -1, -2], "three": [1.75, 0, -1.75], "two": [1, -1]}  # places along their rods, in pitches
RODS = {"three": (-0.2, 0.12), "two": (0.19, 0.14)}  # of those that slide: where they are, and how far they go
CAMERA = pinhole_camera(SIZE, 56.14)
LIES = rotation_from_rotvec([0.0, 0.0, 0.4]) @ np.diag([1.0, -1.0, -1.0])


def man(pitches: float) -> Marker:
    w, h = 0.011, 0.0135
    outline = np.array([(-w, -h), (w, -h), (w, h), (-w, h)])
    place = Pose(np.eye(3), np.array([0.0, PITCH * pitches, 0.0]))
    return Marker("man", outline, np.array([-w, 0.0]), np.array([w, 0.0]), None, place)


def team() -> ObjectModel:
    parts = [Component(f"row{n}", (man(y),), required=n == 2) for n, y in enumerate(MEN["row"])]
    for rod, (x, reach) in RODS.items():
        slides = Joint(
            "row2", Pose(np.eye(3), np.array([x, 0, 0])), np.array([0, 1.0, 0]), -reach, reach, "prismatic", rod
        )
        parts.append(Component(f"{rod}0", (man(MEN[rod][0]),), joint=slides))
        for n, y in enumerate(MEN[rod][1:], 1):
            fixed = Joint(f"{rod}0", Pose.identity(), np.array([0, 0, 1.0]), 0.0, 0.0, "fixed", f"{rod}{n}")
            parts.append(Component(f"{rod}{n}", (man(y),), joint=fixed))
    return ObjectModel("team", tuple(parts))


@cache
def recognizer() -> Recognizer:
    config = settings(time_budget_ms=60_000.0, memory=False)
    return Recognizer([Target("team", team(), LABEL)], config, Segmenter(ImageConfig()))


def chain(links: int = 3, off: float = 0.0) -> ObjectModel:
    """Links that look the same from either end, but for how far the markers are off their middles, metres."""
    w, h, gap = 0.05, 0.018, 0.012
    outline = np.array([(-w, -h), (w, -h), (w, h), (-w, h)]) / 2
    place = Pose(np.eye(3), np.array([(w + gap) / 2 + off, 0.0, 0.0]))
    link = Marker("link", outline, np.array([-w / 2, 0.0]), np.array([w / 2, 0.0]), None, place)
    on = Pose(np.eye(3), np.array([w + gap, 0.0, 0.0]))
    joints = [Joint(f"link{n}", on, np.array([0, 0, 1.0]), -0.6, 0.6, "revolute", f"j{n}") for n in range(links - 1)]
    parts = [Component(f"link{n}", (link,), required=n == 0, joint=joint) for n, joint in enumerate([None, *joints])]
    return ObjectModel("chain", tuple(parts))


def picture(
    R: np.ndarray, joints: dict[str, float], hidden: tuple[str, ...] = (), model: ObjectModel | None = None
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """A label image of a team, or another object, .85 m in front of the camera, and its markers' middles, pixels."""
    model = model or team()
    image, at = np.zeros(SIZE[::-1], np.uint8), {}
    for name, pose in component_poses(model, joints).items():
        marker = model.component(name).markers[0]
        seen = (Pose(R, np.array([0.0, 0.0, 0.85])) @ pose @ marker.T_component_marker).apply(
            np.column_stack([marker.outline, np.zeros(4)])
        )
        corners = seen[:, :2] / seen[:, 2:] * CAMERA.focal_px + CAMERA.matrix[:2, 2]
        at[name] = corners.mean(axis=0)
        if name not in hidden:
            cv2.fillPoly(image, [np.rint(corners * 16).astype(np.int32)], LABEL, cv2.LINE_8, 4)
    return image, at


@pytest.mark.parametrize("camera", [None, CAMERA], ids=["flat", "in space"])
@pytest.mark.parametrize("hidden", [("row1",), ("row3", "two1"), ("three0",)], ids=",".join)
def test_it_is_told_where_it_is_though_a_part_is_hidden(hidden: tuple[str, ...], camera: Camera | None):
    R = LIES if camera is None else LIES @ rotation_from_rotvec([0.35, 0.1, 0.0])
    image, at = picture(R, {"three": -0.04, "two": 0.06}, hidden)
    (found,) = recognizer().recognize(image, camera).detections
    assert np.linalg.norm(np.array([found.image.x, found.image.y]) - at["row2"]) < 5
    assert {part.component for part in found.components} == at.keys() - set(hidden)
    off = [np.linalg.norm(np.array([part.x, part.y]) - at[part.component]) for part in found.components]
    assert max(off) < 5


@pytest.mark.parametrize("camera", [None, CAMERA], ids=["flat", "in space"])
def test_nothing_tells_two_places_apart_where_the_last_of_a_row_is_hidden(camera: Camera | None):
    image, at = picture(LIES, {"three": 0.0, "two": 0.0}, ("row4",))
    (found,) = recognizer().recognize(image, camera).detections
    assert found.other_place is not None and 0.3 < found.other_place.probability < 0.7
    places = np.array([(found.image.x, found.image.y), (found.other_place.image.x, found.other_place.image.y)])
    assert {n for n in at for place in places if np.linalg.norm(at[n] - place) < 5} == {"row2", "row1"}


@pytest.mark.parametrize("camera", [None, CAMERA], ids=["flat", "in space"])
@pytest.mark.parametrize(
    ("model", "joints"), [(chain(), {"j0": 0.3, "j1": -0.2}), (team(), {"three": -0.04, "two": 0.06})]
)
def test_what_is_seen_as_a_whole_is_as_sure_as_it_was(
    model: ObjectModel, joints: dict[str, float], camera: Camera | None
):
    """A chain that looks the same from either end is told from one of these."""
    config = settings(time_budget_ms=60_000.0, memory=False)
    whole = Recognizer([Target(model.name, model, LABEL)], config, Segmenter(ImageConfig()))
    (found,) = whole.recognize(picture(LIES, joints, model=model)[0], camera).detections
    assert len(found.components) == len(model.components)
    assert found.score > 0.95 and found.other_place is None


@pytest.mark.parametrize("camera", [None, CAMERA], ids=["flat", "in space"])
@pytest.mark.parametrize("hidden", ["link0", "link1", "link3"])
def test_a_chain_that_lacks_a_link_is_not_sure_of_its_end(hidden: str, camera: Camera | None):
    """What is seen may be the links one along from where the first is not, and what lies beyond a gap the other end."""
    config = settings(time_budget_ms=60_000.0, memory=False, min_probability=0.2)
    model, joints = chain(4, -0.006), {"j0": 0.45, "j1": -0.1, "j2": 0.3}
    recognise = Recognizer([Target("chain", model, LABEL)], config, Segmenter(ImageConfig())).recognize
    (found,) = recognise(picture(LIES, joints, (hidden,), model)[0], camera).detections
    assert found.score < 0.7 and found.other_place is not None
    assert recognise(picture(LIES, joints, (), model)[0], camera).detections[0].score > 0.95

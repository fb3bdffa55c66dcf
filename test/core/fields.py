"""Flat robots on a field that a camera sees at a slant: rendered label images of known truth."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from artrec_ros.core.base.config import PlaneConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rpy
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel

TEAM, ACCENT, SIZE = 1, 2, (640, 480)
_TIMES = 4  # sub-pixels in each direction: a pixel belongs to what covers most of it
CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.8], [0.0, 0.8]])  # of the field, metres


def square(name: str, side: float, pose: Pose | None) -> Marker:
    corners = side * (np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]) - 0.5)
    return Marker(name, corners, np.array([-side / 2, 0.0]), np.array([side / 2, 0.0]), None, pose)


def robot(side: float = 0.04, *, placed: bool = True, above: float = 0.0) -> ObjectModel:
    """Two squares that touch at a corner: the accent ahead and to the left.

    :param placed: the markers have places. :param above: the robot's frame, metres.
    """
    places = [Pose(np.eye(3), np.array([x, x, above])) if placed else None for x in (-side / 2, side / 2)]
    team = Component("team", (square("patch", side, places[0]),), required=True)
    return ObjectModel("robot", (team, Component("accent", (square("patch", side, places[1]),), label=ACCENT)))


def camera(px_per_m: float = 450.0, bend: Iterable[float] = ()) -> Camera:
    """Sees the field's middle from 2 m away, with so many pixels per metre there."""
    focal = px_per_m * 2.0
    K = np.array([[focal, 0, (SIZE[0] - 1) / 2], [0, focal, (SIZE[1] - 1) / 2], [0, 0, 1]])
    return Camera(K, np.array(list(bend), float), SIZE)


def camera_on_field(slant_deg: float) -> Pose:
    """T_camera_field: turned away from above by a slant, about the field's x."""
    R = rotation_from_rpy([np.pi - np.radians(slant_deg), 0.0, 0.0])
    return Pose(R, np.array([0.0, 0.0, 2.0]) - R @ np.append(CORNERS.mean(axis=0), 0.0))


def seen(cam: Camera, slant_deg: float, places: np.ndarray) -> np.ndarray:
    """(n, 2) pixels of places (n, 2) on the field."""
    return project(cam, camera_on_field(slant_deg).apply(np.column_stack([places, np.zeros(len(places))])))


def plane(cam: Camera, slant_deg: float, **values: Any) -> PlaneConfig:
    """What a user would give: the field's corners."""
    pixels = seen(cam, slant_deg, CORNERS)
    return PlaneConfig(tuple(pixels.ravel().tolist()), tuple(CORNERS.ravel().tolist()), **values)


def render(cam: Camera, slant_deg: float, side: float, robots: np.ndarray) -> np.ndarray:
    """(H, W) labels of robots x, y, yaw: their middles, where the squares touch."""
    width, height = SIZE
    votes = np.zeros((3, height, width))
    for x, y, yaw in robots:
        c, s = np.cos(yaw), np.sin(yaw)
        for label, at in ((TEAM, -side / 2), (ACCENT, side / 2)):
            corners = side * (np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]) - 0.5) + at
            dense = np.concatenate(
                [np.linspace(a, b, 9)[:-1] for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)]
            )
            outline = seen(cam, slant_deg, dense @ np.array([[c, s], [-s, c]]) + (x, y))
            (x0, y0), (x1, y1) = np.floor(outline.min(0)).astype(int), np.ceil(outline.max(0)).astype(int) + 1
            x0, y0, x1, y1 = max(x0, 0), max(y0, 0), min(x1, width), min(y1, height)
            sub = (np.arange(_TIMES) + 0.5) / _TIMES - 0.5
            u = (np.arange(x0, x1)[:, None] + sub).ravel()
            v = (np.arange(y0, y1)[:, None] + sub).ravel()
            inside = _inside(outline, *np.meshgrid(u, v))
            votes[label, y0:y1, x0:x1] += inside.reshape(y1 - y0, _TIMES, x1 - x0, _TIMES).mean(axis=(1, 3))
    votes[0] = 1 - votes.sum(axis=0)
    return votes.argmax(axis=0).astype(np.uint8)


def _inside(outline: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    inside = np.zeros(x.shape, bool)
    for (ax, ay), (bx, by) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if ay != by:
            inside ^= ((ay > y) != (by > y)) & (x < ax + (y - ay) * (bx - ax) / (by - ay))
    return inside

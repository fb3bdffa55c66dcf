"""Flat scenes of known truth: marker outlines placed in the image plane and filled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel


@dataclass(frozen=True)
class Placed:
    """A marker's centroid, axis direction and scale in the image: what annotations and truth hold."""

    x: float
    y: float
    theta: float
    scale: float

    def moved(self, x: float, y: float, theta: float, scale: float | None = None) -> Placed:
        """One more marker, placed in this one's frame (metres, radians)."""
        c, s = np.cos(self.theta), np.sin(self.theta)
        k = self.scale
        return Placed(self.x + k * (c * x - s * y), self.y + k * (s * x + c * y), self.theta + theta, scale or k)


def apply_similarity(T: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points under a batch of similarities.

    :param T: (H, 4) rows (tx, ty, theta, k): p -> t + k R(theta) p.
    :param points: (m, 2).
    :return: (H, m, 2).
    """
    a, b = T[:, 3] * np.cos(T[:, 2]), T[:, 3] * np.sin(T[:, 2])  # (H,)
    x = a[:, None] * points[:, 0] - b[:, None] * points[:, 1] + T[:, 0:1]  # (H, m)
    y = b[:, None] * points[:, 0] + a[:, None] * points[:, 1] + T[:, 1:2]  # (H, m)
    return np.stack([x, y], axis=-1)


def draw(labels: np.ndarray, marker: Marker, placed: Placed, label: int) -> None:
    """Fill a marker's outline: a pixel belongs to it exactly when its centre lies inside (even-odd rule)."""
    T = np.array([[placed.x, placed.y, placed.theta - marker.axis_angle, placed.scale]])
    outline = apply_similarity(T, marker.image_outline)[0]
    low = np.maximum(np.floor(outline.min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(outline.max(axis=0)).astype(int) + 1, labels.shape[::-1])
    x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
    inside = np.zeros(x.shape, bool)
    for (ax, ay), (bx, by) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if ay != by:
            inside ^= ((ay > y) != (by > y)) & (x < ax + (y - ay) * (bx - ax) / (by - ay))
    labels[low[1] : high[1], low[0] : high[0]][inside] = label


def render(
    size: tuple[int, int], model: ObjectModel, objects: list[Mapping[tuple[str, str], Placed]], label: int
) -> np.ndarray:
    """(H, W) label image; later components cover earlier ones. `size` is (width, height)."""
    labels = np.zeros(size[::-1], np.uint8)
    for placed in objects:
        for (component, marker), place in placed.items():
            part = model.component(component)
            draw(labels, part.marker(marker), place, part.label or label)
    return labels


def polygon(name: str, *points: tuple[float, float], axis: tuple | None = None) -> Marker:
    outline = np.array(points, float)
    tail, head = axis or (outline.mean(axis=0), outline.mean(axis=0) + [np.ptp(outline[:, 0]) / 2, 0])
    return Marker(name, outline, np.array(tail), np.array(head))


def rectangle(name: str, width: float, height: float) -> Marker:
    w, h = width / 2, height / 2
    return polygon(name, (-w, -h), (w, -h), (w, h), (-w, h), axis=((-w, 0), (w, 0)))


def disc(name: str, radius: float, sides: int = 64) -> Marker:
    a = 2 * np.pi * np.arange(sides) / sides
    outline = radius * np.stack([np.cos(a), np.sin(a)], axis=1)
    return Marker(name, outline, np.zeros(2), np.array([radius, 0.0]), disc_radius=radius)


def capsule(name: str, radius: float, length: float) -> Marker:
    """`length` between the cap centres, along x."""
    a = np.linspace(-np.pi / 2, np.pi / 2, 13)
    cap = radius * np.stack([np.cos(a), np.sin(a)], axis=1)
    outline = np.concatenate([cap + [length / 2, 0], -cap - [length / 2, 0]])
    return Marker(name, outline, np.array([-length / 2, 0.0]), np.array([length / 2, 0.0]))


def flag(name: str = "flag", mirrored: bool = False) -> Marker:
    """A shape without any symmetry."""
    points = np.array([(-0.5, -0.2), (0.4, -0.2), (0.6, 0.0), (0.4, 0.2), (-0.1, 0.2), (-0.1, 0.5), (-0.5, 0.5)])
    if mirrored:
        points = points * (-1, 1)
    sign = -1.0 if mirrored else 1.0
    return Marker(name, points, np.array([-0.5 * sign, 0.0]), np.array([0.6 * sign, 0.0]))


def crane() -> ObjectModel:
    """A required flag, and two like ribbons that swing on it."""
    return ObjectModel(
        "crane",
        (
            Component("base", (flag(), flag("flag_mirrored", True)), required=True),
            Component("fore", (rectangle("bar", 0.8, 0.16),)),
            Component("aft", (rectangle("bar", 0.8, 0.16),)),
        ),
    )


def crane_placed(
    x: float, y: float, theta: float, scale: float, swings: tuple[float, float] = (0.0, 0.0), mirrored: bool = False
) -> dict[tuple[str, str], Placed]:
    """The base at (x, y); bars hang from (0.45, 0.5) and (-0.45, 0.5) of it and swing about there."""
    base = Placed(x, y, theta, scale)
    side = -1.0 if mirrored else 1.0  # the mirrored view: y of the base's own frame turns over
    placed = {("base", "flag_mirrored" if mirrored else "flag"): base}
    for name, along, swing in (("fore", 0.45, swings[0]), ("aft", -0.45, swings[1])):
        angle = side * (np.pi / 2 + swing)
        reach = 0.4
        placed[name, "bar"] = base.moved(along + reach * np.cos(angle), side * 0.5 + reach * np.sin(angle), angle)
    return placed

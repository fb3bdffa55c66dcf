"""How far found markers lie from annotated ones in the image, and how far they are turned."""

from __future__ import annotations

import numpy as np

from ...core.geometry.transforms import Array, wrap_angle
from ...core.model.found import Detection
from ...io.truth.records import TrueObject

_APART_PX = 2.0  # root mean square about their middle: places that are nearer to each other tell no direction


def image_errors(d: Detection, o: TrueObject) -> tuple[tuple[float, float | None], ...]:
    """Pixels and radians of each component whose own marker was annotated; of what has no direction no radians.

    Where none has one, as of a robot with several discs, their places together tell one: that is the first one's.
    """
    places, turns = list[tuple[Array, Array]](), list[float | None]()
    for c in d.components:
        key = f"{c.component}/{c.marker}"
        axis, marker = o.axes.get(key), o.components.get(f"{c.component}@{c.marker}")
        if axis is not None and marker is not None and marker.centre is not None:
            along = np.arctan2(*(axis[1] - axis[0])[::-1])
            places.append((np.array([c.x, c.y]), marker.centre))
            turns.append(None if key in o.undirected else float(abs(wrap_angle(c.theta - along))))
    if turns and all(turn is None for turn in turns):
        turns[0] = _turn_of(*np.array(places).swapaxes(0, 1))
    off_px = [float(np.hypot(*(found - true))) for found, true in places]
    return tuple(zip(off_px, turns, strict=True))


def _turn_of(found: Array, true: Array) -> float | None:
    """By how much places (n, 2) are turned from the true ones, radians: that of the similarity that lays these on them
    with the least squares (Umeyama 1991, in the plane). None: they are too near to each other, or one."""
    a, b = ((places - places.mean(axis=0)) @ (1, 1j) for places in (true, found))
    if min(np.sqrt(np.mean(np.abs(a) ** 2)), np.sqrt(np.mean(np.abs(b) ** 2))) < _APART_PX:
        return None
    return float(abs(np.angle(np.vdot(a, b))))

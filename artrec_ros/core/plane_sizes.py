"""How large objects look beside what the scene's plane has: a plane that is off is told by all of them together."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

import numpy as np

from .model.found import Detection

_LEAST, _SURE = 10, 0.7  # objects, of at least this score, that tell anything
_OFF = 0.08  # outlines drawn by eye and paint that spreads make objects look larger or smaller by so much
_ENDS = 5, 95  # per cent of the objects, along the size that their places have
_DEVIATIONS = 2.0  # by which that size must be off beyond _OFF: few small objects scatter by so much


class PlaneSizes:
    """Of objects on the plane. :param latest: so many of them; None: all."""

    def __init__(self, latest: int | None = None) -> None:
        # x, y, logarithm of how many times as large
        self._seen = deque[tuple[float, float, float]](maxlen=latest)

    def add(self, detections: Iterable[Detection]) -> None:
        sure = (d for d in detections if d.plane_scale and d.score >= _SURE and not d.predicted)
        self._seen += [(d.image.x, d.image.y, float(np.log(d.plane_scale or 1.0))) for d in sure]

    def line(self) -> str | None:
        """What to tell of them; None where they are as large as they should be."""
        if len(self._seen) < _LEAST:
            return None
        seen = np.array(self._seen)
        about = np.column_stack([np.ones(len(seen)), seen[:, :2] - seen[:, :2].mean(axis=0)])
        onto = about @ np.linalg.pinv(about)
        large = onto @ seen[:, 2]  # a tilted plane is off otherwise elsewhere
        scatter = np.sum((seen[:, 2] - large) ** 2) / (len(seen) - about.shape[1])
        unsure = _DEVIATIONS * np.sqrt(scatter * np.diag(onto))
        if max(-np.percentile(large + unsure, _ENDS[0]), np.percentile(large - unsure, _ENDS[1])) < _OFF:
            return None
        least, most = np.percentile(large, _ENDS).tolist()
        return (
            f"objects look {_as_told(least, most)} than scene.plane has them ({len(seen)} of them): its points, or "
            "lengths in the object file, are off; where the plane is, poses are by as much, whatever covariances say"
        )


def _as_told(least: float, most: float) -> str:
    """:param least, most: logarithms."""
    low, high = (100 * np.expm1(value) for value in (least, most))
    if low > -1:
        return f"{max(low, 0):.0f} to {high:.0f} % larger"
    if high < 1:
        return f"{max(-high, 0):.0f} to {-low:.0f} % smaller"
    return f"between {-low:.0f} % smaller and {high:.0f} % larger"

"""Rotations that are off by turns after which an object looks the same: no picture tells these."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ...core.geometry.transforms import Array, rotation_from_rotvec
from ...core.model.objects import ObjectModel
from ...core.model.same_turns import SameTurn, same_turns
from .outcomes import Outcome

_LEAST_SHARE = 0.05  # of rotations: what is rarer is not worth a line
_FAR_RAD = np.radians(15.0)  # an error that is less is none of another turn


def turned_alike(outcomes: Sequence[tuple[str, Outcome]], models: Mapping[str, ObjectModel]) -> Iterator[str]:
    """A line for each object of which many rotations are off so. :param outcomes: object name and outcome."""
    for name in dict.fromkeys(name for name, _ in outcomes):
        pairs = [
            (o.detection.pose.rotation, o.truth.pose.rotation)
            for n, o in outcomes
            if n == name and o.rotation_error_rad is not None and o.detection and o.detection.pose and o.truth.pose
        ]
        turns = same_turns(models[name]) if pairs and name in models else []
        if not turns:
            continue
        found, true = (np.array(rotations) for rotations in zip(*pairs, strict=True))
        off = _angle(true, found)
        least = np.min([off, *(_angle(true @ S, found) for S in _all_of(turns))], axis=0)
        alike = (off > _FAR_RAD) & (least < off / 2)
        if alike.mean() > _LEAST_SHARE:
            yield (
                f"'{name}' looks the same after some turns (artrec model says which): {alike.sum()} of {len(off)} "
                f"rotations are off by such a one, which no picture tells; but for these by "
                f"{np.degrees(np.median(least)):.2f} deg in the median"
            )


def _all_of(turns: Sequence[SameTurn]) -> list[Array]:
    """Rotations by them, as often as they can be done, and by two of them."""
    single = [
        rotation_from_rotvec(k * turn.angle_rad * turn.axis)
        for turn in turns
        for k in range(1, round(2 * np.pi / turn.angle_rad))
    ]
    return [*single, *(a @ b for a in single for b in single)]


def _angle(a: Array, b: Array) -> Array:
    """(n,) between rotations (n, 3, 3), radians."""
    return np.asarray(np.arccos(np.clip((np.einsum("nij,nij->n", a, b) - 1) / 2, -1, 1)))

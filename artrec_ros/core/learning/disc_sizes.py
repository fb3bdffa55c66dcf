"""Discs whose size beside the object's first marker differs from picture to picture.

Of a disc only the middle counts where lengths are measured, so that marks fit though no two pictures show it as large.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..base.config import FacingConfig
from ..geometry.transforms import Array
from ..model.objects import ObjectModel
from .marked_views import Marks, axis_ends, markers_of
from .view_fit import CLICK_PX

_SURE = 3.0  # deviations of clicks
_HALF_STEP = math.sqrt(FacingConfig.scale_ratio)  # what differs by more is near to no scale that is tried


class Uneven(NamedTuple):
    """:param times: (n,) in each picture that shows both, how many times as large the disc is marked beside the first
    marker as the object file has it. :param places: of these. :param off: in how many of them it is larger or smaller
    than mostly by more than what is searched."""

    marker: tuple[str, str]
    first: tuple[str, str]
    radius_m: float
    times: Array
    places: Sequence[str]
    off: int


def uneven_discs(model: ObjectModel, marks: Sequence[Marks]) -> Iterator[Uneven]:
    """Of a flat object that is marked straight from above."""
    known = markers_of(model)
    names = [(model.components[c].name, m.name) for c, m, _ in known]
    long_m = np.array([np.linalg.norm(np.diff(axis_ends(m), axis=0)) for _, m, _ in known])
    root = next(n for n, name in enumerate(names) if name[0] == model.required.name)
    lengths = [np.linalg.norm(m.ends[:, 1] - m.ends[:, 0], axis=1).tolist() for m in marks]
    seen = [dict(zip(m.marker.tolist(), own, strict=True)) for m, own in zip(marks, lengths, strict=True)]
    for n, (_, marker, _) in enumerate(known) if model.is_flat else ():
        both = [k for k, own in enumerate(seen) if n in own and root in own and min(own[n], own[root]) > 0]
        if marker.disc_radius is None or n == root or not both:
            continue
        long_px = np.array([(seen[k][root], seen[k][n]) for k in both])
        times = long_px[:, 1] / long_m[n] / (long_px[:, 0] / long_m[root])
        clicks = _SURE * math.sqrt(2) * CLICK_PX * np.linalg.norm(1 / long_px, axis=1)
        off = np.abs(np.log(times / np.median(times))) - clicks > math.log(_HALF_STEP)
        if off.any():
            places = [marks[k].place for k in both]
            yield Uneven(names[n], names[root], marker.disc_radius, times, places, int(off.sum()))

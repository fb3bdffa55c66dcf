"""Objects whose like markers lie in rows: of other things in such rows some look like them, laid otherwise."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.model.marker import Marker
from ...core.model.objects import ObjectModel

_LEAST = 6  # markers: with fewer, chance does as much as rows
_SHARE = 0.5  # of them that lie where others did, from which on it is told
_NEAR = 0.2  # of a marker's size: places that are the same


def in_rows(model: ObjectModel) -> Iterator[str]:
    """A line where nothing but the ends of their rows tells how an object's markers lie, and nothing bears them."""
    rigid = [c for c in model.components if c.joint is None and c.markers]
    if not model.is_spatial or model.unique or any(c.bodies for c in model.components) or len(rigid) < _LEAST:
        return
    markers = [c.markers[0] for c in rigid]
    shift = _moved_onto_others(markers, [c.label for c in rigid])
    if shift >= _SHARE * len(markers):
        yield (
            f"moved along their rows, {shift} of {len(markers)} markers lie where others did: of other things of their "
            "class in rows, as tags or tiles, some will be taken for it. A `body` that bears them, `unique: true` "
            "where there is but one, or recognizer.min_components keeps these away"
        )


def _moved_onto_others(markers: list[Marker], labels: list[int | None]) -> int:
    """So many at most lie where like ones did, all moved by the same."""
    middles = np.array([m.centre for m in markers])
    sizes = np.array([np.ptp(m.outline, axis=0) for m in markers])
    near = _NEAR * sizes.max(axis=1)
    like = (np.abs(sizes[:, None] - sizes) < near[:, None, None]).all(axis=2)
    like &= np.array([[a == b for b in labels] for a in labels])
    most = 0
    for i, j in np.argwhere(like & ~np.eye(len(markers), dtype=bool)).tolist():
        moved = middles + (middles[j] - middles[i])
        there = np.linalg.norm(moved[:, None] - middles, axis=2) < near
        most = max(most, int((there & like).any(axis=1).sum()))
    return most

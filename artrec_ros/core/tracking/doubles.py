"""Which objects of one name would be in one place: there is room for one there.

A detection that lies farther from its track than that can have come is another object to a filter. Where it lies on the
place of one that nobody else has seen it is that one, which leapt, be it the place that is expected, or, as where the
camera is shaken, the one before; else one object would have two tracks, each of which hides the other, and take their
names in turn.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..base.config import SightingsConfig
from ..geometry.transforms import Array
from ..model.found import Detection
from .sightings import Sightings
from .tracks import Tracks

_APART = 0.5  # of the required component's size: bodies that are narrow stand side by side at little more
_YOUNG_S = 0.2  # what is older stays for its own sake
_LEAP = 2.0  # as `Places.apart`: so far, by the size itself, one is from where it was in the frame before


class Places(NamedTuple):
    """Of N objects: names (N,), places before the camera (N, 3) metres, NaN where that is not known, and in the image
    (N, 2) pixels; sizes (N,) of their required components in both, 0: not known."""

    names: Sequence[str]
    position: Array
    pixels: Array
    size_m: Array
    size_px: Array

    @classmethod
    def found(cls, names: Sequence[str], s: Sightings) -> Places:
        """Of detections. :param names: (N,) of their objects."""
        position = np.where(s.posed[:, None], s.position, np.nan)
        return cls(names, position, s.place[:, :2], s.size_m, s.size_m * s.unit[:, 0])

    @classmethod
    def expected(cls, tracks: Tracks, sizes: Mapping[str, float]) -> Places:
        """Of tracks, where they are expected. :param sizes: object's name -> size of its required component, metres."""
        place, size_m = tracks.expected, np.array([sizes.get(name, 0.0) for name in tracks.names])
        position = np.where(tracks.in_camera[:, None], tracks.bodies.motion.place[:, :3], np.nan)
        return cls(tracks.names, position, place[:, :2], size_m, size_m * np.exp(place[:, 2]))

    def apart(self, others: Places) -> Array:
        """(N, M) how far each is from others of its name, 1 from where on both have room; infinite of another name."""
        metres = np.linalg.norm(self.position[:, None] - others.position, axis=-1) / self.size_m[:, None].clip(1e-9)
        pixels = np.linalg.norm(self.pixels[:, None] - others.pixels, axis=-1) / self.size_px[:, None].clip(1e-9)
        same = np.array(self.names)[:, None] == np.array(others.names)
        return np.where(same, np.where(np.isnan(metres), pixels, metres) / _APART, np.inf)


def leaps(found: Places, lost: Tracks, sizes: Mapping[str, float], dt_s: float, config: SightingsConfig) -> Array:
    """(N, M) how far detections are from tracks that nothing continues, 1 from where on they are none of these: from
    where these are expected, or, farther, from where they were in the frame before, dt_s ago."""
    last = Places.found(lost.names, Sightings.of(lost.last, sizes, config))
    before = np.where(lost.age_s <= 1.5 * dt_s, found.apart(last) / _LEAP, np.inf)
    return np.asarray(np.minimum(found.apart(Places.expected(lost, sizes)), before), np.float64)


def doubles(tracks: Tracks, here: Sequence[int], sizes: Mapping[str, float]) -> set[int]:
    """Tracks in the places of those that are seen, where one of both is young: who have stood side by side for a
    while are two, if narrow ones. :param here: rows of those that are seen."""
    lost = [row for row in range(len(tracks)) if row not in here]
    if not here or not lost:
        return set()
    there, seen = (Places.expected(tracks[list(rows)], sizes) for rows in (lost, here))
    young = tracks.lived_s < _YOUNG_S
    double = (there.apart(seen) < 1) & (young[lost][:, None] | young[list(here)])
    return {lost[k] for k in np.flatnonzero(double.any(axis=1)).tolist()}


def beside_others(tracks: Tracks, found: Mapping[int, Detection], sizes: Mapping[str, float]) -> set[int]:
    """Tracks that are not seen in whose places something is that may be they: `Detection.other_object`.

    :param found: what is seen, by rows.
    """
    rivals = {row: d.other_object.object for row, d in found.items() if d.other_object is not None}
    lost = [row for row in range(len(tracks)) if row not in found]
    if not rivals or not lost:
        return set()
    there, seen = (Places.expected(tracks[list(rows)], sizes) for rows in (lost, rivals))
    may_be = there.apart(seen._replace(names=list(rivals.values()))) < 1
    return {lost[k] for k in np.flatnonzero(may_be.any(axis=1)).tolist()}

"""A pair of markers: its configuration, and the box of what is allowed of it (paper, steps 6 and 7).

The configuration T_ij of two markers is (rho, alpha, beta): distance of the centroids over the scale k (so
in metres on the marker's plane), direction of i -> j seen from i's axis, angle from i's axis to j's; and the
ratio of the scales. Where examples have rho near zero, alpha means nothing: there the place of j is kept as
(dx, dy)/k in i's frame. k is the geometric mean of both scales. T_ji follows from T_ij: each pair is kept once.

A marker that looks the same after turns by 2 pi / m has its axis in any of m directions. Where i's and j's symmetries
have orders m and n, beta is thus known up to multiples of 2 pi / m and of 2 pi / n, which together make all multiples
of 2 pi / lcm(m, n); alpha up to those of 2 pi / m alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.config import LearningConfig
from ..base.errors import ConfigError
from ..geometry.transforms import Array, wrap_angle
from .intervals import Interval, expected_coverage, interval_from_list

Key = tuple[str, str]  # (component, marker)

ANGLES = ("bearing_rad", "turn_rad")
_LEAST_WIDTH = LearningConfig().least_width  # radians, shares of a ratio, shares of the pair's greatest distance
_LEAST_REACH_M = 1e-6  # of markers whose centroids coincide
DIMENSIONS = ("distance_m", "offset_x_m", "offset_y_m", *ANGLES, "scale_ratio", "distance_px")


@dataclass(frozen=True)
class PairConstraint:
    """What was seen of one pair of markers, and what is allowed.

    :param allowed: dimension -> interval that is checked; a dimension without meaning for the pair is absent.
    :param seen: dimension -> the examples' own span (the paper's box, with `distance_px`).
    :param examples: how many examples showed the pair.
    """

    first: Key
    second: Key
    examples: int
    allowed: Mapping[str, Interval]
    seen: Mapping[str, Interval]

    @property
    def coverage_seen(self) -> float:
        """Share of new examples that the bare box can be expected to hold."""
        return expected_coverage(self.examples) ** len(self.allowed)

    @property
    def reach_m(self) -> float:
        """The farthest that the two centroids may lie apart."""
        if "distance_m" in self.allowed:
            return max(0.0, self.allowed["distance_m"].high)
        offsets = [i for d, i in self.allowed.items() if d.startswith("offset_")]
        return float(np.linalg.norm([max(abs(i.low), abs(i.high)) for i in offsets]))

    def least_width(self, dimension: str) -> float:
        """The width below which a box is not resolved by any image."""
        return _LEAST_WIDTH * (max(self.reach_m, _LEAST_REACH_M) if dimension.endswith("_m") else 1.0)

    def chance(self, reach_m: float) -> float:
        """The background model: share of markers that satisfy the constraint though they have nothing to do with
        the first, lying anywhere within `reach_m` of it, turned anyhow, up to half or twice as large."""
        spans = {d: i.width / i.period if i.period else i.width for d, i in self.allowed.items()}
        share = spans.get("turn_rad", 1.0) * spans.get("bearing_rad", 1.0)
        if "distance_m" in self.allowed:
            low, high = max(self.allowed["distance_m"].low, 0.0), self.allowed["distance_m"].high
            share *= (high**2 - low**2) / max(reach_m, high, 1e-9) ** 2
        elif "offset_x_m" in self.allowed and "offset_y_m" in self.allowed:
            area = self.allowed["offset_x_m"].width * self.allowed["offset_y_m"].width
            share *= area / (np.pi * max(reach_m, 1e-9) ** 2)
        ratio = self.allowed.get("scale_ratio")
        if ratio is not None:
            share *= np.log(min(ratio.high, 2.0) / min(max(ratio.low, 0.5), 2.0)) / np.log(4.0)
        return float(np.clip(share, 1e-6, 1.0))


def pair_to_dict(p: PairConstraint) -> dict[str, Any]:
    """Plain values for a file."""
    row: dict[str, Any] = {"first": "/".join(p.first), "second": "/".join(p.second), "examples": p.examples}
    row["allowed"] = {d: _interval_to_list(d, i) for d, i in p.allowed.items()}
    row["seen"] = {d: _interval_to_list(d, i) for d, i in p.seen.items()}
    return row


def _interval_to_list(dimension: str, interval: Interval) -> list[float]:
    """[low, high], and an angle's period where it is not the full turn."""
    ends = [round(interval.low, 6), round(interval.high, 6)]
    return [*ends, round(interval.period, 6)] if dimension in ANGLES and interval.period < 6.28 else ends


def pair_from_dict(row: Any, where: str) -> PairConstraint:
    """Inverse of `pair_to_dict`. Raises `ConfigError` naming `where` and key."""
    try:
        first, second = (key_from_text(str(row[k])) for k in ("first", "second"))
        where = f"{where} ({row['first']} - {row['second']})"
        boxes = [{d: _interval(d, v, f"{where}: {k}") for d, v in row[k].items()} for k in ("allowed", "seen")]
        return PairConstraint(first, second, int(row["examples"]), *boxes)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ConfigError(
            f"{where}: needs first and second (component/marker), examples, allowed and seen: {error!r}"
        ) from error


def key_from_text(text: str) -> Key:
    """COMPONENT/MARKER taken apart; `ValueError` where it is not that."""
    component, marker = text.split("/")
    return component, marker


def _interval(dimension: str, ends: Any, where: str) -> Interval:
    if dimension not in DIMENSIONS:
        raise ConfigError(f"{where}: '{dimension}' is none of {', '.join(DIMENSIONS)}")
    where = f"{where}: {dimension}"
    if dimension in ANGLES:
        return interval_from_list(ends, where, 2 * np.pi)
    if len(ends) != 2:
        raise ConfigError(f"{where}: {list(ends)} must be [low, high]")
    interval = interval_from_list(ends, where)
    if dimension.startswith("distance_") and interval.high < 0:
        raise ConfigError(f"{where}: {list(ends)} holds for no pair: distances are 0 or more, so high must be, too")
    if dimension == "scale_ratio" and interval.high <= 0:
        raise ConfigError(f"{where}: {list(ends)} holds for no pair: ratios are above 0, so high must be, too")
    return interval


def configuration(first: Any, second: Any) -> dict[str, Array]:
    """T_ij in every dimension, for instances or for arrays of them that broadcast (paper, step 6)."""
    dx, dy = second.x - first.x, second.y - first.y
    k = np.sqrt(first.scale * second.scale)
    rho = np.hypot(dx, dy)
    bearing = wrap_angle(np.arctan2(dy, dx) - first.theta)
    return {
        "distance_m": rho / k,
        "offset_x_m": rho / k * np.cos(bearing),
        "offset_y_m": rho / k * np.sin(bearing),
        "bearing_rad": bearing,
        "turn_rad": wrap_angle(second.theta - first.theta),
        "scale_ratio": np.asarray(second.scale / first.scale),
        "distance_px": np.asarray(rho),
    }


def configuration_noise(first: Any, second: Any, T: Mapping[str, Array]) -> dict[str, Array]:
    """Standard deviation of each dimension of a configuration T that is checked.

    :param first, second: `candidates.ImagePoses`: places with their own noise.
    """
    place_px = np.hypot(first.place_noise_px, second.place_noise_px)
    place = place_px / np.sqrt(first.scale * second.scale)
    offset = np.hypot(place, T["distance_m"] * first.theta_noise)
    scale_noise = np.hypot(first.scale_noise, second.scale_noise)
    return {
        "distance_m": np.hypot(place, T["distance_m"] * scale_noise / 2),  # k is the geometric mean of two scales
        "offset_x_m": offset,
        "offset_y_m": offset,
        "bearing_rad": np.hypot(first.theta_noise, place_px / np.maximum(T["distance_px"], 1e-6)),
        "turn_rad": np.hypot(first.theta_noise, second.theta_noise),
        "scale_ratio": T["scale_ratio"] * scale_noise,
    }


def at_one_scale(places: Mapping[Key, Any], areas: Mapping[Key, float]) -> dict[Key, Any]:
    """The places of one object's markers with the scale of the one that is largest in the image.

    Classes compare distances over it: a small marker's own scale is uncertain, and differs where it is eroded.
    """
    largest = max(places, key=lambda key: places[key].scale * np.sqrt(areas[key]))
    return {key: replace(place, scale=places[largest].scale) for key, place in places.items()}

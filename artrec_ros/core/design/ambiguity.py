"""What a camera will be able to tell of an object's markers, from their outlines alone, before anything is printed.

Scales are pixels per metre of a marker that is seen straight on: focal length (px) over distance (m).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from itertools import combinations
from typing import NamedTuple

import cv2
import numpy as np

from ..alignment.shapes import Shape
from ..alignment.symmetry import ANY_ANGLE
from ..base.config import DesignConfig, RecognizerConfig
from ..geometry.polygons import distance_to_outline
from ..model.marker import Marker
from ..model.objects import Component, ObjectModel
from ..model.solids import closed_components

_DESIGN, _CONFIG = DesignConfig(), RecognizerConfig()
_TURNS = 144  # that are looked at: 2.5 degrees apart


@dataclass(frozen=True)
class MarkerLimits:
    """From which scale (px/m) on a marker can be used.

    :param found: it is large enough to be found.
    :param turn: its direction is told from all its other turns; inf: never, by its design.
    :param order: order of the symmetry of its design: 1 none, `ANY_ANGLE` a disc.
    """

    component: str
    marker: str
    size_m: tuple[float, float]
    found: float
    turn: float
    order: int


@dataclass(frozen=True)
class Likeness:
    """Two markers of one class of pixels that differ little.

    :param told: scale (px/m) from which their outlines differ by more than a contour's noise; inf: they are the same.
    :param turn_rad: turn of the second at which it is most like the first.
    :param mirrored: each is the other's mirror image.
    """

    first: tuple[str, str]
    second: tuple[str, str]
    told: float
    turn_rad: float
    mirrored: bool = False

    @property
    def same(self) -> bool:
        return np.isinf(self.told)


@dataclass(frozen=True)
class Ambiguities:
    """What is known of an object's markers at any distance.

    :param alike: but for sides of solids, which are seen together.
    :param solids: components that their markers close in, as the sides of a box do.
    """

    model: ObjectModel
    limits: tuple[MarkerLimits, ...]
    alike: tuple[Likeness, ...]
    solids: frozenset[str] = frozenset()

    @cached_property
    def told(self) -> dict[tuple[str, str], float]:
        """(component, marker) -> scale from which it is found and is told from all that is not the same by design."""
        scales = {(m.component, m.marker): m.found for m in self.limits}
        for m in self.limits:
            if np.isfinite(m.turn):
                scales[m.component, m.marker] = max(scales[m.component, m.marker], m.turn)
        for pair in self.alike:
            for key in (pair.first, pair.second):
                if np.isfinite(pair.told):
                    scales[key] = max(scales[key], pair.told)
        return scales


def find_ambiguities(model: ObjectModel, shown: Callable[[Sequence[_Pair]], Iterable[_Pair]] = iter) -> Ambiguities:
    """Limits of every marker, and every pair of one class that can be taken for one another.

    :param shown: passes on the pairs to be compared, and may show how far they are: many shapes take seconds.
    """
    shapes: dict[tuple[bytes, float | None], Shape] = {}
    looks = []
    for c, m in [(component, marker) for component in model.components for marker in component.markers]:
        key = m.outline.tobytes(), m.disc_radius  # many markers are of one shape
        if key not in shapes:
            shapes[key] = Shape.from_marker(m)
        looks.append(_Look(c.label, shapes[key], _limits(c, m, shapes[key])))
    solids = closed_components(model)
    pairs = [
        (a, b)
        for a, b in combinations(looks, 2)
        if a.label == b.label
        and _like_in_size(a.shape, b.shape)
        and not {a.limits.component, b.limits.component} <= solids
    ]
    unlike = cache(unlikeness)
    alike = (_compare(a, b, unlike) for a, b in shown(pairs))
    limits, pairs_alike = tuple(look.limits for look in looks), tuple(pair for pair in alike if pair is not None)
    return Ambiguities(model, limits, pairs_alike, solids)


class _Look(NamedTuple):
    """What there is to a marker: its component's label, its shape, its limits."""

    label: int | None
    shape: Shape
    limits: MarkerLimits


_Pair = tuple[_Look, _Look]
_Unlike = Callable[[Shape, Shape], tuple[float, float]]


def _limits(component: Component, marker: Marker, shape: Shape) -> MarkerLimits:
    _, sides, _ = cv2.minAreaRect((shape.outline * 1e3).astype(np.float32))
    long, short = max(sides) / 1e3, min(sides) / 1e3
    least_px = _DESIGN.least_seed_px if component.required else _DESIGN.least_area_px
    found = max(_DESIGN.least_long_px / long, float(np.sqrt(least_px / shape.area_m2)))
    residual = shape.symmetry.residual_m
    order = order_of(shape)
    by_design = {n for n in range(2, len(residual)) if order and order % n == 0}
    others = [r for n, r in enumerate(residual) if n >= 2 and n not in by_design]
    least = 0.0 if order == ANY_ANGLE else min(others)
    turn = np.inf if order != 1 or least == 0 else _CONFIG.alignment.symmetry_px / least
    return MarkerLimits(component.name, marker.name, (long, short), found, float(turn), order)


def order_of(shape: Shape) -> int:
    """Order of the symmetry of a shape's design: 1 none, `ANY_ANGLE` a disc."""
    return shape.symmetry.order(1.0, _DESIGN.same_share * shape.rms_radius_m)


def _like_in_size(a: Shape, b: Shape) -> bool:
    small, large = sorted((a.rms_radius_m, b.rms_radius_m))
    return large <= _DESIGN.much_larger * small


def _compare(a: _Look, b: _Look, unlike: _Unlike) -> Likeness | None:
    """None where the two differ so much that they are told as soon as they are found. :param unlike: `unlikeness`."""
    distance, turn = unlike(a.shape, b.shape)
    same_m = _DESIGN.same_share * min(a.shape.rms_radius_m, b.shape.rms_radius_m)
    told = np.inf if distance < same_m else _DESIGN.sigmas * _CONFIG.constraints.contour_noise_px / distance
    if told <= max(a.limits.found, b.limits.found):
        return None
    mirrored = unlike(_mirror(a.shape), b.shape)[0] < same_m
    keys = [(look.limits.component, look.limits.marker) for look in (a, b)]
    return Likeness(keys[0], keys[1], float(told), turn, mirrored)


@lru_cache(maxsize=64)
def _mirror(a: Shape) -> Shape:
    return replace(a, points=-a.points.conj(), outline=a.outline * (-1, 1))


def unlikeness(a: Shape, b: Shape) -> tuple[float, float]:
    """How far two outlines differ where they are most alike: rms distance (m), and the turn of `b` there (rad).

    Their centroids coincide; `b` may be a little larger or smaller, as at a distance that is not known exactly.
    """
    size = float(np.clip(np.sqrt(a.area_m2 / b.area_m2), 1 / _DESIGN.like_size, _DESIGN.like_size)) ** 0.5
    turns = 2 * np.pi * np.arange(_TURNS) / _TURNS
    turn = np.exp(1j * turns)[:, None]
    there = _rms(turn * (size * b.points), a.outline / size)  # (turns,)
    back = _rms(a.points / size / turn, size * b.outline)
    distance = np.maximum(there, back)
    best = int(np.argmin(distance))
    return float(distance[best]), float(turns[best])


def _rms(points: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """(h,) rms distance of (h, m) complex points to a polygon."""
    flat = np.column_stack([points.real.ravel(), points.imag.ravel()])
    d = distance_to_outline(flat, outline).reshape(points.shape)
    return np.asarray(np.sqrt(np.mean(d**2, axis=1)))

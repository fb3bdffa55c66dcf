"""Distances that no joint of a flat object changes, and that marked images have vary all the same."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..model.objects import ObjectModel
from .fixed_distances import Key, fixed_distances
from .marked_views import Marks, markers_of

_LEAST_PX, _LEAST_SHARE = 5.0, 0.05  # clicks are a pixel or two off, and lenses and slants change what lies farther out
_LEAST_IMAGES = 4  # of a distance: in fewer nothing tells what it is mostly
# Of many clicks some are farther off: an image counts that is off by so many deviations of its distance, as a wrong
# mark is, or all do, where that deviation itself is more than clicks make, as of what slides
_DEVIATIONS, _NORMAL = 5.0, 1.4826  # the latter times the median deviation is a normal one's standard deviation


@dataclass(frozen=True)
class Varying:
    """What is marked of the distance between two markers.

    :param first, second: component and marker. :param least, most: times its median. :param off: in so many images it
        is another one, of `images` that show it. :param place: where the one stands that is farthest off.
    """

    first: Key
    second: Key
    least: float
    most: float
    off: int
    images: int
    place: str


def varying_distances(model: ObjectModel, marks: Sequence[Marks]) -> list[Varying]:
    """The farthest off first, of images straight from above.

    What an image's scale is nobody knows: it is taken to be that which has most lengths stay, the same in all images or
    in proportion to one of the lengths. Of few lengths in images of several scales it cannot be told which one varies.
    """
    pairs = list(fixed_distances(model))
    if not marks:
        return []
    px = np.array([*_pairs_px(model, pairs, marks), *_axes_px(model, marks)]).reshape(-1, len(marks))
    px[px == 0] = np.nan  # two clicks on one place
    of_pair = np.arange(len(px)) < len(pairs)
    known = np.isfinite(px).sum(axis=1) >= _LEAST_IMAGES
    px, of_pair = px[known], of_pair[known]
    if len(px) < 2:
        return []
    off, ratio = _off(px, _scale_of(px))
    off = _beyond_clicks(px, ratio, off)
    pairs = [pair for pair, enough in zip(pairs, known[: len(pairs)].tolist(), strict=True) if enough]
    found = []
    for row in np.flatnonzero(off[of_pair].any(axis=1)).tolist():
        least, most = float(np.nanmin(ratio[row])), float(np.nanmax(ratio[row]))
        seen, place = int(np.isfinite(ratio[row]).sum()), marks[int(np.nanargmax(np.abs(ratio[row] - 1)))].place
        found.append(Varying(*pairs[row], least, most, int(off[row].sum()), seen, place))
    return sorted(found, key=lambda v: v.least - v.most)


def _scale_of(px: Array) -> Array:
    """(n,) of each image, but for a factor, by lengths (k, n)."""
    usual = np.nanmedian(px, axis=1)
    best, most = px[int(np.argmax(usual))], 0.0
    for row, scale in enumerate((*px, np.ones(px.shape[1]))):
        off, ratio = _off(px, scale)
        stays = ~off.any(axis=1) & (np.isfinite(ratio).sum(axis=1) >= _LEAST_IMAGES) & (np.arange(len(px)) != row)
        if (total := float(usual[stays].sum())) > most:
            best, most = scale, total
    return best


def _off(px: Array, scale: Array) -> tuple[NDArray[np.bool_], Array]:
    """(k, n) which lengths are others than mostly, and times their medians, at these scales (n,)."""
    ratio = px / scale
    ratio = ratio / np.nanmedian(np.where(np.isfinite(ratio).any(axis=1, keepdims=True), ratio, 1.0), axis=1)[:, None]
    off_px = np.abs(px - px / ratio)
    return off_px > np.maximum(_LEAST_PX, _LEAST_SHARE * px / ratio), ratio


def _beyond_clicks(px: Array, ratio: Array, off: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(k, n) which of those lengths that are `off` are so for another reason than that many were clicked."""
    away = np.abs(px - px / ratio)
    usual = _NORMAL * np.nanmedian(away, axis=1, keepdims=True)
    slides = usual > np.maximum(_LEAST_PX, _LEAST_SHARE * np.nanmedian(px, axis=1, keepdims=True))
    return np.asarray(off & (slides | (away > _DEVIATIONS * usual)))


def _pairs_px(model: ObjectModel, pairs: Sequence[tuple[Key, Key]], marks: Sequence[Marks]) -> Iterator[list[float]]:
    """Of each pair in each image how far its markers' middles are apart; NaN: not both are marked."""
    number = {(model.components[c].name, marker.name): n for n, (c, marker, _) in enumerate(markers_of(model))}
    middles = [dict(zip(m.marker.tolist(), m.ends.mean(axis=1), strict=True)) for m in marks]
    for first, second in pairs:
        a, b = number[first], number[second]
        yield [float(np.linalg.norm(at[a] - at[b])) if a in at and b in at else np.nan for at in middles]


def _axes_px(model: ObjectModel, marks: Sequence[Marks]) -> Iterator[list[float]]:
    """Of each marker but discs, whose ends are marked anywhere, how long its axis is in each image."""
    ends = [np.linalg.norm(m.ends[:, 1] - m.ends[:, 0], axis=1).tolist() for m in marks]
    lengths = [dict(zip(m.marker.tolist(), own, strict=True)) for m, own in zip(marks, ends, strict=True)]
    for n, (_, marker, _) in enumerate(markers_of(model)):
        if marker.disc_radius is None:
            yield [float(own.get(n, np.nan)) for own in lengths]

"""Instances of every shape in a frame: propose, score, suppress, refine, accept (paper, steps 4 and 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..base.deadline import Deadline
from ..geometry.range_limits import ScaleLimits
from ..image.blobs import Blob
from .contour_map import ContourMap
from .overlap import overlap_matrix
from .placements import Array1, Evidence, Placements, evidence
from .refinement import refine, suppress
from .shapes import Shape
from .starts import find_starts

_GAP = 1.5  # spacings of an outline's points that a contour may be longer than between two of them


@dataclass(frozen=True)
class Matches:
    """Accepted placements of shapes in one frame, best first within a shape and class.

    :param labels: (K,) class label of each.
    :param evidence: per placement; `placed.score` is `evidence.score`.
    :param known_overlap: `overlap`, where that has been worked out already.
    """

    shapes: list[Shape]
    placed: Placements
    labels: np.ndarray
    evidence: Evidence
    cmap: ContourMap | None = None
    known_overlap: Array1 | None = None

    def __len__(self) -> int:
        return len(self.placed)

    @cached_property
    def overlap(self) -> Array1:
        """(K, K) share of the smaller one's area that two placements of one class have in common."""
        known = self.known_overlap
        return overlap_matrix(self.shapes, self.placed, self.labels) if known is None else known

    def related(self, deadline: Deadline) -> Matches:
        """The same with `overlap` worked out; where the deadline ends that, only the strongest, as far as it came."""
        order = np.argsort(-self.placed.score, kind="stable")
        overlap = overlap_matrix(self.shapes, self.placed.take(order), self.labels[order], deadline)
        kept = order[: len(overlap)]
        place = np.argsort(kept)
        return replace(self.take(kept[place]), known_overlap=overlap[np.ix_(place, place)])

    @cached_property
    def packed(self) -> Found:
        """As compiled code takes them."""
        p, e = self.placed, self.evidence
        return Found(p.t, p.z, p.w, p.shape, self.labels, e.share, p.score, e.visible * self.perimeter_px)

    @cached_property
    def perimeter_px(self) -> Array1:
        return np.array([s.perimeter_m for s in self.shapes])[self.placed.shape] * np.abs(self.placed.z)

    def explained(self, n: int) -> NDArray[np.int32]:
        """Contour points that an instance explains: those it matches, and those that lie between two such."""
        if self.cmap is None:
            raise ValueError("matches of several contour maps explain no points of one")
        between_px = float(self.perimeter_px[n]) / self.evidence.matched.shape[1]
        return self.cmap.stretches(self.evidence.matched[n], int(np.ceil(_GAP * between_px)) + 1)

    def take(self, index: np.ndarray) -> Matches:
        return Matches(self.shapes, self.placed.take(index), self.labels[index], self.evidence.take(index), self.cmap)

    @classmethod
    def none(cls, shapes: list[Shape]) -> Matches:
        return cls(shapes, Placements.concatenate([]), np.zeros(0, int), Evidence.none())


def concatenate_matches(shapes: list[Shape], parts: list[Matches]) -> Matches:
    """Matches of several blobs as one list."""
    if not parts:
        return Matches.none(shapes)
    found = Evidence.concatenate([p.evidence for p in parts])
    placed = Placements.concatenate([p.placed for p in parts])
    return Matches(shapes, placed, np.concatenate([p.labels for p in parts]), found)


def find_matches(
    blobs: tuple[Blob, ...],
    cmap: ContourMap,
    shapes: list[Shape],
    wanted: set[tuple[int, int]],
    config: RecognizerConfig,
    deadline: Deadline,
    blank: tuple[int, ...],
    scales: ScaleLimits,
) -> Matches:
    """Best of several hypotheses for every place, shape and class: the default profile.

    :param wanted: (shape, label) pairs. :param scales: to look for.
    """
    placed = find_starts(blobs, cmap, shapes, wanted, config, deadline.part(config.time.first_pass_share), scales)
    placed = refine(cmap, shapes, placed, config, deadline)
    if config.max_slant_deg > 0:
        slanted = refine(cmap, shapes, placed, config, deadline, slanted=True)
        flat_share, share = (evidence(cmap, shapes, p, config, blank).share for p in (placed, slanted))
        # Two more unknowns fit anything a little better: they have to earn it.
        better = share > flat_share + config.alignment.slant_gain
        placed = placed.replace(
            **{f: np.where(better, getattr(slanted, f), getattr(placed, f)) for f in ("t", "z", "w")}
        )
    return accept(cmap, shapes, placed, config, blank, scales)


def accept(
    cmap: ContourMap,
    shapes: list[Shape],
    placed: Placements,
    config: RecognizerConfig,
    blank: tuple[int, ...],
    scales: ScaleLimits,
) -> Matches:
    """Those that match well enough, the best of each place, at most `max_instances` a shape and class."""
    found, scale = evidence(cmap, shapes, placed, config, blank), placed.scale
    good = (
        (found.share >= config.min_match)
        & (found.visible >= config.alignment.min_visible)
        & (placed.area_px(shapes) >= config.min_blob_px)
        & (scale >= scales.least)
        & (scale <= scales.greatest)
    )
    passed = np.flatnonzero(good)
    placed = placed.replace(score=found.score).take(passed)
    everywhere = placed.slot.astype(np.int64) * len(shapes) + placed.shape
    quota = np.full(len(placed), config.alignment.max_instances)
    kept = suppress(placed, everywhere, shapes, quota, config, config.alignment.same_place)
    placed = placed.take(kept)
    label_of_slot = np.array(list(cmap.slots))
    return Matches(shapes, placed, label_of_slot[placed.slot], found.take(passed[kept]), cmap)


class Found(NamedTuple):
    """Instances: (K,) arrays of `Placements` and `Evidence`; :param in_view: of the placed outline, px."""

    t: np.ndarray
    z: np.ndarray
    w: np.ndarray
    shape: np.ndarray
    label: np.ndarray
    share: np.ndarray
    score: np.ndarray
    in_view: np.ndarray

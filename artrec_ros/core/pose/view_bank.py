"""Alignments of all views of one marker with a blob, and which of them the labels like best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base.config import BlobsConfig, GuessesConfig
from ..base.jit import LANES
from ..geometry.transforms import Array
from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..image.label_field import LabelField
from . import guess_kernels as guessing
from .surface_kernels import SurfaceLimits
from .views import MarkerView, blob_couples, flips_of, moments_of, scale_range


@dataclass(frozen=True)
class BlobShape:
    """What views are aligned with: a blob grown by the seam that the segmenter left around it.

    :param couples: (n, 2) first and second anchors.
    :param moments: centroid and principal direction.
    """

    area_px: float
    couples: tuple[Array, Array]
    moments: tuple[Array, float]


def _blob_shape(blob: Blob, seam_px: float, config: BlobsConfig) -> BlobShape:
    """A blob's contour moved out by a seam, and its anchors at each tolerance (method, step 2); made once for all that
    align their views with it."""
    key = BlobShape, seam_px, id(config)
    if key not in blob.notes:
        blob.notes[key] = config, _shape_of(blob, seam_px, config)  # while it is noted none else has its number
    shape: BlobShape = blob.notes[key][1]
    return shape


def _shape_of(blob: Blob, seam_px: float, config: BlobsConfig) -> BlobShape:
    contour = blob.contour + seam_px * blob.normals
    area = blob.area_px + seam_px * len(contour)
    return BlobShape(area, blob_couples(contour, config.tolerances_px(area)), moments_of(contour))


class ViewBank:
    """The V views of a marker, or of several that meet.

    :param inside_votes, ring_votes: (256,) for the labels on the marker and around it, as far as `limits` say.
    :ivar flips: (F, V, 3, 3) rotations that each view stands for, see `flips_of`.
    :ivar look: the votes, for compiled code.
    """

    def __init__(
        self,
        views: Sequence[MarkerView],
        inside_votes: Array,
        ring_votes: Array,
        limits: SurfaceLimits,
        config: GuessesConfig,
        flips: Array | None = None,
    ) -> None:
        """:param flips: None: those of a marker's views."""
        self._config, most = config, (inside_votes.max(), ring_votes.max())
        self.look = guessing.Look(inside_votes, ring_votes, *most, limits.ring_px, limits.ring_width_px)
        if flips is None:
            flips = flips_of(np.array([v.turn for v in views]), np.array([v.direction for v in views]))
        self.flips = flips
        n = np.array([len(v.anchors) for v in views])
        anchors = np.zeros((len(views), n.max(), 2))
        for row, view in zip(anchors, views, strict=True):
            row[: len(view.anchors)] = view.anchors
        stack = lambda name: np.array([getattr(v, name) for v in views])  # noqa: E731
        xy = lambda name: np.ascontiguousarray(stack(name).transpose(0, 2, 1))  # noqa: E731
        self._arrays = (anchors, n, xy("inside"), xy("contour"), xy("contour_normal"), stack("area"))
        self._perimeter = stack("perimeter")
        self._last: tuple[LabelField, Blob, tuple[int, int], tuple[Array, Array, np.ndarray]] | None = None
        self._moments = np.array([v.moments[0] for v in views]), np.array([v.moments[1] for v in views])

    @cached_property
    def arrays(self) -> guessing.BankArrays:
        """For compiled code, at any scale."""
        scale = np.tile([0.0, np.inf], (len(self._perimeter), 1))
        return guessing.BankArrays(*self._arrays, self._perimeter, scale, *self._moments)

    def align_blob(
        self, frame: ImageFrame, blob: Blob, most: int, config: BlobsConfig, piece: int
    ) -> tuple[Array, Array, np.ndarray]:
        """`align` of a blob; what was last asked for is known, for all components that have this marker."""
        last = self._last
        if last is None or last[0] is not frame.field or last[1] is not blob or last[2] != (most, piece):
            shape = _blob_shape(blob, frame.field.seam_px(blob.label), config)
            self._last = last = frame.field, blob, (most, piece), self.align(frame, shape, most, piece)
        return last[3]

    def align(self, frame: ImageFrame, shape: BlobShape, most: int, piece: int = 0) -> tuple[Array, Array, np.ndarray]:
        """The best similarities of all views, at most so many: (H, 4), their votes (H,), and each one's view (H,), best
        first. :param piece: see `scale_range`."""
        scale = scale_range(self._arrays[-1], shape.area_px, self._config, piece)
        bank = self.arrays._replace(scale=scale)
        (x, y), turn = shape.moments
        moments = guessing.Moments(x, y, turn, shape.area_px)
        n_views = len(self._perimeter)
        each = guessing.Kept(
            np.empty((n_views, most, 4)), np.empty((n_views, most)), np.empty(n_views, np.int64), np.empty(most)
        )
        T, votes, of = np.empty((most, 4)), np.empty(most), np.empty(most, np.int64)
        at, view = np.empty(max(bank.contour.shape[2], LANES), np.int32), frame.view
        least_share = float(self._config.least_share)
        n = guessing.best_alignments(
            *shape.couples, moments, bank, self.look, least_share, view, at, each, T, votes, of
        )
        return T[:n], votes[:n], of[:n]

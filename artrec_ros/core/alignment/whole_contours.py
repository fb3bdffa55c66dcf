"""Hypotheses that lay a shape's whole outline on a blob's whole contour: least squares of evenly spaced points.

Both run round once, so a point of one belongs to a point of the other as soon as one couple is known: of every such
couple the best similarity is a correlation (Procrustes), and all of them are one Fourier transform. What tells a
shape's turn may be as small as a notch in a disc, which no grid of turns and few couples of anchors would meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.blobs import Blob
from .sampling_kernels import sample_evenly
from .shapes import SAMPLES, Shape, pack_shapes

_CHORDS = 4 * SAMPLES  # along a contour, of which its length is measured


class WholeContours:
    """B blobs' contours, each made ready once for all shapes."""

    def __init__(self, blobs: Sequence[Blob]) -> None:
        first = np.cumsum([0, *(len(b.contour) for b in blobs)])
        points = np.concatenate([b.contour for b in blobs]).view(complex)[:, 0]
        sampled = np.empty((len(blobs), SAMPLES), complex)
        sample_evenly(points, first, _CHORDS, sampled)
        self._middle = sampled.mean(axis=1)
        self._spectrum = np.fft.fft(sampled - self._middle[:, None], axis=1)

    def laid(
        self, shapes: Sequence[Shape], blob: NDArray[np.int64], shape: NDArray[np.int64], ways: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """(t, z), each (n, ways): the best similarities of n couples of a blob and a shape, all of them local optima,
        the best first; others are as good as none, of no size.

        :param blob, shape: (n,) which ones.
        """
        middle, spectrum, extent = _outlines(tuple(shapes))
        found = np.fft.ifft(self._spectrum[blob] * spectrum[shape], axis=1)
        size = np.abs(found)
        before, after = np.roll(size, 1, axis=1), np.roll(size, -1, axis=1)
        peaks = np.where((size >= before) & (size > after), size, 0.0)
        best = np.argsort(-peaks, axis=1, kind="stable")[:, :ways]
        each = np.arange(len(blob))[:, None]
        low, high, at = before[each, best], after[each, best], size[each, best]
        # the couple that fits best lies between two points: a parabola through three
        off = 0.5 * (low - high) / np.minimum(low - 2 * at + high, -1e-12)
        z = found[each, best] * (1 - off**2)
        z += 0.5 * off * (off - 1) * found[each, best - 1] + 0.5 * off * (off + 1) * found[each, (best + 1) % SAMPLES]
        z *= (peaks[each, best] > 0) / extent[shape, None]
        return self._middle[blob, None] - z * middle[shape, None], z


@lru_cache(maxsize=8)
def _outlines(shapes: tuple[Shape, ...]) -> tuple[np.ndarray, np.ndarray, Array]:
    """(S,) middles of shapes' points, (S, SAMPLES) conjugate spectra about these, (S,) sums of squared distances."""
    points = pack_shapes(shapes).points
    middle = points.mean(axis=1)
    about = points - middle[:, None]
    return middle, np.conj(np.fft.fft(about, axis=1)), np.sum(np.abs(about) ** 2, axis=1)

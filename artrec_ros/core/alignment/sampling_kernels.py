"""Contours as evenly spaced points."""

from __future__ import annotations

from typing import Any

from ..base.jit import lean


@lean
def sample_evenly(points: Any, first: Any, chords: int, out: Any) -> None:
    """Fill out (B, m) with points evenly spaced along closed contours, the first one half a space from where it starts.

    A chain of pixels is longer along a diagonal than along a row: lengths are those of about so many chords.

    :param points: (P,) complex. :param first: (B + 1,) where each contour starts.
    """
    m = out.shape[1]
    for b in range(len(first) - 1):
        start, n = first[b], first[b + 1] - first[b]
        step = max(n // chords, 1)
        count = -(-n // step)
        whole = 0.0
        for i in range(count):
            whole += abs(points[start + ((i + 1) * step if i + 1 < count else 0)] - points[start + i * step])
        side, k = whole / m, 0
        begun = 0.0
        for i in range(count):
            here, after = points[start + i * step], points[start + ((i + 1) * step if i + 1 < count else 0)]
            length = abs(after - here)
            while k < m and (k + 0.5) * side <= begun + length:
                out[b, k] = here + (after - here) * (((k + 0.5) * side - begun) / max(length, 1e-12))
                k += 1
            begun += length
        while k < m:  # rounding may leave the last one
            out[b, k] = points[start]
            k += 1

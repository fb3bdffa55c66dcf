"""How much of placed outlines lies in one another."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted


class Rasters(NamedTuple):
    """Shapes drawn, to ask whether points lie inside. Points that fill shape s: inside[first[s]:first[s + 1]].

    :param mask: (S, n, n). :param low: (S, 2) and cell: (S,) as in `overlap`. :param reach: (S,) metres.
    """

    mask: np.ndarray
    low: np.ndarray
    cell: np.ndarray
    reach: np.ndarray
    inside: np.ndarray
    first: np.ndarray


@melted
def _share_inside(rasters: Any, s: int, s_in: int, t: complex, z: complex, w: complex, z_in: complex,
                  w_in: complex) -> float:  # fmt: skip
    """Share of shape s, placed by (t, z, w), that lies in shape s_in, placed by (0, z_in, w_in)."""
    determinant = abs(z_in) ** 2 - abs(w_in) ** 2
    cells, unit = rasters.mask.shape[1], 1 / rasters.cell[s_in]
    # the points p of s_in's frame with z_in p + w_in conj(p) = t + z q + w conj(q)
    c = (np.conj(z_in) * t - w_in * np.conj(t)) / determinant
    a = (np.conj(z_in) * z - w_in * np.conj(w)) / determinant
    b = (np.conj(z_in) * w - w_in * np.conj(z)) / determinant
    hits = 0
    for i in range(rasters.first[s], rasters.first[s + 1]):
        q = rasters.inside[i]
        p = c + a * q + b * np.conj(q)
        x = int(min(max((p.real - rasters.low[s_in, 0]) * unit + 2.5, 0.0), cells - 1.0))
        y = int(min(max((p.imag - rasters.low[s_in, 1]) * unit + 2.5, 0.0), cells - 1.0))
        hits += rasters.mask[s_in, y, x]
    return hits / (rasters.first[s + 1] - rasters.first[s])


@jit
def overlaps(rasters: Any, t: Any, z: Any, w: Any, shape: Any, labels: Any, out: Any, first: int, last: int) -> None:
    """(K, K) as `overlap_matrix`: of `out`, of zeros at the start, rows `first` to `last` and what mirrors them."""
    for i in range(first, last):
        reach_i = rasters.reach[shape[i]] * (abs(z[i]) + abs(w[i]))
        for j in range(i + 1):
            reach = reach_i + rasters.reach[shape[j]] * (abs(z[j]) + abs(w[j]))
            off = t[i] - t[j]
            if labels[i] != labels[j] or off.real * off.real + off.imag * off.imag >= reach * reach:
                continue
            one = _share_inside(rasters, shape[i], shape[j], off, z[i], w[i], z[j], w[j])
            other = _share_inside(rasters, shape[j], shape[i], -off, z[j], w[j], z[i], w[i])
            out[i, j] = out[j, i] = max(one, other)

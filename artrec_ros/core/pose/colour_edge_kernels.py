"""Where colours change along the normals of contours, point by point."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted

SAMPLES = 15  # along a normal: where they are half a pixel apart for the widest reach
_ENDS = 2  # of them on either side tell what a step begins and ends with
_ASIDE = 0.25  # of a step: colours that are no blend of its ends pass a third one, such as a dark rim
_CLEAN = 1.5  # ways that colours go between the ends at most: one who goes to and fro passes more than one edge
_MOST_DONE = -0.2, 1.2  # of a step: what is noise beyond
_FARTHEST = 0.5  # of the half of a normal that is looked at: farther out the step is not seen whole


class ColourEdges(NamedTuple):
    """What edges of colours are looked for in.

    :ivar image: (h, w, 3) uint8. :ivar gamma: see `ImageFrame`. :ivar contrast: least difference between a step's ends,
        0 to 1. :ivar doubt: weight of labels' edges where colours tell none.
    """

    image: Any
    gamma: float
    contrast: float
    doubt: float


@melted
def sample(image: Any, x: float, y: float, out: Any) -> None:
    """Fill out (3,) with the colour between pixels, 0 to 1; beyond the border it goes on as there."""
    h, w = image.shape[0], image.shape[1]
    x, y = min(max(x, 0.0), w - 1.0), min(max(y, 0.0), h - 1.0)
    left, top = int(x), int(y)
    right, below, along, down = min(left + 1, w - 1), min(top + 1, h - 1), x - left, y - top
    for c in range(3):
        above = image[top, left, c] * (1 - along) + image[top, right, c] * along
        under = image[below, left, c] * (1 - along) + image[below, right, c] * along
        out[c] = (above * (1 - down) + under * down) / 255.0


@melted
def step_of(colours: Any, begin: Any, step: Any) -> float:
    """Fill begin (3,) and step (3,) with where colours (S, 3) begin and how far they go, and say how far that is."""
    size = 0.0
    for c in range(3):
        first, last = 0.0, 0.0
        for k in range(_ENDS):
            first += colours[k, c] / _ENDS
            last += colours[SAMPLES - 1 - k, c] / _ENDS
        begin[c], step[c] = first, last - first
        size += step[c] ** 2
    return size


@melted
def edge_along(light: Any, begin: Any, step: Any) -> float:
    """How much of a normal, -1 to 1, the middle of a step of light (S, 3) is beyond its middle; NaN where it is not one
    step between two colours."""
    size = max(step_of(light, begin, step), 1e-9)
    ways, before, aside, total = 0.0, 0.0, 0.0, 0.0
    for k in range(SAMPLES):
        done, off = 0.0, 0.0
        for c in range(3):
            done += (light[k, c] - begin[c]) * step[c] / size
        for c in range(3):
            off += (light[k, c] - begin[c] - done * step[c]) ** 2
        aside = max(aside, off)
        ways += abs(done - before) if k else 0.0
        before = done
        share = (0.5 if k in (0, SAMPLES - 1) else 1.0) / (SAMPLES - 1)  # of what lies between them (trapezoids)
        total += share * min(max(done, _MOST_DONE[0]), _MOST_DONE[1])
    if ways < _CLEAN and aside < _ASIDE**2 * size:
        return 1 - 2 * total  # as much before it as behind
    return math.nan


@jit
def look_for_colours(edges: ColourEdges, point: Any, normal: Any, half_px: Any, residual: Any, weight: Any) -> None:
    """Move residuals (H, M, m) from labels' edges to those of colours where these tell, and lessen the weights of the
    others, in place.

    :param point, normal: (H, M, m, 2) pixels. :param half_px: (H, M) how far a look goes to either side.
    """
    colours, begin, step = np.empty((SAMPLES, 3)), np.empty(3), np.empty(3)
    for h in range(residual.shape[0]):
        for m in range(residual.shape[1]):
            half = half_px[h, m]
            for i in range(residual.shape[2]):
                if not weight[h, m, i] > 0:
                    continue
                nx, ny = normal[h, m, i, 0], normal[h, m, i, 1]
                x, y = point[h, m, i, 0] - residual[h, m, i] * nx, point[h, m, i, 1] - residual[h, m, i] * ny
                if not abs(x) + abs(y) + half < 1e9:  # a pose that is no number looks at nothing
                    weight[h, m, i] = 0.0
                    continue
                for k in range(SAMPLES):
                    off = half * (2.0 * k / (SAMPLES - 1) - 1)
                    sample(edges.image, x + off * nx, y + off * ny, colours[k])
                beyond = math.nan
                if step_of(colours, begin, step) > edges.contrast**2:
                    if edges.gamma != 1.0:  # lenses blend light
                        for k in range(SAMPLES):
                            for c in range(3):
                                colours[k, c] = colours[k, c] ** edges.gamma
                    beyond = half * edge_along(colours, begin, step)
                if abs(beyond) < _FARTHEST * half:
                    residual[h, m, i] -= beyond
                else:
                    weight[h, m, i] *= edges.doubt

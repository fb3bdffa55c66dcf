"""What evidence comes to as a probability, by additive logistic models."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..base.jit import lean


class Curves(NamedTuple):
    """Some additive logistic models: of each the bias, and of each evidence a line through points."""

    bias: Any  # (models,)
    count: Any  # (models, columns) points, 0: it says nothing
    x: Any  # (models, columns, points)
    y: Any


@lean
def probabilities(curves: Curves, which: Any, evidence: Any, out: Any) -> None:
    """Fill out (H,) with what each of H rows of evidence (H, columns) comes to under the model `which` (H,)."""
    for h in range(len(out)):
        m = which[h]
        logit = curves.bias[m]
        for k in range(evidence.shape[1]):
            n, value = curves.count[m, k], evidence[h, k]
            if n == 0:
                continue
            x, y = curves.x[m, k], curves.y[m, k]
            i = 0
            while i < n and x[i] <= value:
                i += 1
            if i == 0 or i == n:
                logit += y[max(i - 1, 0)]
            else:
                logit += y[i - 1] + (y[i] - y[i - 1]) * (value - x[i - 1]) / (x[i] - x[i - 1])
        out[h] = 1 / (1 + math.exp(min(-logit, 700.0)))

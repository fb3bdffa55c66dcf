"""Additive logistic models with monotone curves, and how well probabilities are calibrated."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit

from artrec_ros.core.geometry.transforms import Array

KNOTS, PULLS = (4, 6, 8), (0.3, 1.0, 3.0)  # what is tried: points of a curve; weight of its squared rises
FOLDS = 5
ENDS = (0.02, 0.98)  # quantiles between which a curve rises
BINS = (0.0, 0.05, 0.1, 0.25, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)


@dataclass(frozen=True)
class Curves:
    """The model: `bias`, and for each column of the evidence the x and y of its curve's points."""

    bias: float
    points: tuple[tuple[Array, Array], ...]

    def probability(self, rows: Array, logit: Array | float = 0.0) -> Array:
        """(n,) of rows (n, columns). :param logit: (n,) to which curves add."""
        added = sum(np.interp(x, *points) for x, points in zip(rows.T, self.points, strict=True))
        return np.asarray(expit(logit + self.bias + added))


def fit(rows: Array, right: Array, knots: int, pull: float, logit: Array | float = 0.0) -> Curves:
    """Logistic regression on curves that never fall: what is fitted is by how much each piece of one rises. Pieces
    end at quantiles, each rise is measured over its piece, and so one pull to none suits all evidence.

    :param logit: (n,) to which they add.
    """
    places = [_places(x, knots) for x in rows.T]
    parts = [np.clip((x[:, None] - at[:-1]) / np.diff(at), 0, 1) for x, at in zip(rows.T, places, strict=True)]
    X = np.column_stack([np.ones(len(rows)), *parts])
    pulls = np.r_[0.0, np.full(X.shape[1] - 1, pull)]

    def cost(w: Array) -> tuple[float, Array]:
        z = logit + X @ w
        loss = np.logaddexp(0, z) - right * z
        return float(loss.sum() + pulls @ w**2 / 2), X.T @ (expit(z) - right) + pulls * w

    start = np.r_[0.0, np.full(X.shape[1] - 1, 0.1)]
    w = minimize(cost, start, jac=True, method="L-BFGS-B", bounds=[(None, None)] + [(0, None)] * (len(start) - 1)).x
    rises = np.split(w[1:], np.cumsum([p.shape[1] for p in parts])[:-1])
    return Curves(float(w[0]), tuple((at, np.r_[0.0, np.cumsum(rise)]) for at, rise in zip(places, rises, strict=True)))


def _places(x: Array, knots: int) -> Array:
    """Where a curve's pieces end: quantiles, of numbers of a few values these."""
    values = np.unique(x)
    places = values if len(values) <= knots else np.unique(np.quantile(x, np.linspace(*ENDS, knots)))
    return places if len(places) > 1 else places[0] + np.array([0.0, 1.0])


def best_of_several(
    rows: Array, right: Array, worlds: NDArray[np.int_], logit: Array | float = 0.0
) -> tuple[Curves, str]:
    """The number of points and the pull that do best on worlds left out, fitted on all; and which these are.

    :param logit: (n,) to which curves add.
    """
    part, logit = np.unique(worlds, return_inverse=True)[1] % FOLDS, logit + np.zeros(len(rows))

    def left_out(knots: int, pull: float) -> float:
        p = np.empty(len(rows))
        for k in range(FOLDS):
            curves = fit(rows[part != k], right[part != k], knots, pull, logit[part != k])
            p[part == k] = curves.probability(rows[part == k], logit[part == k])
        return log_loss(p, right)

    best = min(product(KNOTS, PULLS), key=lambda choice: left_out(*choice))
    return fit(rows, right, *best, logit), f"{best[0]} points a curve at most, pull {best[1]:g}"


def log_loss(p: Array, right: Array) -> float:
    """Mean, natural logarithm."""
    p = np.clip(p, 1e-9, 1 - 1e-9)
    return float(-np.mean(right * np.log(p) + (1 - right) * np.log(1 - p)))


def reliability(p: Array, right: Array) -> list[tuple[float, float, int, float, float]]:
    """Per bin of probabilities: its ends, how many, their mean, the share that is right."""
    bins = [(low, high, (p >= low) & ((p < high) | (high == 1.0))) for low, high in pairwise(BINS)]
    return [(a, b, int(m.sum()), float(p[m].mean()), float(right[m].mean())) for a, b, m in bins if m.any()]


def expected_error(p: Array, right: Array) -> float:
    """Mean distance of a bin's probability from the share that is right, by how many are in it."""
    return sum(n * abs(mean - share) for _, _, n, mean, share in reliability(p, right)) / len(p)


def tell(name: str, p: Array, right: Array) -> None:
    """Print how well probabilities (n,) are calibrated."""
    print(f"{name}: {len(p)}, log loss {log_loss(p, right):.3f}, expected error {expected_error(p, right):.3f}")
    for low, high, n, mean, share in reliability(p, right):
        print(f"  {low:4.2f} to {high:4.2f}: {n:5d}, told {mean:.3f}, right {share:.3f}")


def threshold(p: Array, right: Array, most_wrong: float) -> float:
    """The least probability, in steps of 0.005, above which no more than that share is wrong."""
    steps = np.arange(0.5, 1.0, 0.005)
    good = [t for t in steps if (p > t).any() and np.mean(1 - right[p > t]) <= most_wrong]
    return float(good[0]) if good else 1.0

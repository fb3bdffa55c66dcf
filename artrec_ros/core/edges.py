"""Edges of classes: where the labels along a contour's normals tell that a class ends."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from .compiled import edges as compiled
from .compiled.edges import EdgeTerms
from .evidence import OUTSIDE, OWNED, UNKNOWN, LabelField
from .spatial import SpatialModel
from .transforms import Array

EDGE_VOTE = 1.0  # natural-log units a known label says for one side of an edge
EDGE_VOTE_SEAM = -0.1  # nearly silent: the edge lies in a seam's middle, a tenth of a pixel to the marker's side
_FACTORS = math.exp(2 * EDGE_VOTE), math.exp(2 * EDGE_VOTE_SEAM), math.exp(-2 * EDGE_VOTE)


def edge_terms(model: SpatialModel, field: LabelField, reach_px: tuple[int, ...]) -> EdgeTerms:
    """What compiled code needs to find edges, in each of the steps of a fit."""
    seams = np.array([field.seam_px(label) for label in model.marker_labels])
    kinds = _kinds(model.marker_labels)
    return EdgeTerms(np.array(reach_px), *_FACTORS, _priors(reach_px), seams, kinds, OUTSIDE)


@cache
def _kinds(marker_labels: tuple[int, ...]) -> NDArray[np.int32]:
    """(M, 256) what each label is along the normals of each marker."""
    kinds = np.full((len(marker_labels), 256), compiled.KNOWN, np.int32)
    kinds[:, [UNKNOWN, OUTSIDE, OWNED]] = compiled.SILENT
    kinds[np.arange(len(marker_labels)), marker_labels] = compiled.OWN
    return kinds


@cache
def _priors(reach_px: tuple[int, ...]) -> Array:
    """Prior (steps, n) of each place of an edge, in each of the steps of a fit."""
    prior = np.zeros((len(reach_px), 2 * max(reach_px) + 2))
    for row, reach in zip(prior, reach_px, strict=True):
        row[: 2 * reach + 2] = np.exp(_log_prior(reach))
    return prior


def _places(reach: int) -> Array:
    """Where a boundary may cross a normal: between the pixels looked at, and before and behind them all."""
    return np.arange(-reach, reach + 2, dtype=np.float64) - 0.5


def _log_prior(reach: int) -> Array:
    return np.asarray(-0.5 * (_places(reach) / (0.6 * reach)) ** 2, np.float64)


def find_edges(field: LabelField, pixels: Array, normal: Array, labels: np.ndarray, reach: int) -> tuple[Array, Array]:
    """Where the boundary of a class crosses a contour's normals.

    Along each normal the labels up to `reach` pixels in and out are explained by every place of the boundary;
    the edge is the mean of these places under their likelihood, so it comes to lie in the middle of a seam of
    unknown pixels between two classes. Where only unknown pixels follow, half the usual seam is added.

    :param pixels, normal: (H, M, m, 2) contour points and outward unit normals; `labels` (M,) their classes.
    :return: signed distance of the edge along the normal, and its weight (inverse variance; 0: no edge), (H, M, m).
    """
    steps = np.arange(-reach, reach + 1)
    seen = field.at(pixels[..., None, :] + steps[:, None] * normal[..., None, :])  # (H, M, m, 2D+1)
    marker = seen == labels[:, None, None]
    unknown = (seen == UNKNOWN) | (seen == OUTSIDE) | (seen == OWNED)
    # Unknown pixels between two known classes are a seam; where nothing known follows they are what lies outside.
    seam = unknown & (np.cumsum((~unknown & ~marker)[..., ::-1], axis=-1)[..., ::-1] > 0)
    v = np.where(marker, EDGE_VOTE, np.where(seam, EDGE_VOTE_SEAM, -EDGE_VOTE))
    # sum of inside votes before the boundary minus those behind it (outside votes are their opposite)
    c = np.cumsum(v, axis=-1)
    likelihood = np.concatenate([np.zeros_like(c[..., :1]), 2 * c], axis=-1) - c[..., -1:]  # (..., 2D+2)
    places = _places(reach)
    likelihood = likelihood + _log_prior(reach)
    p = np.exp(likelihood - likelihood.max(axis=-1, keepdims=True))
    p /= p.sum(axis=-1, keepdims=True)
    mean = p @ places
    ends_unknown = unknown[..., reach + 1 :].any(axis=-1) & ~seam.any(axis=-1)
    seams = np.array([field.seam_px(int(label)) for label in labels])
    mean = mean + ends_unknown * seams[:, None]
    variance = p @ places**2 - (p @ places) ** 2
    ends = p[..., 0] + p[..., -1]
    inner, outer = marker[..., :reach].any(axis=-1), ~marker[..., reach:].all(axis=-1)
    at_border = (
        field.at(pixels + (mean + 1.2)[..., None] * normal) == OUTSIDE
    )  # not the marker ends there but the image
    ok = (ends < 0.3) & inner & outer & ~at_border
    return mean, np.where(ok, 1.0 / (1.0 + variance), 0.0)

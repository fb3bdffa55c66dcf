"""Edges of classes: where the labels along a contour's normals tell that a class ends."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.label_field import OUTSIDE, OWNED, UNKNOWN, LabelField
from . import edge_kernels as compiled
from .edge_kernels import EdgeTerms
from .surface_model import SpatialModel

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
        # a boundary may cross a normal between the pixels looked at, and before and behind them all
        places = np.arange(-reach, reach + 2) - 0.5
        row[: 2 * reach + 2] = np.exp(-0.5 * (places / (0.6 * reach)) ** 2)
    return prior

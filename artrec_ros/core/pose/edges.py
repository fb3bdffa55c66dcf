"""Edges of classes: where the labels along a contour's normals tell that a class ends."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..base.config import FitConfig
from ..geometry.transforms import Array
from ..image.codes import EMPTY, OUTSIDE, OWNED, UNKNOWN
from ..image.label_field import LabelField
from . import edge_kernels as compiled
from .edge_kernels import EdgeTerms
from .surface_model import SpatialModel


def edge_terms(model: SpatialModel, field: LabelField, reach_px: tuple[int, ...], config: FitConfig) -> EdgeTerms:
    """What compiled code needs to find edges, in each of the steps of a fit. What was last asked for of each reach is
    known: many fits follow each other in one image."""
    known = model.edges_known.get(reach_px)
    if known is None or known[0] is not field or known[1] is not config:
        model.edges_known[reach_px] = known = field, config, _edge_terms(model, field, reach_px, config)
    return known[2]


def _edge_terms(model: SpatialModel, field: LabelField, reach_px: tuple[int, ...], config: FitConfig) -> EdgeTerms:
    seams = model.seams_px(field)
    kinds = _kinds(model.marker_labels, model.codes.label.tobytes())
    priors = _priors(reach_px, config.edge_prior_width)
    inside, seam, outside = (math.exp(2 * vote) for vote in (config.edge_vote, config.seam_vote, -config.edge_vote))
    limits = float(config.edge_beyond), float(config.border_px)
    of_markers = seams, model.is_on_unknown, kinds
    no_end = OWNED if field.hides else OUTSIDE
    return EdgeTerms(np.array(reach_px), inside, seam, outside, priors, *of_markers, no_end, *limits)


def would_show(field: LabelField, point: Array, normal: Array, reach: int, border_px: float) -> NDArray[np.bool_]:
    """(...) whether labels would show that a class ends at points (..., 2) of a contour, or within reach of them: they
    tell something there, if only that nothing is, and neither the image ends nor does another object begin.

    Unknown pixels beside known ones, as of a seam, or of which nothing is to be known tell nothing.

    :param normal: (..., 2) outwards. :param border_px: edges so near to where the image ends are none.
    """
    away = np.arange(-reach, reach + math.ceil(border_px) + 1.0)
    codes = field.at(point[..., None, :] + away[:, None] * normal[..., None, :])
    told = (field.meaning.label[codes] != UNKNOWN)[..., : 2 * reach + 1].any(axis=-1)
    return np.asarray(told & ((codes != OUTSIDE) & (codes != OWNED)).all(axis=-1))


@cache
def _kinds(marker_labels: tuple[tuple[int, ...], ...], label_of: bytes) -> NDArray[np.int32]:
    """(M, 256) what each code is along the normals of each marker. :param label_of: codes' labels."""
    kinds = np.full((len(marker_labels), 256), compiled.KNOWN, np.int32)
    kinds[:, [UNKNOWN, EMPTY, OUTSIDE, OWNED]] = compiled.SILENT
    for row, labels in zip(kinds, marker_labels, strict=True):
        row[list(labels)] = compiled.OWN
    # one order in memory, whatever numpy's indexing gives: another one is compiled for anew
    return np.ascontiguousarray(kinds[:, np.frombuffer(label_of, np.uint8)])


@cache
def _priors(reach_px: tuple[int, ...], width: float) -> Array:
    """Prior (steps, n) of each place of an edge, in each of the steps of a fit.

    :param width: deviation, as a share of the reach.
    """
    prior = np.zeros((len(reach_px), 2 * max(reach_px) + 2))
    for row, reach in zip(prior, reach_px, strict=True):
        # a boundary may cross a normal between the pixels looked at, and before and behind them all
        places = np.arange(-reach, reach + 2) - 0.5
        row[: 2 * reach + 2] = np.exp(-0.5 * (places / (width * reach)) ** 2)
    return prior

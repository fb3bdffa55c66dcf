"""Which detection of a frame continues which object, all of them settled together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..base.config import TrackingConfig
from ..geometry.transforms import Array
from ..model.found import Detection
from .names import same_name
from .sightings import Sightings, agreement
from .tracks import Tracks


def matched(
    tracks: Tracks, found: Sequence[Detection], sightings: Sightings, area_px: float, config: TrackingConfig
) -> tuple[dict[int, int], Array]:
    """Row of the track that each detection continues, and (T,) the odds of those that are; 0 for others.

    :param area_px: of the image.
    """
    odds_of = np.zeros(len(tracks))
    if not len(tracks) or not found:
        return {}, odds_of
    possible = np.array([d.object for d in found])[:, None] == np.array(tracks.names)
    odds = agreement(sightings, tracks, possible, area_px, config)
    odds *= same_name([d.identity for d in found], tracks.identities, config.sightings.misnamed)
    row_of = assign(-2 * np.log(np.maximum(odds * tracks.existence.probability, 1e-300)))
    odds_of[list(row_of.values())] = [odds[n, row] for n, row in row_of.items()]
    return row_of, odds_of


def assign(cost: Array) -> dict[int, int]:
    """Row -> column, each once, so that the pairs' sum is least; pairs that are not below 0 stay apart."""
    rows, columns = linear_sum_assignment(np.minimum(cost, 0.0))
    return {int(r): int(c) for r, c in zip(rows, columns, strict=True) if cost[r, c] < 0}

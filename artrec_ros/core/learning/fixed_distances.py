"""Distances between markers that no joint changes: one image of a flat object tells its scale by them."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from ..model.kinematics import Kinematics
from ..model.objects import ObjectModel
from .marked_views import markers_of

Key = tuple[str, str]
Distances = dict[tuple[Key, Key], float]

_SAMPLES = 8  # values of all joints: a distance that is one in all of these no joint changes
_SAME = 1e-3  # of a distance: what joints change by less is fixed; it rounds what files are written with


def fixed_distances(model: ObjectModel) -> Distances:
    """Metres between the middles of two markers, by their components' and their own names; none of objects that are
    not flat, which images show slanted."""
    if not model.is_flat:
        return {}
    kin, known = Kinematics(model), markers_of(model)
    drawn = np.random.default_rng(0).uniform(size=(_SAMPLES, kin.n_joints))
    frames = kin.in_object(kin.lower + drawn * (kin.upper - kin.lower))
    middles = {
        (model.components[c].name, marker.name): frames.R[:, c] @ marker.centre + frames.t[:, c]
        for c, marker, _ in known
    }
    out = {}
    for (a, p), (b, q) in combinations(middles.items(), 2):
        apart = np.linalg.norm(p - q, axis=1)
        if np.ptp(apart) < _SAME * apart.mean():
            out[a, b] = float(apart.mean())
    return out

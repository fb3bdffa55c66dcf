"""Identities that are one: turned, what the one shows is what the other does."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from ...core.base.config import VotesConfig
from ...core.model.identities import identities_of
from ...core.model.objects import ObjectModel
from ...core.pose.exchanges import Exchanges
from ...core.pose.poses import Poses
from ...core.pose.surface_model import SpatialModel

_SAME = 0.1  # of markers' size: outlines are polygons, so that their middles are off a little, and few images tell less
_ANY = 1  # label: turns are the same, whatever the class


def turned_identities(model: ObjectModel) -> Iterator[str]:
    """A line for each two declared identities of a flat object of which one, turned, shows what the other one does:
    each is told as either of them."""
    if not model.identities or not model.is_flat or not model.is_spatial:
        return
    identities, told = {i.name: dict(i.classes) for i in identities_of(model)}, set[frozenset[str]]()
    least_m = _SAME * min(math.sqrt(marker.area) for marker in model.markers.values())
    for degrees, goes_to, off_m in _exchanged(model):
        for name, classes in identities.items():
            turned = {goes_to[c]: label for c, label in classes.items()}
            for other, theirs in identities.items():
                if other != name and turned == theirs and frozenset((name, other)) not in told:
                    told.add(frozenset((name, other)))
                    yield _as_told(name, other, degrees, off_m if off_m > least_m else 0.0)


def _as_told(name: str, other: str, degrees: float, off_m: float) -> str:
    if off_m == 0:
        turned = f"identity '{other}' is '{name}' turned by {degrees:.0f} degrees"
        return f"{turned}: nothing tells which of the two it is; list one of them"
    return (
        f"identity '{other}' is '{name}' turned by {degrees:.0f} degrees, but for places that differ by "
        f"{1e3 * off_m:.0f} mm at most: these alone tell which of the two it is, where images show as much"
    )


def _exchanged(model: ObjectModel) -> Iterator[tuple[float, Mapping[str, str], float]]:
    """By how many degrees an object may be turned for each of its markers to lie on a like one, on which component each
    then lies, and how far apart the two are at most, metres."""
    surface = SpatialModel(model, _ANY, VotesConfig())
    turns, markers = Exchanges(surface), surface.markers
    names = [model.components[c].name for c in surface.component[markers]]
    kin = surface.kinematics
    frames = kin.in_object(kin.middle[None])
    at = surface.place(frames, surface.centre[markers], surface.component[markers])[0]
    untouched = Poses(np.eye(3)[None], np.zeros((1, 3)), np.zeros((1, surface.kinematics.n_joints)))
    laid = turns.of(untouched)
    for n, angle in enumerate(turns.angle_rad.tolist()):
        there = at @ laid.R[n].T + laid.t[n]
        off = np.linalg.norm(there[:, None] - at, axis=2)
        on = {names[m]: names[k] for m, k in enumerate(off.argmin(axis=1).tolist())}
        yield math.degrees(angle) % 360, on, float(off.min(axis=1).max())

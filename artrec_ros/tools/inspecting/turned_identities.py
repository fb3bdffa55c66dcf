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

_ANY = 1  # label: turns are the same, whatever the class


def turned_identities(model: ObjectModel) -> Iterator[str]:
    """A line for each two declared identities of a flat object of which one, turned, shows what the other one does:
    each is told as either of them."""
    if not model.identities or not model.is_flat or not model.is_spatial:
        return
    identities, told = {i.name: dict(i.classes) for i in identities_of(model)}, set[frozenset[str]]()
    for degrees, goes_to in _exchanged(model):
        for name, classes in identities.items():
            turned = {goes_to[c]: label for c, label in classes.items()}
            for other, theirs in identities.items():
                if other != name and turned == theirs and frozenset((name, other)) not in told:
                    told.add(frozenset((name, other)))
                    yield (
                        f"identity '{other}' is '{name}' turned by {degrees:.0f} degrees: nothing tells which of the "
                        "two it is; list one of them"
                    )


def _exchanged(model: ObjectModel) -> Iterator[tuple[float, Mapping[str, str]]]:
    """By how many degrees an object may be turned for each of its markers to lie on a like one, and on which component
    each then lies."""
    surface = SpatialModel(model, _ANY, VotesConfig())
    turns, markers = Exchanges(surface), surface.markers
    names = [model.components[c].name for c in surface.component[markers]]
    at = np.array([surface.patches[p].drawn[0] for p in markers])
    untouched = Poses(np.eye(3)[None], np.zeros((1, 3)), np.zeros((1, surface.kinematics.n_joints)))
    laid = turns.of(untouched)
    for n, angle in enumerate(turns.angle_rad.tolist()):
        there = at @ laid.R[n].T + laid.t[n]
        on = np.linalg.norm(there[:, None] - at, axis=2).argmin(axis=1)
        yield math.degrees(angle) % 360, {names[m]: names[k] for m, k in enumerate(on.tolist())}

"""Which candidates become objects: the best takes its pixels, the others are judged by what is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .datatypes import Camera
from .evidence import LabelField
from .projection import project
from .spatial import PatchScores, Poses, SpatialModel
from .whole_object import WholeObjectFinder


@dataclass(frozen=True, eq=False)
class Claim:
    """A candidate and what the labels that nobody better owns say of it."""

    finder: WholeObjectFinder
    poses: Poses  # one hypothesis
    votes: float
    scores: PatchScores
    shape: tuple[int, int]  # of the image: height, width


def silhouette(surface: SpatialModel, camera: Camera, poses: Poses) -> list[NDArray[np.float32]]:
    """Everything of one hypothesis: the corners (n, 2) of its boxes and its markers in the image, pixels; convex hulls
    of theirs cover it."""
    frames = surface.kinematics.forward(poses.R, poses.t, poses.q)
    hulls = surface.hulls
    pixels = project(camera, surface.place(frames, hulls.corners, hulls.component)[0]).astype(np.float32)
    return np.split(pixels, hulls.starts[1:])


def share_out(
    found: Sequence[tuple[WholeObjectFinder, Poses]],
    field: LabelField,
    camera: Camera,
    least: float,
    trust: Callable[[Claim], float],
) -> tuple[list[Claim], list[Claim]]:
    """Accepted claims of all targets together, best first, and the best of the others at each place.

    The claim with the most trusted votes takes its pixels; the others are judged again without them.

    :param least: claims with fewer votes are dropped.
    :param trust: what a claim's votes count, 0 to 1; 0: it is not acceptable.
    """
    accepted: list[Claim] = []
    alive = [claim for finder, poses in found for claim in claims_of(finder, poses, field, camera, least)]
    while True:
        trusted = [(weight, c) for c in alive if (weight := trust(c))]
        if not trusted:
            return accepted, _best_of_each_place(alive, camera)
        best = max(trusted, key=lambda t: t[0] * t[1].votes)[1]
        accepted.append(best)
        alive.remove(best)
        if alive:
            field = field.without(silhouette(best.finder.surface, camera, best.poses))
        rest = [(f, [c for c in alive if c.finder is f]) for f, _ in found]
        alive = [
            claim
            for finder, claims in rest
            if claims
            for claim in claims_of(finder, Poses.concatenate([c.poses for c in claims]), field, camera, least)
        ]


def claims_of(finder: WholeObjectFinder, poses: Poses, field: LabelField, camera: Camera, least: float) -> list[Claim]:
    """A claim for each hypothesis with votes enough."""
    scores = finder.judge(field, camera, poses, occlusion=True)
    votes = finder.total(scores)
    shape = (field.labels.shape[0], field.labels.shape[1])
    return [
        Claim(finder, poses[i : i + 1], float(votes[i]), scores[i : i + 1], shape)
        for i in np.flatnonzero(votes > least).tolist()
    ]


def _best_of_each_place(claims: list[Claim], camera: Camera) -> list[Claim]:
    out: list[Claim] = []
    for claim in sorted(claims, key=lambda c: -c.votes):
        near = (c for c in out if c.finder is claim.finder)
        if not any(claim.finder.same_place(camera, claim.poses, c.poses)[0] for c in near):
            out.append(claim)
    return out

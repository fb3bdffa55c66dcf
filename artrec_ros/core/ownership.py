"""Which candidates become objects: the best takes its pixels, the others are judged by what is left."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .datatypes import Camera
from .evidence import LabelField
from .projection import project
from .spatial import PatchScores, Poses, SpatialModel
from .transforms import Array
from .whole_object import Candidates, WholeObjectFinder

_CORNERS = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, -1).T
_SUBPIXEL_BITS = 4


@dataclass(frozen=True, eq=False)
class Claim:
    """A candidate and what the labels that nobody better owns say of it."""

    finder: WholeObjectFinder
    poses: Poses  # one hypothesis
    votes: float
    scores: PatchScores
    shape: tuple[int, int]  # of the image: height, width


def silhouette(surface: SpatialModel, camera: Camera, poses: Poses, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """(H, W) mask of everything of one hypothesis: hulls of its boxes and its markers."""
    mask = np.zeros(shape, np.uint8)
    frames = surface.kinematics.forward(poses.R, poses.t, poses.q)
    for c, component in enumerate(surface.model.components):
        solids = [box.T_component_box.apply(_CORNERS * box.size) for box in component.bodies]
        for marker in component.markers:
            T = marker.T_component_marker
            assert T is not None  # the model is spatial
            solids.append(T.apply(np.pad(marker.outline, ((0, 0), (0, 1)))))
        for solid in solids:
            pixels = project(camera, solid @ frames.R[0, c].T + frames.t[0, c])
            hull = cv2.convexHull(np.clip(pixels, -4 * max(shape), 4 * max(shape)).astype(np.float32))
            cv2.fillConvexPoly(mask, np.rint(hull * (1 << _SUBPIXEL_BITS)).astype(np.int32), 1, shift=_SUBPIXEL_BITS)
    return mask.astype(bool)


def share_out(
    found: list[tuple[WholeObjectFinder, Candidates]],
    field: LabelField,
    camera: Camera,
    least: float,
    accepts: Callable[[Claim], bool],
) -> list[Claim]:
    """Claims of all targets together, best first; each is judged without the pixels of the ones before it.

    A claim that is not accepted takes no pixels from others, but no other claim of its own is made at its place.

    :param least: claims with fewer votes are dropped.
    """
    shape = field.labels.shape
    claims: list[Claim] = []
    alive = [(finder, c.poses, c.votes) for finder, c in found if len(c.poses)]
    while alive:
        finder, poses, votes = max(alive, key=lambda a: float(a[2].max()))
        one = poses[[int(votes.argmax())]]
        scores = finder.judge(field, camera, one, occlusion=True)
        claim = Claim(finder, one, float(votes.max()), scores, (shape[0], shape[1]))
        claims.append(claim)
        if accepts(claim):
            field = field.without(silhouette(finder.surface, camera, one, claim.shape))
            alive = _judged_again(alive, field, camera, least)
        else:
            alive = _elsewhere(alive, finder, one, camera)
    return claims


def _elsewhere(
    alive: list[tuple[WholeObjectFinder, Poses, Array]], finder: WholeObjectFinder, one: Poses, camera: Camera
) -> list[tuple[WholeObjectFinder, Poses, Array]]:
    """Without the finder's candidates at the place of `one`."""
    out = []
    for other, poses, votes in alive:
        keep = np.ones(len(poses), bool)
        if other is finder:
            keep = ~finder.same_place(camera, poses, one)
        if keep.any():
            out.append((other, poses[keep], votes[keep]))
    return out


def _judged_again(
    alive: list[tuple[WholeObjectFinder, Poses, Array]], field: LabelField, camera: Camera, least: float
) -> list[tuple[WholeObjectFinder, Poses, Array]]:
    out = []
    for finder, poses, _ in alive:
        votes = finder.votes(field, camera, poses, occlusion=True)
        if (votes > least).any():
            out.append((finder, poses[votes > least], votes[votes > least]))
    return out

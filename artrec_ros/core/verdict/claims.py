"""Candidates and what the labels say of them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..pose.finder import WholeObjectFinder
from ..pose.surface_model import PatchScores, Poses, SpatialModel


@dataclass(frozen=True, eq=False)
class Claim:
    """A candidate and what the labels that nobody better owns say of it."""

    finder: WholeObjectFinder
    poses: Poses  # one hypothesis
    votes: float
    scores: PatchScores


def claims_of(finder: WholeObjectFinder, poses: Poses, frame: ImageFrame) -> list[Claim]:
    """A claim for each hypothesis."""
    scores = finder.judge(frame, poses, occlusion=True)
    return [
        Claim(finder, poses[i : i + 1], votes, scores[i : i + 1])
        for i, votes in enumerate(finder.total(scores).tolist())
    ]


def corners_of(surface: SpatialModel, camera: Camera, poses: Poses) -> Array:
    """(H, n, 2) pixels of the corners of all boxes and markers: of `surface.hulls`."""
    frames, hulls = surface.kinematics.forward(poses.R, poses.t, poses.q), surface.hulls
    return project(camera, surface.place(frames, hulls.corners, hulls.component))


def silhouette(surface: SpatialModel, camera: Camera, poses: Poses) -> list[NDArray[np.float32]]:
    """Everything of one hypothesis: the corners (n, 2) of its boxes and its markers in the image, pixels; convex hulls
    of theirs cover it."""
    corners = corners_of(surface, camera, poses)[0].astype(np.float32)
    return [corners[first:last] for first, last in pairwise(surface.hulls.starts)]

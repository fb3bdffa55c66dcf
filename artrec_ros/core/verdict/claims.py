"""Candidates and what the labels say of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
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
    """A candidate and what the labels that nobody better owns say of it.

    :param scores: of these labels.
    :param frame: where it is said.
    """

    finder: WholeObjectFinder
    poses: Poses  # one hypothesis
    votes: float
    scores: PatchScores
    frame: ImageFrame
    depth_m: float = math.nan  # of the required component, along the optical axis; NaN: not asked for
    scale: float = math.nan  # pixels per metre there
    misplaced: str | None = None  # why nothing can be there, by what is known of the scene

    @cached_property
    def all_scores(self) -> PatchScores:
        """The same of all labels, whoever owns them."""
        if self.frame.unowned is self.frame:
            return self.scores
        return self.finder.judge(self.frame.unowned, self.poses, occlusion=True)

    def width_px(self, patch: int) -> float:
        """Mean width of a marker as it is seen, pixels, from its area and its outline's length."""
        marker = self.finder.surface.patches[patch].marker
        assert marker is not None
        return 2 * float(self.all_scores.area_px[0, patch]) / max(marker.perimeter * self.scale, 1e-9)


def claims_of(finder: WholeObjectFinder, poses: Poses, frame: ImageFrame) -> list[Claim]:
    """A claim for each hypothesis."""
    scores = finder.judge(frame, poses, occlusion=True)
    anchors = finder.anchors(poses)
    depth_m = anchors[:, 2]
    scale = frame.camera.focal_px / np.maximum(depth_m, 1e-6)
    misplaced = _misplaced(finder, poses, frame, anchors, scale)
    numbers = zip(finder.total(scores).tolist(), depth_m.tolist(), scale.tolist(), misplaced, strict=True)
    return [
        Claim(finder, poses[i : i + 1], votes, scores[i : i + 1], frame, *place)
        for i, (votes, *place) in enumerate(numbers)
    ]


def _misplaced(
    finder: WholeObjectFinder, poses: Poses, frame: ImageFrame, anchors: Array, scale: Array
) -> Sequence[str | None]:
    """Why there can be no objects in poses with their required components at points (H, 3); None where there can."""
    scene = frame.scene
    if not scene:
        return [None] * len(anchors)
    seen = scene.reasons(project(frame.camera, anchors), scale if finder.facing else None)
    if scene.floor is None or finder.facing:
        return seen
    return [a or b for a, b in zip(seen, scene.floor.reasons(poses.R, poses.t), strict=True)]


def corners_of(surface: SpatialModel, camera: Camera, poses: Poses) -> Array:
    """(H, n, 2) pixels of the corners of all boxes and markers: of `surface.hulls`."""
    frames, hulls = surface.kinematics.forward(poses.R, poses.t, poses.q), surface.hulls
    return project(camera, surface.place(frames, hulls.corners, hulls.component))


def silhouette(surface: SpatialModel, camera: Camera, poses: Poses) -> list[NDArray[np.float32]]:
    """Everything of one hypothesis: the corners (n, 2) of its boxes and its markers in the image, pixels; convex hulls
    of theirs cover it."""
    corners = corners_of(surface, camera, poses)[0].astype(np.float32)
    return [corners[first:last] for first, last in pairwise(surface.hulls.starts)]

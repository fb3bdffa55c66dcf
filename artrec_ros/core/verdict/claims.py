"""Candidates and what the labels say of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
    """A candidate and what the labels that nobody better owns say of it.

    :param votes: for all of it. :param scores: of these labels.
    :param full_px: (P,) pixels of each patch that would be seen if nobody owned any.
    :param frame: where it is said.
    :param depth_m: of the required component, along the optical axis. :param scale: pixels per metre there.
    :param misplaced: why nothing can be there, by what is known of the scene.
    """

    finder: WholeObjectFinder
    poses: Poses  # one hypothesis
    votes: float
    scores: PatchScores
    full_px: Array
    frame: ImageFrame
    depth_m: float
    scale: float
    misplaced: str | None


@dataclass(frozen=True, eq=False)
class Claims:
    """H candidates of one target, as `Claim`.

    :param poses, votes, depth_m, scale: (H,). :param scores, full_px: (H, P).
    """

    finder: WholeObjectFinder
    poses: Poses
    votes: Array
    scores: PatchScores
    full_px: Array
    frame: ImageFrame
    depth_m: Array
    scale: Array
    misplaced: Sequence[str | None]

    def __len__(self) -> int:
        return len(self.poses)

    def __getitem__(self, i: int) -> Claim:
        i = range(len(self))[i]
        one = slice(i, i + 1)
        place = float(self.depth_m[i]), float(self.scale[i]), self.misplaced[i]
        votes = float(self.votes[i])
        return Claim(self.finder, self.poses[one], votes, self.scores[one], self.full_px[i], self.frame, *place)

    def __iter__(self) -> Iterator[Claim]:
        return (self[i] for i in range(len(self)))


def claims_of(finder: WholeObjectFinder, poses: Poses, frame: ImageFrame, full_px: Array | None = None) -> Claims:
    """A claim for each hypothesis. :param full_px: as of `Claims`; None: not known."""
    scores = finder.judge(frame, poses, occlusion=True)
    if full_px is None:
        free = frame.unowned
        full_px = scores.area_px if free is frame else finder.judge(free, poses, occlusion=True).area_px
    anchors = finder.anchors(poses)
    depth_m = np.ascontiguousarray(anchors[:, 2])
    scale = frame.camera.focal_px / np.maximum(depth_m, 1e-6)
    misplaced = _misplaced(finder, poses, frame, anchors, scale)
    return Claims(finder, poses, finder.total(scores), scores, full_px, frame, depth_m, scale, misplaced)


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

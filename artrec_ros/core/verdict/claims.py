"""Candidates and what the labels say of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import chain, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.range_limits import scale_limits
from ..geometry.transforms import Array
from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..pose.finder import WholeObjectFinder
from ..pose.poses import PatchScores, Poses
from ..pose.surface_model import SpatialModel

_ALL_AROUND = np.array([(np.cos(a), np.sin(a)) for a in np.arange(8) * np.pi / 4], np.float32)
MOST_KNOWN = 4.0  # scales from one to 55: who knows no more of them knows nothing


@dataclass(frozen=True, eq=False)
class Solids:
    """The n boxes and markers of one object.

    :param at: (m, 3) all of their corners, metres in the camera's frame. :param corners: the same of each in the image,
        pixels; convex hulls of them cover it.
    :param low, high: (n, 2) least and greatest x, y of each, pixels. :param depth: (n,) of their middles along the
        optical axis, metres.
    """

    at: Array
    corners: list[NDArray[np.float32]]
    low: NDArray[np.float32]
    high: NDArray[np.float32]
    depth: Array

    @classmethod
    def of(cls, at: Array, starts: Sequence[int], camera: Camera) -> Solids:
        """:param at: (m, 3). :param starts: where the corners of each begin, and where the last one's end."""
        pixels, first = project(camera, at).astype(np.float32), starts[:-1]
        low, high = np.minimum.reduceat(pixels, first), np.maximum.reduceat(pixels, first)
        depth = np.add.reduceat(at[:, 2], first) / np.diff(starts)
        return cls(at, [pixels[begin:end] for begin, end in pairwise(starts)], low, high, depth)

    def within(self, low: Array, high: Array) -> list[NDArray[np.float32]]:
        """Corners of those that reach into a rectangle of the image, between two of its corners (2,)."""
        meet = ((self.low <= high) & (self.high >= low)).all(axis=1)
        return [self.corners[k] for k in np.flatnonzero(meet)]


@dataclass(frozen=True, eq=False)
class Claim:
    """A candidate and what the labels that nobody better owns say of it.

    :param votes: for all of it. :param scores: of these labels.
    :param full_px: (P,) pixels of each patch that would be seen if nobody owned any.
    :param frame: where it is said.
    :param depth_m: of the required component, along the optical axis; NaN: not known. :param scale: pixels per metre
        there.
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

    @cached_property
    def solids(self) -> Solids:
        """Its boxes and markers."""
        surface = self.finder.surface
        return Solids.of(corners_m(surface, self.poses)[0], surface.hulls.starts, self.frame.camera)


class Seen(NamedTuple):
    """What is seen of H claims whoever owns it.

    :param full_px: (H, P) pixels of each patch that would be in view if nobody owned any.
    :param even: (H,) `RegionFit.evenness` of what faces the camera, where the image has colours; else 0.
    """

    full_px: Array
    even: Array

    def of(self, rows: NDArray[np.int64]) -> Seen:
        return Seen(self.full_px[rows], self.even[rows])


@dataclass(frozen=True, eq=False)
class Claims:
    """H candidates of one target, as `Claim`.

    :param poses, votes, depth_m, scale: (H,). :param scores: (H, P).
    :param known: (H,) logarithm of how many times the least scale that is possible there the greatest is, in space of
        distances on a floor, at most `MOST_KNOWN`.
    """

    finder: WholeObjectFinder
    poses: Poses
    votes: Array
    scores: PatchScores
    seen: Seen
    frame: ImageFrame
    depth_m: Array
    scale: Array
    known: Array
    misplaced: Sequence[str | None]

    def __len__(self) -> int:
        return len(self.poses)

    def contradicted(self, rows: NDArray[np.int64]) -> Array:
        """(n,) see `Alternatives.contradicted`, of some: it is asked of objects alone, and most candidates are none."""
        return self.finder.alternatives.contradicted(self.frame, self.poses[rows])

    def __getitem__(self, i: int) -> Claim:
        i = range(len(self))[i]
        one = slice(i, i + 1)
        place = float(self.depth_m[i]), float(self.scale[i]), self.misplaced[i]
        votes = float(self.votes[i])
        return Claim(self.finder, self.poses[one], votes, self.scores[one], self.seen.full_px[i], self.frame, *place)

    def __iter__(self) -> Iterator[Claim]:
        return (self[i] for i in range(len(self)))


def claims_of(finder: WholeObjectFinder, poses: Poses, frame: ImageFrame, seen: Seen | None = None) -> Claims:
    """A claim for each hypothesis. :param seen: None: not known yet."""
    judge = partial(finder.voter.judge, poses=poses, occlusion=True, covered=finder.facing)
    scores = judge(frame)
    if seen is None:
        free, even = frame.unowned, np.zeros(len(poses))
        full_px = scores.area_px if free is frame else judge(free).area_px
        if finder.rest.regions is not None and frame.image is not None:
            even = finder.rest.regions.evenness(frame, poses)
        seen = Seen(full_px, even)
    if finder.surface.stacks:
        seen = seen._replace(full_px=_of_what_is_there(finder.surface.stack, scores.area_px, seen.full_px))
    anchors = finder.required.anchors(poses)
    depth_m = np.ascontiguousarray(anchors[:, 2])
    scale = frame.camera.focal_px / np.maximum(depth_m, 1e-6)
    if finder.facing:  # that depth is a convention
        depth_m = np.full(len(poses), np.nan)
    misplaced = _misplaced(finder, poses, frame, anchors, scale)
    known = _known(finder, frame, anchors)
    votes = finder.voter.total(scores)
    return Claims(finder, poses, votes, scores, seen, frame, depth_m, scale, known, misplaced)


def _of_what_is_there(stack: NDArray[np.int64], area_px: Array, full_px: Array) -> Array:
    """(H, P) `Seen.full_px`, where of markers that lie on each other another one is there once nobody owns pixels: of
    the one that is seen.

    :param stack: (P,) see `stacks_of`.
    """
    out = full_px.copy()
    for which in np.unique(stack[stack >= 0]):
        mine = stack == which
        area = area_px[:, mine]
        seen = (area > 0).any(axis=1, keepdims=True)
        out[:, mine] = np.where(seen, np.where(area > 0, np.maximum(area, full_px[:, mine]), 0.0), full_px[:, mine])
    return out


def swollen(claims: Claims, larger: WholeObjectFinder) -> Claims:
    """The same as they look with markers larger than they are. :param larger: one of `WholeObjectFinder.swollen`."""
    free = claims.frame.unowned
    full_px = larger.voter.judge(free, claims.poses, occlusion=True, covered=larger.facing).area_px
    return claims_of(larger, claims.poses, claims.frame, Seen(full_px, claims.seen.even))


def _known(finder: WholeObjectFinder, frame: ImageFrame, anchors: Array) -> Array:
    """(H,) see `Claims`, of claims with their required components at points (H, 3)."""
    if not finder.facing:
        floor = frame.scene.floor
        return np.full(len(anchors), MOST_KNOWN if floor is None else min(floor.log_depths, MOST_KNOWN))
    limits = scale_limits(finder.config, None)
    if frame.scene:
        within = np.clip(frame.scene.scale_limits(project(frame.camera, anchors)), limits.least, limits.greatest)
        ratio = within[:, 1] / np.maximum(within[:, 0], 1e-9)
        return np.asarray(np.minimum(np.log(np.maximum(ratio, 1.0)), MOST_KNOWN), np.float64)
    ratio_of_all = float(limits.greatest) / max(float(limits.least), 1e-9)
    return np.full(len(anchors), min(math.log(max(ratio_of_all, 1.0)), MOST_KNOWN))


def _misplaced(
    finder: WholeObjectFinder, poses: Poses, frame: ImageFrame, anchors: Array, scale: Array
) -> Sequence[str | None]:
    """Why there can be no objects in poses with their required components at points (H, 3); None where there can."""
    scene = frame.scene
    if not scene:
        return [None] * len(anchors)
    seen = scene.reasons(project(frame.camera, anchors), scale if finder.facing else None)
    if scene.floor is None:
        return seen
    return [a or b for a, b in zip(seen, scene.floor.reasons(poses.R, poses.t), strict=True)]


def corners_of(surface: SpatialModel, camera: Camera, poses: Poses) -> Array:
    """(H, n, 2) pixels of the corners of all boxes and markers: of `surface.hulls`."""
    return project(camera, corners_m(surface, poses))


def corners_m(surface: SpatialModel, poses: Poses) -> Array:
    """(H, n, 3) where these are, metres in the camera's frame."""
    frames, hulls = surface.kinematics.seen(poses.R, poses.t, poses.q), surface.hulls
    return surface.place(frames, hulls.corners, hulls.component)


def silhouettes(surface: SpatialModel, camera: Camera, poses: Poses) -> list[list[NDArray[np.float32]]]:
    """Everything of each hypothesis: the corners (n, 2) of its boxes and its markers in the image, pixels; convex hulls
    of theirs cover it."""
    ends = list(pairwise(surface.hulls.starts))
    return [[own[a:b] for a, b in ends] for own in corners_of(surface, camera, poses).astype(np.float32)]


def silhouette(surface: SpatialModel, camera: Camera, poses: Poses) -> list[NDArray[np.float32]]:
    """The same of the first one."""
    return silhouettes(surface, camera, poses[:1])[0]


def left_by(frame: ImageFrame, claims: Sequence[Claim]) -> ImageFrame:
    """The frame without the pixels of some claims."""
    hulls = list[NDArray[np.float32]]()
    for finder in dict.fromkeys(c.finder for c in claims):
        poses = Poses.concatenate([c.poses for c in claims if c.finder is finder])
        hulls += chain.from_iterable(silhouettes(finder.surface, frame.camera, poses))
    return frame.without(hulls)


def unexplained(left: ImageFrame, blobs: Sequence[Blob], explained: float) -> NDArray[np.bool_]:
    """(B,) of which blobs of a frame less is owned, in what some claims have left of it, than explains them."""
    return np.array([left.field.owned_inside(b.pixels) <= explained for b in blobs], bool)


def widened(hull: NDArray[np.float32], by_px: float) -> NDArray[np.float32]:
    """Points whose convex hull is wider than that of some (n, 2), by so much all around."""
    return np.concatenate([hull + by_px * way for way in _ALL_AROUND]) if by_px else hull

"""What of an object should be seen where a pose has it, and is not.

A marker that shows fewer pixels than a blob must have says nothing. Of one that shows more, be it half beyond the
image's border, these should bear its class: that all that is in view of it is hidden is about as rare as that it is
hidden altogether, for what hides things is seldom smaller than they are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.codes import OUTSIDE, OWNED
from ..image.image_frame import ImageFrame
from ..model.surface import INSIDE_POINTS
from .finder import WholeObjectFinder
from .poses import PatchScores, Poses

_BENT = 32  # ways to bend what is not seen
_BARE = 0.5  # share of a marker's points that show classes of others
_WAYS = np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])


class InView(NamedTuple):
    """Of H poses and M markers. :ivar lacking: (H, M) should be seen and are not. :ivar seen: (H, M) are, be it that
    the image cuts off most of them."""

    lacking: NDArray[np.bool_]
    seen: NDArray[np.bool_]


def in_view(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, scores: PatchScores) -> InView:
    """What of poses is in plain view. :param scores: of these in this frame."""
    config, m = finder.config, finder.surface.marker_columns
    own_px = scores.agree[:, m] * scores.area_px[:, m]
    px = scores.area_px[:, m] * _share_in_image(finder, frame, poses)
    shows = px > config.min_blob_px
    seen = shows & (own_px > config.votes.supported_agree * px) & (scores.votes[:, m] > 0)
    return InView(shows & ~seen, seen)


def bare(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, scores: PatchScores) -> NDArray[np.bool_]:
    """(H, M) which markers are not seen where the image shows a class of the object's others instead: what they lie on
    is in plain view, so that nothing hides them. Their pixels may have another class, which is about as rare."""
    surface = finder.surface
    of = np.repeat(np.arange(len(surface.markers)), INSIDE_POINTS)
    own, codes = surface.may_show[surface.component[surface.markers]], _codes(finder, frame, poses)[1]
    labels = surface.codes.label[codes]
    others = (own.any(axis=0) & ~own)[of, labels.reshape(len(poses), -1)].reshape(codes.shape)
    return np.asarray((scores.votes[:, surface.marker_columns] <= 0) & (others.mean(axis=2) > _BARE))


def _codes(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> tuple[Array, NDArray[np.uint8]]:
    """Where points on all markers are (H, M * n, 2), pixels, and the codes there (H, M, n)."""
    surface = finder.surface
    markers, frames = surface.markers, surface.kinematics.seen(poses.R, poses.t, poses.q)
    points = np.concatenate([surface.patches[p].inside for p in markers.tolist()])
    pixels = project(frame.camera, surface.place(frames, points, np.repeat(surface.component[markers], INSIDE_POINTS)))
    return pixels, frame.field.at(pixels).reshape(len(poses), len(markers), INSIDE_POINTS)


def _share_in_image(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Array:
    """(H, M) of what scores count of each marker the share that is in the image, and not so near to its border that a
    seam may be all that is left of it; a ball's they count alone."""
    surface, seam_px = finder.surface, finder.config.votes.ring_width_px
    markers, frames = surface.markers, surface.kinematics.seen(poses.R, poses.t, poses.q)
    pixels, codes = _codes(finder, frame, poses)
    counted = surface.shown(frames, markers, INSIDE_POINTS) & (codes != OWNED)
    inside = np.all([frame.field.at(pixels + seam_px * way) != OUTSIDE for way in _WAYS], axis=0).reshape(codes.shape)
    share = (counted & inside).sum(axis=2) / np.maximum(counted.sum(axis=2), 1)
    bulges = np.array([surface.patches[p].bulge > 0 for p in markers.tolist()], bool)
    return np.where(bulges, 1.0, share)


def log_unseen(finder: WholeObjectFinder, lacking: NDArray[np.bool_]) -> Array:
    """(H,) log probability that of H poses' markers those are `lacking` (H, M): something unknown hides each for
    itself, or all together, and then any number of them as easily."""
    share, count = finder.config.verdict.hidden_share, lacking.sum(axis=1)
    together = np.where(count > 0, np.log(share / lacking.shape[1]), 0.0)
    return np.maximum(count * np.log(share), together)


def log_unseen_bent(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Array:
    """(H,) the same of poses whose joints move nothing that is seen: in the mean over all ways to bend them, for a
    search bends what it does not find out of the image."""
    kin = finder.surface.kinematics
    n = _BENT if kin.n_joints else 1
    q = np.tile(kin.lower + (kin.upper - kin.lower) * _spread(n, kin.n_joints), (len(poses), 1))
    bent = Poses(np.repeat(poses.R, n, axis=0), np.repeat(poses.t, n, axis=0), q)
    lacking = in_view(finder, frame, bent, finder.voter.judge(frame, bent, occlusion=True)).lacking
    each = log_unseen(finder, lacking).reshape(len(poses), n)
    return np.asarray(np.logaddexp.reduce(each, axis=1) - np.log(n), np.float64)


def _spread(n: int, of: int) -> Array:
    """(n, of) evenly spread numbers from 0 to 1, by multiples of numbers that no fraction comes near to."""
    steps = 2.0 ** (np.arange(1, of + 1) / (of + 1))
    return np.asarray((np.arange(n)[:, None] + 0.5) * steps % 1.0, np.float64)

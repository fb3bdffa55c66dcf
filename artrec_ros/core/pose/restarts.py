"""Where fits come to rest that begin elsewhere: what a fit's own equations do not know of how sure it is.

Labels are whole pixels, so a contour's distance from its edge goes by steps; edges come into reach and out of it; and
a second pose may fit as well, the mirrored turn of a small marker above all. Derivatives at one pose know none of this.
"""

from __future__ import annotations

import numpy as np

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array, rotvec_from_rotation, short_way
from ..image.image_frame import ImageFrame
from .fit_kernels import move_each
from .pose_fit import fit_poses, joints_of
from .poses import Poses
from .surface_model import SpatialModel


def scatter(
    model: SpatialModel,
    frame: ImageFrame,
    poses: Poses,
    use: np.ndarray,
    covariances: Array,
    known: Array,
    config: RecognizerConfig,
    *,
    facing: bool = False,
) -> Array:
    """(H, 6+J, 6+J) mean squares of how far from fitted hypotheses those come to rest that begin a few deviations off,
    to either side along the direction of which the image tells least, but something.

    :param use: (H, M) as of `fit_poses`. :param covariances: (H, 6+J, 6+J) how sure each is to first order.
    :param known: (H, 6+J) deviations without any image. :param facing: poses turn about the optical axis alone.
    """
    away = _away(_without_tilt(covariances) if facing else covariances, known, config)
    away /= np.maximum(1.0, (np.abs(away) / _farthest(model, poses, config)).max(axis=1, keepdims=True))
    begun, twice, fit = _to_both_sides(model, poses, away), np.repeat(use, 2, axis=0), config.fit
    rests = fit_poses(model, frame.unhurried(), begun, twice, fit.fine_reach_px, fit, facing=facing, last=True)
    off = _between(model, rests, poses)
    return np.asarray(off.swapaxes(1, 2) @ off / 2, np.float64)


def _without_tilt(covariances: Array) -> Array:
    """Covariances (H, 6+J, 6+J) where rotations about x and y are what they are: none is tried, so no place is that
    makes up for one."""
    tilt, rest = [3, 4], [i for i in range(covariances.shape[1]) if i not in (3, 4)]
    both, out = covariances[:, rest][:, :, tilt], np.zeros_like(covariances)
    explained = both @ np.linalg.solve(covariances[:, tilt][:, :, tilt], both.swapaxes(1, 2))
    out[:, np.array(rest)[:, None], rest] = covariances[:, rest][:, :, rest] - explained
    return out


def _away(covariances: Array, known: Array, config: RecognizerConfig) -> Array:
    """(H, 6+J) displacements along the direction of which the image tells least."""
    squares, axes = np.linalg.eigh(covariances / (known[:, :, None] * known[:, None]))
    shares = np.sqrt(np.minimum(np.maximum(squares, 0.0), 1.0))  # 1: of that direction the image says nothing
    sizes = shares * (1 - shares)
    least, each = sizes.argmax(axis=1), np.arange(len(sizes))
    size = config.covariance.restart_sigma * sizes[each, least]
    return np.asarray(axes[each, :, least] * size[:, None] * known, np.float64)


def _farthest(model: SpatialModel, poses: Poses, config: RecognizerConfig) -> Array:
    """(H, 6+J) the longest step of a fit: from farther off none would come back."""
    out = np.empty((len(poses), 6 + model.kinematics.n_joints))
    out[:, :3] = config.fit.most_shift * np.maximum(poses.t[:, 2:], 1e-6)
    out[:, 3:] = config.fit.most_bend
    out[:, 6:] *= model.kinematics.unit
    return out


def _to_both_sides(model: SpatialModel, poses: Poses, away: Array) -> Poses:
    """(2 H) each of H hypotheses there and back by its displacement (H, 6+J)."""
    R, t, q = (np.repeat(values, 2, axis=0) for values in (poses.R, poses.t, poses.q))
    move_each(
        np.stack([away, -away], axis=1).reshape(2 * len(away), away.shape[1]), joints_of(model.kinematics), R, t, q
    )
    return Poses(R, t, q)


def _between(model: SpatialModel, there: Poses, here: Poses) -> Array:
    """(H, 2, 6+J) from each of H hypotheses to its two."""
    H, J = here.q.shape
    R, t, q = there.R.reshape(H, 2, 3, 3), there.t.reshape(H, 2, 3), there.q.reshape(H, 2, J)
    bent = short_way(q - here.q[:, None], model.kinematics.endless)
    turned = rotvec_from_rotation(R @ here.R[:, None].swapaxes(-1, -2))
    return np.concatenate([t - here.t[:, None], turned, bent], axis=-1)

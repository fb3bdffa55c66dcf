"""The last fit of objects in space, where the image has colours: to where these change, not to classes' boundaries.

Where a class ends is what somebody has told of colours: of blurred edges it takes more than half of what is blended, or
less, and markers look too large, or too small. Along each normal of a contour the colours a little inside and outside
are the two ends of a step; the edge is where half of it is done. Where colours tell none (a neighbour of like colour,
clutter), the labels' edge counts, but less.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array, rotation_from_rotvec
from ..image.image_frame import ImageFrame
from .pose_fit import AS_GOOD_AS_CERTAIN, ContourFit, contour_fit, weight_at_edges
from .surface_model import Poses, SpatialModel

_SAMPLES = 15  # along a normal: where they are half a pixel apart for the widest reach
_SHARES = np.r_[0.5, np.ones(_SAMPLES - 2), 0.5] / (_SAMPLES - 1)  # of what lies between them (trapezoids)
_ENDS = 2  # of them on either side tell what a step begins and ends with
_ASIDE = 0.25  # of a step: colours that are no blend of its ends pass a third one, such as a dark rim
_KEPT = 0.8  # of what points weigh at least: one that loses its edges lies on nothing
_CLEAN = 1.5  # ways that colours go between the ends at most: one who goes to and fro passes more than one edge


class ColourFit:
    """Fits one model's poses."""

    def __init__(self, surface: SpatialModel, config: RecognizerConfig) -> None:
        self._surface, self._config = surface, config.fit
        shown = [surface.patches[p].marker for p in surface.markers]
        self._radius_m = np.array([m.radius for m in shown if m is not None])

    def fitted(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> Poses:
        """Poses at rest on the colours' edges, but for those that lie worse on them than before.

        :param used: (H, M) markers that the labels support.
        """
        if not len(poses) or not used.any():
            return poses
        at, (fit, residual, weight) = poses, self.edges(frame, poses, used)
        before, seen = _misfit(residual, weight), _total(weight)
        at_edges = weight_at_edges(self._surface, used, self._config)
        for _ in range(self._config.colour_rounds):
            at = self._step(at, fit, residual, weight, at_edges)
            fit, residual, weight = self.edges(frame, at, used)
        better = (_misfit(residual, weight) < before) & (_total(weight) > _KEPT * seen)
        both = Poses.concatenate([poses, at])
        return both[np.arange(len(poses)) + len(poses) * better]

    def edges(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> tuple[ContourFit, Array, Array]:
        """Contours against the labels' edges, and the residuals and weights (H, M, m) of the colours'."""
        config, which = self._config, np.flatnonzero(used.any(axis=0))
        fit = contour_fit(self._surface, frame, poses, used, config.colour_reach_px, config)
        scale = frame.camera.focal_px / np.maximum(poses.t[:, 2], 1e-6)
        half = np.clip(self._radius_m[which] * scale[:, None], 1.0, config.colour_reach_px + 0.5)[..., None]
        off = half[..., None] * np.linspace(-1, 1, _SAMPLES)  # (H, M, 1, S) along the normals, from the labels' edges
        edges, outward = fit.point - fit.residual[..., None] * fit.normal, fit.normal[..., None, :]
        values = _sampled(frame, edges[..., None, :] + off[..., None] * outward)
        apart = np.linalg.norm(_end(values) - _begin(values), axis=-1)
        done, clean = _along(values**frame.gamma)  # lenses blend light
        beyond = half * (1 - 2 * done @ _SHARES)  # as much before it as behind
        told = (fit.weight > 0) & (apart > config.colour_contrast) & clean & (np.abs(beyond) < half / 2)
        residual = np.where(told, fit.residual - beyond, fit.residual)
        return fit, residual, fit.weight * np.where(told, 1.0, config.colour_doubt)

    def _step(self, poses: Poses, fit: ContourFit, residual: Array, weight: Array, at_edges: Array) -> Poses:
        """One step of least squares, in which far residuals pull no more than those of a pixel (Huber).

        :param at_edges: (H,) see `ContourTerm`: paint may be larger than it was measured, and light spread otherwise.
        """
        config, kin, (H, _, _, n) = self._config, self._surface.kinematics, fit.jacobian.shape
        r = residual.reshape(H, -1)
        J = np.concatenate([fit.jacobian.reshape(H, -1, n), np.ones((*r.shape, 1))], axis=-1)
        w = weight.reshape(H, -1) / np.maximum(1.0, np.abs(r))
        held = np.empty((H, n + 1))  # per unit of a point's variance: steps are short (Levenberg)
        held[:, :3] = (config.shift_sigma * np.maximum(poses.t[:, 2:], 1e-6)) ** -2.0
        held[:, 3:n], held[:, 6:n] = config.bend_sigma**-2.0, (config.bend_sigma * kin.unit) ** -2.0
        held *= config.point_sigma_px**2
        held[:, n] = np.minimum(at_edges, AS_GOOD_AS_CERTAIN)
        pull = np.einsum("hnp,hn->hp", J, w * r)  # of joints nothing more: those that nobody sees stay
        A = np.einsum("hnp,hnq->hpq", J, J * w[..., None]) + held[:, None] * np.eye(n + 1)
        x = -np.linalg.solve(A, pull[..., None])[..., 0]
        R = rotation_from_rotvec(x[:, 3:6]) @ poses.R
        return Poses(R, poses.t + x[:, :3], kin.bound(poses.q + x[:, 6:n]))


def _begin(colours: Array) -> Array:
    return np.asarray(colours[..., :_ENDS, :].mean(axis=-2))


def _end(colours: Array) -> Array:
    return np.asarray(colours[..., -_ENDS:, :].mean(axis=-2))


def _along(light: Array) -> tuple[Array, NDArray[np.bool_]]:
    """(..., S) how much of a step from one end to the other is done in each of the colours (..., S, 3), and (...)
    whether that is one step between two colours."""
    begin, step = _begin(light)[..., None, :], (_end(light) - _begin(light))[..., None, :]
    size = np.maximum((step**2).sum(axis=-1), 1e-9)
    done = ((light - begin) * step).sum(axis=-1) / size
    aside = np.linalg.norm(light - begin - done[..., None] * step, axis=-1).max(axis=-1)
    ways = np.abs(np.diff(done, axis=-1)).sum(axis=-1)
    return np.clip(done, -0.2, 1.2), (ways < _CLEAN) & (aside < _ASIDE * np.sqrt(size[..., 0]))


def _sampled(frame: ImageFrame, at: Array) -> Array:
    """(..., 3) values of an image at pixels (..., 2), 0 to 1."""
    assert frame.image is not None  # the caller's condition
    flat = np.ascontiguousarray(at.reshape(-1, at.shape[-2], 2), np.float32)
    out = [
        cv2.remap(frame.image, part[..., 0], part[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        for part in np.array_split(flat, len(flat) // (1 << 14) + 1)  # as many rows as it takes
    ]
    return np.asarray(np.concatenate(out).reshape(*at.shape[:-1], 3) / 255, np.float64)


def _misfit(residual: Array, weight: Array) -> Array:
    """(H,) mean size of the residuals (H, M, m)."""
    return np.asarray((weight * np.minimum(np.abs(residual), 3.0)).sum(axis=(1, 2)) / np.maximum(_total(weight), 1e-9))


def _total(weight: Array) -> Array:
    return np.asarray(weight.sum(axis=(1, 2)))

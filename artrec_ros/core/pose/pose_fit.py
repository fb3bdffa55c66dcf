"""Least squares of a whole object's pose and joints: the contours of its markers, what is known of joints, short steps.

Gauss-Newton with Levenberg damping; each term is a file of its own, fit_kernels.py puts them together.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..base.config import FitConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..model.kinematics import Kinematics
from .contour_term_kernels import ContourFit, ContourTerm, contour_rows
from .damping_kernels import Damping
from .edge_kernels import EdgeTerms
from .edges import edge_terms
from .fit_kernels import Terms, fit_each
from .floor_term import floor_term, is_told
from .floor_term_kernels import FloorTerm
from .joint_prior_kernels import JointPrior
from .occlusion import BEHIND
from .placed_kernels import Joints
from .poses import Poses
from .surface_model import SpatialModel

_MOST_OFF = 3  # deviations
_PIN = 1e9  # weight that holds a parameter: beyond all others, and no overflow
AS_GOOD_AS_CERTAIN = 1e12  # a weight beyond all others that still is a number among them
AT_ONCE = 64  # hypotheses between two looks at the clock
ALL_SHOWN = np.empty((0, 0, 0), bool)  # nobody asks what of a contour is hidden


def fit_poses(
    model: SpatialModel,
    frame: ImageFrame,
    poses: Poses,
    use: np.ndarray,
    reach_px: tuple[int, ...],
    config: FitConfig,
    free_joints: np.ndarray | None = None,
    *,
    facing: bool = False,
    last: bool = False,
) -> Poses:
    """One fit, see `Fit.of`. :param facing: poses turn about the optical axis alone."""
    return Fit(model, config, facing=facing).of(frame, poses, use, reach_px, free_joints, last=last)


class Fit:
    """What fits of one model have in common.

    :param facing: poses turn about the optical axis alone. :ivar joints: for compiled code.
    """

    def __init__(self, model: SpatialModel, config: FitConfig, *, facing: bool) -> None:
        kin = model.kinematics
        self._model, self._config, self.joints = model, config, joints_of(kin)
        self._prior, self._damping = _joint_prior(kin, config), damping_of(config, facing=facing)

    def of(
        self,
        frame: ImageFrame,
        poses: Poses,
        use: np.ndarray,
        reach_px: tuple[int, ...],
        free_joints: np.ndarray | None = None,
        *,
        last: bool = False,
    ) -> Poses:
        """Poses fitted to the labels' boundaries; one that uses no marker stays, as do those left at the deadline.

        :param use: (H, M) bool: which markers of `model.markers` to use under each hypothesis.
        :param reach_px: how far each step looks for edges. :param free_joints: (H, J) bool; None: all.
        :param last: nothing comes after this fit: what the object hides of its own contours where it begins is left
            out, and all edges together may lie outwards or inwards.
        """
        shown = self._model.shown_contour(poses, use) if last else ALL_SHOWN
        terms = self.terms(frame, use, reach_px, free_joints, shown)
        if last:
            at_edges = weight_at_edges(self._model, use, self._config, terms.floor)
            terms = terms._replace(contours=terms.contours._replace(at_edges=at_edges))
        return self.by(terms, frame, poses)

    def terms(
        self,
        frame: ImageFrame,
        use: np.ndarray,
        reach_px: tuple[int, ...],
        free_joints: np.ndarray | None = None,
        shown: np.ndarray = ALL_SHOWN,
    ) -> Terms:
        """What the fits of H hypotheses balance; arguments as of `of`.

        :param shown: (H, M, m) see `ContourTerm`.
        """
        free = np.ones((len(use), len(self._prior.middle)), bool) if free_joints is None else free_joints
        edges = edge_terms(self._model, frame.field, reach_px, self._config)
        contours, prior = _contour_term(self._model, frame, use, shown, edges), self._prior._replace(free=free)
        floor = floor_term(frame.scene.floor, self._config)
        return Terms(contours, prior, floor, self._damping)

    def by(self, terms: Terms, frame: ImageFrame, poses: Poses) -> Poses:
        """Fits of H poses; those that are left at the deadline stay as they are."""
        R, t, q = poses.R.copy(), poses.t.copy(), poses.q.copy()
        for part in frame.deadline.parts(len(poses), AT_ONCE):
            fit_each(of_some(terms, part), self._model.kinematics.chain, self.joints, R[part], t[part], q[part])
        return Poses(R, t, q)


def weight_at_edges(model: SpatialModel, use: np.ndarray, config: FitConfig, floor: FloorTerm) -> Array:
    """(H,) see `ContourTerm.at_edges`: inf where neither a floor, two markers that stand apart nor a long one tell the
    range. What is between markers that adjoin each other moves neither outwards nor inwards.

    :param use: (H, M) the markers that are fitted.
    """
    apart = use & model.stand_apart
    told = is_told(floor) | (apart.sum(axis=1) > 1) | (apart & far_ends(model, config).any(axis=1)).any(axis=1)
    return np.where(told, (config.point_sigma_px / config.edges_off_px) ** 2, np.inf)


def far_ends(model: SpatialModel, config: FitConfig) -> NDArray[np.bool_]:
    """(M, m) contour points of long markers at their ends: where most of a contour is fitted to edges that are off, as
    far as edges may be, these are beyond reach of theirs."""
    return np.asarray(model.stretch > 1 + max(config.fine_reach_px) / (_MOST_OFF * config.point_sigma_px))


def of_some(terms: Terms, part: slice) -> Terms:
    """The terms of some of the hypotheses."""
    of = terms.contours
    if part == slice(0, len(of.use)):
        return terms
    seen = of._replace(use=of.use[part], shown=of.shown[part], at_edges=of.at_edges[part])
    return terms._replace(contours=seen, joints=terms.joints._replace(free=terms.joints.free[part]))


def fit_component(
    model: SpatialModel,
    frame: ImageFrame,
    poses: Poses,
    component: int,
    config: FitConfig,
    reach_px: tuple[int, ...] | None = None,
    *,
    facing: bool = False,
) -> Poses:
    """Fit poses to the contours of one component alone, from afar; joints stay. As `fit_poses`.

    :param reach_px: None: as configured.
    """
    use = np.tile(model.component[model.markers] == component, (len(poses), 1))
    pinned, reach_px = np.zeros(poses.q.shape, bool), reach_px or config.coarse_reach_px
    return fit_poses(model, frame, poses, use, reach_px, config, pinned, facing=facing)


def contour_fit(
    model: SpatialModel, frame: ImageFrame, poses: Poses, use: np.ndarray, reach: int, config: FitConfig
) -> ContourFit:
    """How poses fit as they are; the markers that some hypothesis uses."""
    kin, (term, which, fit) = model.kinematics, contours_of(model, frame, use, reach, config)
    contour_rows(term, which, kin.chain, joints_of(kin), BEHIND, poses.R, poses.t, poses.q, fit)
    return fit


def contours_of(
    model: SpatialModel, frame: ImageFrame, use: np.ndarray, reach: int, config: FitConfig
) -> tuple[ContourTerm, NDArray[np.int64], ContourFit]:
    """For compiled code: markers that some of H hypotheses use (H, M), their numbers (K,), and room for how these
    fit."""
    which = np.flatnonzero(use.any(axis=0))
    size = len(use), len(which), model.contour.shape[1]
    fit = ContourFit(
        np.empty((*size, 2)), np.empty((*size, 2)), np.empty(size[:2]), np.empty(size), np.empty(size),
        np.zeros((*size, 6 + model.kinematics.n_joints)), np.zeros(size, bool),
    )  # fmt: skip
    return _contour_term(model, frame, use, ALL_SHOWN, edge_terms(model, frame.field, (reach,), config)), which, fit


def but_for_common(residual: Array, weight: Array) -> Array:
    """(H, M, m) distances of contours from edges but for what all of a hypothesis have in common: that all labels are
    thicker or thinner than the markers says nothing of where these are."""
    common = (weight * residual).sum(axis=(1, 2)) / np.maximum(weight.sum(axis=(1, 2)), 1e-9)
    return np.asarray(residual - common[:, None, None])


def _contour_term(
    model: SpatialModel, frame: ImageFrame, use: np.ndarray, shown: np.ndarray, edges: EdgeTerms
) -> ContourTerm:
    used, limit, at_edges = np.ascontiguousarray(use), model.limits.least_cosine, np.full(len(use), np.inf)
    return ContourTerm(model.compiled, model.markers, used, edges, frame.view, limit, shown, at_edges)


def _joint_prior(kin: Kinematics, config: FitConfig) -> JointPrior:
    """Of no hypothesis yet."""
    weight = (config.point_sigma_px / (config.joint_sigma * kin.unit)) ** 2
    return JointPrior(kin.middle, weight, np.empty((0, kin.n_joints), bool), _PIN)


def damping_of(config: FitConfig, *, facing: bool) -> Damping:
    """For compiled code. :param facing: poses turn about the optical axis alone."""
    deviation, limit = (config.shift_sigma, config.bend_sigma), (config.most_shift, config.most_bend)
    held = np.array([0.0, 0.0, 0.0, _PIN, _PIN, 0.0]) if facing else np.zeros(6)
    return Damping(float(config.point_sigma_px), np.array(deviation, float), np.array(limit, float), held)


def joints_of(kin: Kinematics) -> Joints:
    """For compiled code."""
    return Joints(kin.lower, kin.upper, kin.unit, kin.revolute, kin.endless, kin.moves)

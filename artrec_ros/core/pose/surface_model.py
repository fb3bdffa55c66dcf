"""A spatial object's hypotheses, batched: where its surface lands in the image and what the labels say of it."""

from __future__ import annotations

from copy import copy
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..base.config import FitConfig, VotesConfig
from ..geometry.transforms import Array
from ..image.codes import EMPTY, LABELS, OUTSIDE, OWNED, UNKNOWN, Codes
from ..image.image_frame import ImageFrame
from ..image.label_field import LabelField
from ..model.chain_kernels import place_points
from ..model.kinematics import Frames, Kinematics
from ..model.objects import ObjectModel
from ..model.solids import convex_solids
from ..model.stacked import stacks_of
from ..model.surface import Patch, free_contour, is_on_unknown, meeting_contour, patches_of
from .across_kernels import Tipped
from .compiled_surface import compiled_surface, surface_limits
from .edge_kernels import EdgeTerms
from .hiding_kernels import shown_contours, shown_points
from .joint_kernels import search_joints
from .occlusion import BEHIND, BodyBoxes, hulls_of, opaque_of
from .poses import PatchScores, Poses
from .sides import Sides
from .surface_kernels import Surface
from .tipped_markers import tipped_markers
from .vote_kernels import score_patches
from .votes import VoteRoles

_SLIGHT = 1e-6  # a depth that is none but for rounding
_AT_ONCE = 32  # hypotheses whose joints are searched between two looks at the clock


class SpatialModel:
    """One target's surface as arrays.

    :param votes: what labels say of it. :param codes: what pixels' codes say of their labels.
    """

    def __init__(self, model: ObjectModel, label: int, votes: VotesConfig, codes: Codes = LABELS) -> None:
        self.model = model
        self.votes = votes
        self.limits = surface_limits(votes)
        self.edges_known = dict[tuple[int, ...], tuple[LabelField, FitConfig, EdgeTerms]]()  # see `edge_terms`
        self.kinematics = Kinematics(model)
        self.patches: list[Patch] = patches_of(model, label)
        self.codes, self.roles = codes, VoteRoles(votes, codes)
        bodies = [c.body_labels for c in model.components]
        self.root = model.components.index(model.required)
        self.labels = [c.labels(label) for c in model.components]  # that each component's markers may have
        self.is_on_unknown = is_on_unknown(self.patches)
        self.component = np.array([p.component for p in self.patches])
        self.is_marker = np.array([p.marker is not None for p in self.patches])
        self.stack = stacks_of(self.patches)
        self.normal = np.array([p.normal for p in self.patches])
        self.centre = np.array([p.inside.mean(axis=0) for p in self.patches])
        self.area = np.array([p.area for p in self.patches])
        self.role = np.array([self._role(p) for p in self.patches])
        self.markers = np.flatnonzero(self.is_marker)
        # their columns among those of all patches: a view of these where there are no others
        self.marker_columns = slice(None) if self.is_marker.all() else self.markers
        # those faces of bodies that can be told
        self.classed_faces = [n for n, p in enumerate(self.patches) if p.marker is None and p.labels]
        self.marker_labels = tuple(self.patches[p].labels for p in self.markers)
        self.markers_of = [self.markers[self.component[self.markers] == c].tolist() for c in range(len(bodies))]
        self.contour = np.array([self.patches[i].contour for i in self.markers])  # (M, m, 3)
        self.contour_along = np.array([self.patches[i].contour_along for i in self.markers])  # (M, m, 3)
        self.perimeter = np.array([p.marker.perimeter for p in self.patches if p.marker is not None])
        self.ring_role = np.array(
            [self.roles.ring(self.patches[i].labels, bodies[self.component[i]]) for i in self.markers]
        )
        self.rim_role = np.array([self.roles.rim(self.patches[i].labels) for i in self.markers])
        self.table = self.roles.table
        self.boxes = BodyBoxes(model)
        self.hulls = hulls_of(model)
        self.ignored = self.boxes.behind_patches(self.patches)
        self.opaque = opaque_of(self.boxes, self.patches)
        required = [p for p in self.patches if p.component == self.root]
        # amid the required component's markers, in its frame
        self.anchor = np.concatenate([p.inside for p in required if p.marker is not None]).mean(axis=0)
        whole = np.concatenate([p.inside for p in required])
        self.extent = float(np.linalg.norm(whole - self.anchor, axis=1).max())  # of the required component, metres

    @cached_property
    def compiled(self) -> Surface:
        """The same for compiled code."""
        return compiled_surface(self)

    @cached_property
    def _hidden_by_rigid(self) -> Surface:
        """The same, where bodies hide only what is rigid to them."""
        moves = self.kinematics.moves
        loose = (moves[self.component][:, None] != moves[self.boxes.component]).any(axis=2)
        return self.compiled._replace(ignored=self.ignored | loose)

    @cached_property
    def by_component(self) -> tuple[np.ndarray, np.ndarray]:
        """(P,) patches by component, those of a stack side by side, and where those of each one begin: (C + 1,)."""
        order = np.lexsort((self.stack, self.component))
        return order, np.searchsorted(self.component[order], np.arange(len(self.kinematics.parent) + 1))

    @cached_property
    def of_component(self) -> Array:
        """(P, C) 1 where a patch is one component's, else 0."""
        return np.asarray(self.component[:, None] == np.arange(len(self.kinematics.parent)), np.float64)

    @cached_property
    def classes(self) -> tuple[NDArray[np.int64], Array]:
        """How many classes each patch may be of (P,), and how far each code is of each of these (P, most, 256)."""
        count = np.array([len(p.labels) for p in self.patches])
        each = np.zeros((len(count), count.max(), 256))
        for own, patch in zip(each, self.patches, strict=True):
            own[: len(patch.labels)] = self.codes.share[:, list(patch.labels)].T
        return count, each

    @cached_property
    def stacks(self) -> bool:
        """Whether any markers lie on each other, of which one at a time is there."""
        return bool((self.stack >= 0).any())

    @cached_property
    def choices(self) -> Array:
        """(C,) logarithms of how many classes each component's markers may be of, and of how many lie on each other."""
        views = [max(np.bincount(self.stack[m] + 1)[1:], default=1) for m in self.markers_of]
        return np.asarray(np.log([len(own) * n for own, n in zip(self.labels, views, strict=True)]), np.float64)

    @cached_property
    def may_show(self) -> NDArray[np.bool_]:
        """(C, 256) whether each component's markers may be of a class."""
        return np.array([np.isin(np.arange(256), own) for own in self.labels])

    @cached_property
    def root_others(self) -> Array:
        """(256,) how far each code is of a known class that is none of the required component's."""
        known = 1 - self.codes.share[:, [UNKNOWN, EMPTY, OWNED, OUTSIDE, *self.labels[self.root]]].sum(axis=1)
        return np.ascontiguousarray(known)

    def _role(self, patch: Patch) -> int:
        """Of its points."""
        if patch.marker is not None:
            return self.roles.inside(patch.labels)
        return self.roles.body(patch.labels, self.labels[patch.component])

    @cached_property
    def overlaps(self) -> bool:
        """Whether parts of one class can lie over each other's contours."""
        return bool(self.compiled.like.any() or self.compiled.like_box.any())

    @cached_property
    def rigid_to_root(self) -> NDArray[np.bool_]:
        """(C,) other components of the rigid body that the required one is part of."""
        return self.kinematics.rigid_to(self.root)

    @cached_property
    def is_level(self) -> bool:
        """Whether all of each patch is at one depth where the object's z axis is the line of sight: planes across it,
        and joints about it, or that slide."""
        kin = self.kinematics
        tipped = kin.in_object(np.stack([kin.lower, kin.middle, kin.upper])).R[:, :, 2, :2]
        deep = [np.ptp(points[:, 2]) for p in self.patches for points in (p.finer, p.contour) if len(points)]
        return not self.sides.balls and max(*deep, float(np.abs(tipped).max())) < _SLIGHT * self.extent

    @cached_property
    def alike(self) -> NDArray[np.bool_]:
        """(P, P) patches that may be of one class."""
        return np.array([[bool(set(a.labels) & set(b.labels)) for b in self.patches] for a in self.patches])

    @cached_property
    def across(self) -> tuple[NDArray[np.int64], Tipped]:
        """See `tipped_markers`."""
        return tipped_markers(self)

    @cached_property
    def open_contour(self) -> NDArray[np.bool_]:
        """(M, m) contour points beyond which there is no other marker of the object."""
        return free_contour(self.model, self.patches, self.stack, own_class=False) & (self.meeting < 0)

    @cached_property
    def stand_apart(self) -> NDArray[np.bool_]:
        """(M,) markers beside none of which there is another one."""
        return np.asarray(self.open_contour.all(axis=1))

    @property
    def is_lone_marker(self) -> bool:
        """Whether the object has one marker: its own pixels alone tell how it lies."""
        return len(self.markers) == 1

    @cached_property
    def outward(self) -> Array:
        """(M, m, 3) unit normals of contours in their planes."""
        return np.asarray(np.cross(self.contour_along, self.normal[self.markers][:, None]), np.float64)

    @cached_property
    def stretch(self) -> Array:
        """(M, m) how many times as far from its marker's middle, along its normal, each contour point is as most are:
        so many times as far as these it moves where the marker grows."""
        far: Array = ((self.contour - self.centre[self.markers][:, None]) * self.outward).sum(axis=2)
        return far / np.maximum(np.median(far, axis=1, keepdims=True), 1e-9)

    @cached_property
    def solids(self) -> frozenset[int]:
        """See `convex_solids`."""
        return convex_solids(self.patches)

    @cached_property
    def sides(self) -> Sides:
        """What its sides are together."""
        return Sides(self)

    @cached_property
    def meeting(self) -> NDArray[np.int64]:
        """(M, m) see `meeting_contour`."""
        return meeting_contour(self.patches)

    def seams_px(self, field: LabelField, *, most: bool = False) -> Array:
        """(M,) half the width of the seam around each marker's class, see `LabelField.seams_px`, less by what markers
        look larger than they are."""
        seams: Array = field.seams_px(self.marker_labels, most=most)
        return seams - self.limits.swollen_px if self.limits.swollen_px else seams

    def swollen(self, by_px: float) -> SpatialModel:
        """The same with markers that look larger than they are, by so many pixels all around."""
        twin = copy(self)
        twin.limits, twin.edges_known = self.limits._replace(swollen_px=float(by_px)), {}
        return twin

    @property
    def no_poses(self) -> Poses:
        """None of this model's."""
        return Poses(np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros((0, self.kinematics.n_joints)))

    def place(self, frames: Frames, points: Array, component: np.ndarray) -> Array:
        """(H, n, 3) camera coordinates of (n, 3) points given on components (n,)."""
        out = np.empty((len(frames.R), len(points), 3))
        place_points(frames.R, frames.t, points, component, out)
        return out

    def shown(self, frames: Frames, patches: np.ndarray, points: int) -> np.ndarray:
        """(H, P, n) bool: which of the first `points` points of patches no box hides from the camera; said of patches
        that face it."""
        out = np.empty((len(frames.R), len(patches), points), bool)
        shown_points(self.compiled, frames.R, frames.t, patches, BEHIND, out)
        return out

    def shown_contour(self, poses: Poses, use: np.ndarray) -> NDArray[np.bool_]:
        """(H, M, m) which points of the contours of the markers in use (H, M) no box hides from the camera."""
        out = np.zeros((len(poses), len(self.markers), self.contour.shape[1]), bool)
        used, chain = np.ascontiguousarray(use), self.kinematics.chain
        shown_contours(self.compiled, chain, poses.R, poses.t, poses.q, used, BEHIND, out)
        return out

    def score(
        self,
        frame: ImageFrame,
        poses: Poses,
        patches: np.ndarray,
        *,
        occlusion: bool,
        covered: bool = False,
        rigid: bool = False,
    ) -> PatchScores:
        """What the labels say of each of `patches` (ascending indices) under each hypothesis.

        :param covered: with the object's other parts of their class in place around markers' contours.
        :param rigid: bodies hide only what is rigid to them: joints are not known.
        """
        R, t, q = poses.R, poses.t, poses.q
        out, view = PatchScores(*np.empty((3, len(R), len(patches)))), frame.view
        looked, surface = (occlusion, covered and self.overlaps), self._hidden_by_rigid if rigid else self.compiled
        score_patches(surface, self.kinematics.chain, R, t, q, patches, view, self.limits, *looked, *out.arrays)
        return out

    def there(self, frame: ImageFrame, poses: Poses) -> NDArray[np.bool_]:
        """(H, M) which markers are there: of those that lie on each other the one that the labels like best."""
        single = self.stack[self.markers] < 0
        if single.all():
            return np.ones((len(poses), len(single)), bool)
        return np.asarray(single | (self.score(frame, poses, self.markers, occlusion=True).area_px > 0))

    def search_joints(self, frame: ImageFrame, poses: Poses, grids: Array) -> Poses:
        """Each joint in its parents' order at the value, of its row of `grids` (J, n; NaN ends it), at which the labels
        like its component best; occlusion apart. At the deadline the rest stay as they are."""
        kin, R, t, q, view = self.kinematics, poses.R, poses.t, poses.q.copy(), frame.view
        for part in frame.deadline.parts(len(poses), _AT_ONCE):
            search_joints(
                self.compiled, kin.chain, *self.by_component, R[part], t[part], q[part], grids, view,
                self.limits,
            )  # fmt: skip
        return Poses(R, t, q)

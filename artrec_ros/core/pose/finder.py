"""Find whole spatial objects: pose and joints at once, judged by every pixel of their markers and bodies.

The paper's phase 1 finds the required component, phase 2 the others. Here the required component's pose in
space comes first, and another component must sit where its joint can carry it: a curve in place of a box.
What is found is refined on all contours together, and judged with the parts that hide each other.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..base.config import RecognizerConfig
from ..base.deadline import Deadline
from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.blobs import Blob, find_blobs
from ..image.image_frame import view_of
from ..image.label_field import LabelField
from ..model.target import Target
from . import climb_kernels as climbing
from .climb_kernels import Value
from .distinct import apart, best_distinct
from .pose_fit import contour_fit, refine
from .seeds import Seeds
from .surface_model import LIMITS, PatchScores, Poses, SpatialModel

JOINT_STEP, FIRST_JOINT_STEP = 0.15, 0.25  # of a joint's unit: of those sought, and of those sought first
FINE_REACH_PX = (4, 3, 3, 2, 2)
JOINT_KEEP, FIT_KEEP, FLIP_KEEP = 24, 8, 3  # hypotheses a blob that pass each stage
CLIMBS = ((10, 11, 1.5), (5, 13, 1.0), (3, 24, 0.7))  # hypotheses a blob, rounds, first step
PLAIN_CLIMB = (3, 13, 0.7)  # of an object beyond doubt
HOPELESS_VOTES = 40.0  # a candidate with fewer is not worth a climb
RIVAL = 0.8  # of a sure object's votes
HIDDEN_COST = 0.5  # votes per pixel that a component costs which should be seen and is not
SETTLED_VOTES = 0.85  # of a hypothesis' votes must be left after its last fit
# times a rotation: its mirror image in the marker's and in the image's plane
_MIRRORED = np.outer((1.0, 1.0, -1.0), (1.0, 1.0, -1.0))


class WholeObjectFinder:
    """Hypotheses of one target in a frame."""

    def __init__(self, target: Target) -> None:
        self.target = target
        self.surface = SpatialModel(target.model, target.label)
        self.root = self.surface.root
        self.root_label = self.surface.labels[self.root]
        self._value = Value(len(target.model.components), self.root, HIDDEN_COST, occlusion=True)
        markers = target.model.required.markers
        self._marker_turns = np.array([m.T_component_marker.rotation for m in markers if m.T_component_marker])
        self._marker_centres = np.array([m.centre for m in markers])
        self._seeds = Seeds(target, self.surface)

    def warm_up(self) -> None:
        """Have compiled code ready before the first image: search a small one that shows a patch of the class."""
        labels = np.zeros((48, 64), np.uint8)
        labels[16:32, 20:44] = self.root_label
        field, clock = LabelField(labels), Deadline()
        camera = Camera(np.diag([100.0, 100.0, 1.0]), np.zeros(0), (64, 48))
        for blob in find_blobs(labels, {self.root_label}, RecognizerConfig()):
            self.find_plain(field, camera, blob, clock, lambda _: True)
            self.find(field, camera, blob, clock, lambda _: False)
            poses = self._seeds.all(field, camera, blob, clock)[:1]  # maybe none: what is compiled need not run
            votes = self.votes(field, camera, poses, occlusion=True)
            self._climb(field, camera, *self._sweep(field, camera, poses, votes, clock), 1, 1.0, clock)
        kin, every = self.surface.kinematics, np.ones((1, len(self.surface.markers)), bool)
        ahead = Poses(np.eye(3)[None], np.array([[0.0, 0.0, 1.0]]), (kin.lower + kin.upper)[None] / 2)
        contour_fit(self.surface, field, camera, ahead, every, 1)
        frames, patches = kin.forward(ahead.R, ahead.t, ahead.q), self.surface.markers
        self.surface.place(frames, self.surface.centre[patches], self.surface.component[patches])
        self.surface.shown(frames, patches, 1)

    def find_plain(
        self, field: LabelField, camera: Camera, blob: Blob, deadline: Deadline, is_sure: Callable[[Poses], bool]
    ) -> Poses:
        """An object beyond doubt whose required component made a blob, by a few guesses, and its rivals, best first;
        none where there is doubt.

        :param is_sure: whether one hypothesis is such an object.
        """
        poses, votes = self._with_joints(field, camera, self._seeds.few(field, camera, blob, deadline), deadline)
        if not len(poses) or not is_sure(poses[:1]):
            return poses[:0]
        return self._raised(field, camera, poses, votes, PLAIN_CLIMB, True, deadline)[0]

    def find(
        self, field: LabelField, camera: Camera, blob: Blob, deadline: Deadline, is_sure: Callable[[Poses], bool]
    ) -> Poses:
        """Hypotheses of which a component made a blob, or part of one, best first."""
        poses, votes = self._with_joints(field, camera, self._seeds.all(field, camera, blob, deadline), deadline)
        sure = False
        for climb_of in CLIMBS:
            if deadline.expired or votes.max(initial=0.0) < HOPELESS_VOTES:
                break
            sure = sure or is_sure(poses[:1])
            if not sure or climb_of is CLIMBS[-1]:
                poses, votes = self._raised(field, camera, poses, votes, climb_of, sure, deadline)
        return poses

    def _raised(
        self,
        field: LabelField,
        camera: Camera,
        poses: Poses,
        votes: Array,
        climb_of: tuple[int, int, float],
        sure: bool,
        deadline: Deadline,
    ) -> tuple[Poses, Array]:
        """The best, or a sure object and its rivals, after one of the climbs."""
        count, rounds, spread = climb_of
        keep = (apart(poses, votes, RIVAL * votes[0]) if sure else np.flatnonzero(votes > 0))[:count]
        poses, votes = poses[keep], votes[keep]
        # a better pose may show a limb that a worse one missed
        poses = Poses.concatenate([poses, self.surface.search_joints(field, camera, poses, JOINT_STEP, deadline)])
        poses, votes = self._keep(poses, self.votes(field, camera, poses, occlusion=True), count)
        poses, votes = self._sweep(field, camera, poses, votes, deadline)
        poses, votes = self._with_rival_flips(field, camera, poses, votes, deadline)
        poses, votes = self._climb(field, camera, poses, votes, rounds, spread, deadline)
        poses, votes = self._fit_all(field, camera, poses, deadline)
        return self._keep(poses, votes, len(poses))

    def _with_joints(self, field: LabelField, camera: Camera, poses: Poses, deadline: Deadline) -> tuple[Poses, Array]:
        """The best with the joints at which the labels like the other components best, fitted to all contours."""
        poses = self.surface.search_joints(field, camera, poses, FIRST_JOINT_STEP, deadline)
        poses, votes = self._keep(poses, self.votes(field, camera, poses, occlusion=False), JOINT_KEEP)
        poses, votes = self._fit_all(field, camera, self._with_flips(poses, votes), deadline)
        return self._keep(poses, votes, FIT_KEEP)

    def _with_rival_flips(
        self, field: LabelField, camera: Camera, poses: Poses, votes: Array, deadline: Deadline
    ) -> tuple[Poses, Array]:
        """Add the best one's siblings that come near to it."""
        flips = self._with_flips(poses[:1], votes[:1])[1:]
        if not len(flips):
            return poses, votes
        flips, flip_votes = self._fit_all(field, camera, flips, deadline)
        flips, flip_votes = self._keep(flips, flip_votes, FLIP_KEEP)
        near = flip_votes > RIVAL * votes[0]
        return Poses.concatenate([poses, flips[near]]), np.concatenate([votes, flip_votes[near]])

    def _sweep(
        self, field: LabelField, camera: Camera, poses: Poses, votes: Array, deadline: Deadline
    ) -> tuple[Poses, Array]:
        """Joints at their best by the votes of the whole object, which know what hides what."""
        kin, view = self.surface.kinematics, view_of(field, camera)
        moved = poses.R.copy(), poses.t.copy(), poses.q.copy(), votes.copy()
        for j, grid in enumerate(kin.grids(JOINT_STEP)):
            if deadline.expired:
                break
            climbing.sweep(self.surface.compiled, kin.chain, view, LIMITS, self._value, j, grid, *moved)
        return Poses(*moved[:3]), moved[3]

    def _climb(
        self,
        field: LabelField,
        camera: Camera,
        poses: Poses,
        votes: Array,
        rounds: int,
        spread: float,
        deadline: Deadline,
    ) -> tuple[Poses, Array]:
        """Local search on the votes of the whole object: no hypothesis gets worse, and the clock ends it.

        :param spread: first steps, in the units of `climbing`.
        """
        kin, view = self.surface.kinematics, view_of(field, camera)
        focal = float(np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1]))
        moves = climbing.Moves(focal, kin.lower, kin.upper, kin.unit, kin.endless)
        moved = poses.R.copy(), poses.t.copy(), poses.q.copy(), votes.copy()
        steps, surface = np.full((len(poses), 6 + kin.n_joints), spread), self.surface.compiled
        for _ in range(rounds):
            if deadline.expired:
                break
            if not climbing.climb(surface, kin.chain, view, LIMITS, self._value, moves, steps, *moved):
                break
        return Poses(*moved[:3]), moved[3]

    def judge(self, field: LabelField, camera: Camera, poses: Poses, *, occlusion: bool) -> PatchScores:
        """What the labels say of every patch under each hypothesis."""
        return self.surface.score(field, camera, poses, np.arange(len(self.surface.patches)), occlusion=occlusion)

    def votes(self, field: LabelField, camera: Camera, poses: Poses, *, occlusion: bool) -> Array:
        """(H,) votes of whole objects; a component that speaks against itself counts as hidden, at a price."""
        surface, view, out = self.surface, view_of(field, camera), np.empty(len(poses))
        value = self._value._replace(occlusion=occlusion)
        R, t, q = poses.R, poses.t, poses.q
        climbing.votes_of(surface.compiled, surface.kinematics.chain, view, LIMITS, value, R, t, q, out)
        return out

    def total(self, scores: PatchScores) -> Array:
        """(H,) votes of whole objects from what is said of all their patches."""
        out = np.empty(len(scores.votes))
        climbing.totals(self.surface.compiled, self._value, scores.votes, scores.area_px, out)
        return out

    def same_place(self, camera: Camera, poses: Poses, one: Poses) -> np.ndarray:
        """(H,) bool: whose required component would cover that of `one` in the image."""
        roots = ((p, *self._root_frames(p)) for p in (poses, one))
        there, here = (_moved(p, R @ self.surface.anchor + t) for p, R, t in roots)
        f = np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1])
        radius = 0.6 * f * self.surface.extent / np.maximum(np.maximum(there[:, 2], here[:, 2]), 1e-6)
        distance_px = np.linalg.norm(project(camera, there) - project(camera, here), axis=1)
        return (distance_px < radius) | (distance_px == 0)  # behind the camera all is at one place

    def _root_frames(self, poses: Poses) -> tuple[Array, Array]:
        """The required component in the object's frame, (H, 3, 3), (H, 3), or (1, ...) where no joint carries it."""
        kin, n = self.surface.kinematics, len(poses)
        if kin.parent[self.root] < 0:
            return np.eye(3)[None], np.zeros((1, 3))
        frames = kin.forward(np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3)), poses.q)
        return frames.R[:, self.root], frames.t[:, self.root]

    def _with_flips(self, poses: Poses, votes: Array) -> Poses:
        """Add to the best their siblings: a flat marker's mirrored turn looks almost the same."""
        p = self._keep(poses, votes, FLIP_KEEP)[0]
        R_root, t_root = self._root_frames(p)
        R_object_marker = R_root @ self._marker_turns[:, None]  # (markers, H, 3, 3)
        centroid = (R_root @ self._marker_centres[:, None, :, None])[..., 0] + t_root
        R_marker, centre = p.R @ R_object_marker, (p.R @ centroid[..., None])[..., 0] + p.t
        facing = np.sum(R_marker[..., 2] * centre, axis=-1) < 0
        R = (_MIRRORED * R_marker) @ R_object_marker.swapaxes(-1, -2)
        t, q = centre - (R @ centroid[..., None])[..., 0], np.broadcast_to(p.q, (len(R), *p.q.shape))
        return Poses.concatenate([poses, Poses(R[facing], t[facing], q[facing])])

    def _fit_all(self, field: LabelField, camera: Camera, poses: Poses, deadline: Deadline) -> tuple[Poses, Array]:
        """Hypotheses and their fits to the contours of all markers that the labels support, with votes."""
        scores = self.judge(field, camera, poses, occlusion=True)
        fitted = refine(self.surface, field, camera, poses, self.supported(scores), FINE_REACH_PX, deadline=deadline)
        votes = np.concatenate([self.total(scores), self.votes(field, camera, fitted, occlusion=True)])
        return Poses.concatenate([poses, fitted]), votes

    def supported(self, scores: PatchScores) -> np.ndarray:
        """(H, M) markers that the labels support."""
        m = self.surface.markers
        return (scores.votes[:, m] > 0) & (scores.area_px[:, m] > 8) & (scores.agree[:, m] > 0.4)

    def settled(self, field: LabelField, camera: Camera, poses: Poses, used: np.ndarray) -> Poses:
        """Hypotheses at rest on the contours of the markers used (H, M), which are finer than the votes, but for those
        whose votes fall far."""
        fitted = refine(self.surface, field, camera, poses, used, FINE_REACH_PX)
        both = Poses.concatenate([poses, fitted])
        before, after = self.votes(field, camera, both, occlusion=True).reshape(2, -1)
        return both[np.arange(len(poses)) + len(poses) * (after > SETTLED_VOTES * before)]

    @staticmethod
    def _keep(poses: Poses, votes: Array, n: int) -> tuple[Poses, Array]:
        keep = best_distinct(poses, votes, n)
        return poses[keep], votes[keep]


def _moved(poses: Poses, points: Array) -> Array:
    """(H, 3) points (H, 3) of an object in the camera, each under its own hypothesis."""
    return np.asarray(np.einsum("hij,hj->hi", poses.R, points) + poses.t, np.float64)

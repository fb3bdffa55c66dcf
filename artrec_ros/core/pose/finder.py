"""Find whole spatial objects: pose and joints at once, judged by every pixel of their markers and bodies.

The paper's phase 1 finds the required component, phase 2 the others. Here the required component's pose in
space comes first, and another component must sit where its joint can carry it: a curve in place of a box.
What is found is refined on all contours together, and judged with the parts that hide each other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..model.target import Target
from . import climb_kernels as climbing
from .climb_kernels import Value
from .distinct import apart
from .pose_fit import fit_poses
from .ranked import Ranked
from .seeds import Seeds
from .surface_model import LIMITS, PatchScores, Poses, SpatialModel

JOINT_STEP, FIRST_JOINT_STEP = 0.15, 0.25  # of a joint's unit: of those sought, and of those sought first
FINE_REACH_PX = (4, 3, 3, 2, 2)
JOINT_KEEP, FIT_KEEP, FLIP_KEEP = 24, 8, 3  # hypotheses a blob that pass each stage
RIVAL = 0.8  # of a sure object's votes
HIDDEN_COST = 0.5  # votes per pixel that a component costs which should be seen and is not
SETTLED_VOTES = 0.85  # of a hypothesis' votes must be left after its last fit
# times a rotation: its mirror image in the marker's and in the image's plane
_MIRRORED = np.outer((1.0, 1.0, -1.0), (1.0, 1.0, -1.0))


class Climb(NamedTuple):
    """A climb on the votes: of at most so many hypotheses, so many rounds, the first steps in units of `climbing`."""

    most: int
    rounds: int
    first_step: float


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

    def warm_up(self, frame: ImageFrame, poses: Poses) -> None:
        """Have the compiled code that counts votes and climbs on them ready, by a step from some poses."""
        self.total(self.judge(frame, poses, occlusion=True))
        found = Ranked(poses, self.votes(frame, poses, occlusion=True))
        self._climb(frame, self._sweep(frame, found), Climb(1, 1, 1.0))

    def plain_guesses(self, frame: ImageFrame, blob: Blob) -> Ranked:
        """A few of an object in plain view whose required component made a blob; none where there can be no such."""
        return self._with_joints(frame, self._seeds.few(frame, blob))

    def guesses(self, frame: ImageFrame, blob: Blob) -> Ranked:
        """Hypotheses of which any component made a blob, or part of it."""
        return self._with_joints(frame, self._seeds.all(frame, blob))

    def climbed(self, frame: ImageFrame, found: Ranked, climb: Climb, *, sure: bool) -> Ranked:
        """The best, or of a sure object it and its rivals, after a climb on the votes and a fit to the contours."""
        keep = apart(found.poses, found.votes, RIVAL * found.votes[0]) if sure else np.flatnonzero(found.votes > 0)
        found = found[keep[: climb.most]]
        # a better pose may show a limb that a worse one missed
        bent = Poses.concatenate([found.poses, self.surface.search_joints(frame, found.poses, JOINT_STEP)])
        found = Ranked(bent, self.votes(frame, bent, occlusion=True)).best(climb.most)
        found = self._with_rival_flips(frame, self._sweep(frame, found))
        found = self._climb(frame, found, climb)
        return self._fit_all(frame, found.poses).best(len(found))

    def _with_joints(self, frame: ImageFrame, poses: Poses) -> Ranked:
        """The best with the joints at which the labels like the other components best, fitted to all contours."""
        poses = self.surface.search_joints(frame, poses, FIRST_JOINT_STEP)
        found = Ranked(poses, self.votes(frame, poses, occlusion=False)).best(JOINT_KEEP)
        return self._fit_all(frame, self._with_flips(found)).best(FIT_KEEP)

    def _with_rival_flips(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """Add the best one's siblings that come near to it."""
        flips = self._with_flips(found[:1])[1:]
        if not len(flips):
            return found
        fitted = self._fit_all(frame, flips).best(FLIP_KEEP)
        return found + fitted[fitted.votes > RIVAL * found.votes[0]]

    def _sweep(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """Joints at their best by the votes of the whole object, which know what hides what."""
        kin, moved = self.surface.kinematics, found.copied()
        for j, grid in enumerate(kin.grids(JOINT_STEP)):
            if frame.deadline.expired:
                break
            climbing.sweep(
                self.surface.compiled, kin.chain, frame.view, LIMITS, self._value, j, grid, *moved.arrays
            )  # fmt: skip
        return moved

    def _climb(self, frame: ImageFrame, found: Ranked, climb: Climb) -> Ranked:
        """Local search on the votes of the whole object: no hypothesis gets worse, and the clock ends it."""
        kin, moved, surface = self.surface.kinematics, found.copied(), self.surface.compiled
        moves = climbing.Moves(frame.camera.focal_px, kin.lower, kin.upper, kin.unit, kin.endless)
        steps = np.full((len(found), 6 + kin.n_joints), climb.first_step)
        for _ in range(climb.rounds):
            if frame.deadline.expired:
                break
            if not climbing.climb(
                surface, kin.chain, frame.view, LIMITS, self._value, moves, steps, *moved.arrays
            ):  # fmt: skip
                break
        return moved

    def judge(self, frame: ImageFrame, poses: Poses, *, occlusion: bool) -> PatchScores:
        """What the labels say of every patch under each hypothesis."""
        return self.surface.score(frame, poses, np.arange(len(self.surface.patches)), occlusion=occlusion)

    def votes(self, frame: ImageFrame, poses: Poses, *, occlusion: bool) -> Array:
        """(H,) votes of whole objects; a component that speaks against itself counts as hidden, at a price."""
        surface, view, out = self.surface, frame.view, np.empty(len(poses))
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
        radius = 0.6 * camera.focal_px * self.surface.extent / np.maximum(np.maximum(there[:, 2], here[:, 2]), 1e-6)
        distance_px = np.linalg.norm(project(camera, there) - project(camera, here), axis=1)
        return (distance_px < radius) | (distance_px == 0)  # behind the camera all is at one place

    def _root_frames(self, poses: Poses) -> tuple[Array, Array]:
        """The required component in the object's frame, (H, 3, 3), (H, 3), or (1, ...) where no joint carries it."""
        kin, n = self.surface.kinematics, len(poses)
        if kin.parent[self.root] < 0:
            return np.eye(3)[None], np.zeros((1, 3))
        frames = kin.forward(np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3)), poses.q)
        return frames.R[:, self.root], frames.t[:, self.root]

    def _with_flips(self, found: Ranked) -> Poses:
        """Add to the best their siblings: a flat marker's mirrored turn looks almost the same."""
        p = found.best(FLIP_KEEP).poses
        R_root, t_root = self._root_frames(p)
        R_object_marker = R_root @ self._marker_turns[:, None]  # (markers, H, 3, 3)
        centroid = (R_root @ self._marker_centres[:, None, :, None])[..., 0] + t_root
        R_marker, centre = p.R @ R_object_marker, (p.R @ centroid[..., None])[..., 0] + p.t
        facing = np.sum(R_marker[..., 2] * centre, axis=-1) < 0
        R = (_MIRRORED * R_marker) @ R_object_marker.swapaxes(-1, -2)
        t, q = centre - (R @ centroid[..., None])[..., 0], np.broadcast_to(p.q, (len(R), *p.q.shape))
        return Poses.concatenate([found.poses, Poses(R[facing], t[facing], q[facing])])

    def _fit_all(self, frame: ImageFrame, poses: Poses) -> Ranked:
        """Hypotheses and their fits to the contours of all markers that the labels support, with votes."""
        scores = self.judge(frame, poses, occlusion=True)
        fitted = fit_poses(self.surface, frame, poses, self.supported(scores), FINE_REACH_PX)
        votes = np.concatenate([self.total(scores), self.votes(frame, fitted, occlusion=True)])
        return Ranked(Poses.concatenate([poses, fitted]), votes)

    def supported(self, scores: PatchScores) -> np.ndarray:
        """(H, M) markers that the labels support."""
        m = self.surface.markers
        return (scores.votes[:, m] > 0) & (scores.area_px[:, m] > 8) & (scores.agree[:, m] > 0.4)

    def settled(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> Poses:
        """Hypotheses at rest on the contours of the markers used (H, M), which are finer than the votes, but for those
        whose votes fall far."""
        fitted = fit_poses(self.surface, frame, poses, used, FINE_REACH_PX)
        both = Poses.concatenate([poses, fitted])
        before, after = self.votes(frame, both, occlusion=True).reshape(2, -1)
        return both[np.arange(len(poses)) + len(poses) * (after > SETTLED_VOTES * before)]


def _moved(poses: Poses, points: Array) -> Array:
    """(H, 3) points (H, 3) of an object in the camera, each under its own hypothesis."""
    return np.asarray(np.einsum("hij,hj->hi", poses.R, points) + poses.t, np.float64)

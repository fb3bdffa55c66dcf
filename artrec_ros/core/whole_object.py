"""Find whole spatial objects: pose and joints at once, judged by every pixel of their markers and bodies.

The paper's phase 1 gives poses of the required component, its phase 2 the other components; here a
component must sit where its joint can carry it, which is a curve in place of a box. What is found is
refined on all contours together, and judged with the parts of the object that hide each other.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import cv2
import numpy as np

from .datatypes import Camera, Target
from .evidence import LabelField
from .posefit import Fit, refine
from .spatial import PatchScores, Poses, SpatialModel
from .transforms import Array
from .views import Guesses, View, align_view, blob_couples, lift, score_view, view_bank

GUESSES_PER_BLOB = 48
JOINT_STEP_RAD = 0.15
COARSE_GATES_PX = (8.0, 6.0, 4.0, 3.0)
FINE_GATES_PX = (4.0, 3.0, 2.5, 2.0, 2.0)
RING = 1.75
LEAST_AREA_PX = 14.0


@dataclass(frozen=True)
class Candidate:
    """One whole-object hypothesis with what the labels say of it.

    :param votes: total votes; :param component_votes, component_area: (C,) of each component's markers.
    """

    poses: Poses  # of one
    votes: float
    component_votes: Array
    component_area: Array
    component_agree: Array
    body_votes: float
    body_area: float
    information: Array


class WholeObjectFinder:
    """Hypotheses of one target in a frame."""

    def __init__(self, target: Target, erosion_px: float) -> None:
        self.target = target
        self.model = SpatialModel(target.model, target.label)
        self.erosion_px = erosion_px
        required = target.model.required
        self.root = target.model.components.index(required)
        self.banks: list[list[View]] = [view_bank(m) for m in required.markers]
        self.root_label = target.label if required.label is None else required.label

    # -- step 1: guesses of the required component's pose -------------------------------------------------

    def guess(self, field: LabelField, camera: Camera, contours: list[Array], areas: list[float]) -> Guesses:
        roles, required = self.model.roles, self.target.model.required
        table = self.model.table
        inside = table[roles.inside(self.root_label)]
        ring = table[roles.ring(self.root_label, required.body_label or 0)]
        parts: list[Guesses] = []
        for b, (contour, area) in enumerate(zip(contours, areas, strict=True)):
            tolerances = (1.0, 2.0) if area < 2000 else (1.5, 0.03 * float(np.sqrt(area)))
            couples = blob_couples(contour, tolerances)
            found = []
            for m, bank in enumerate(self.banks):
                for view in bank:
                    T = align_view(view, couples, contour, area, LEAST_AREA_PX)
                    if not len(T):
                        continue
                    s = score_view(view, T, field, inside, ring, RING)
                    best = np.argsort(-s)[:12]
                    R, t = lift(view, T[best], camera)
                    found.append((R, t, np.full(len(R), m), np.tile(s[best], 2)))
            if not found:
                continue
            R, t, m, s = (np.concatenate(x) for x in zip(*found, strict=True))
            keep = np.argsort(-s, kind="stable")[: GUESSES_PER_BLOB * 2]
            parts.append(Guesses(R[keep], t[keep], m[keep], np.full(len(keep), b), s[keep]))
        if not parts:
            return Guesses(np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros(0, int), np.zeros(0, int), np.zeros(0))
        return Guesses(*(np.concatenate([getattr(p, n) for p in parts]) for n in ("R", "t", "marker", "blob", "score")))

    def to_poses(self, g: Guesses) -> Poses:
        """The object's pose of which a marker's pose is known, joints in the middle of their ranges."""
        kin = self.model.kinematics
        R, t = np.empty_like(g.R), np.empty_like(g.t)
        for m, marker in enumerate(self.target.model.required.markers):
            T = marker.T_component_marker
            assert T is not None
            on = g.marker == m
            R[on] = g.R[on] @ T.rotation.T
            centroid = T.rotation[:, :2] @ marker.centroid + T.position
            t[on] = g.t[on] - R[on] @ centroid
        q = np.tile((kin.lower + kin.upper) / 2, (len(g), 1))
        return Poses(R, t, q)

    # -- step 2: joints ----------------------------------------------------------------------------------

    def search_joints(self, field: LabelField, camera: Camera, poses: Poses) -> Poses:
        """Each joint in its parents' order: the angle whose component the labels like best."""
        kin, model = self.model.kinematics, self.model
        for component in self.target.model.joint_components:
            c = self.target.model.components.index(component)
            j = kin.joint_of[c]
            n = max(3, int(np.ceil((kin.upper[j] - kin.lower[j]) / JOINT_STEP_RAD)) + 1)
            grid = np.linspace(kin.lower[j], kin.upper[j], n)
            q = np.repeat(poses.q, n, axis=0)
            q[:, j] = np.tile(grid, len(poses))
            frames = kin.forward(np.repeat(poses.R, n, axis=0), np.repeat(poses.t, n, axis=0), q)
            patches = np.flatnonzero(model.component == c)
            votes = model.score(field, camera, frames, patches, occlusion=False).votes.sum(axis=1).reshape(-1, n)
            best = poses.q.copy()
            best[:, j] = grid[votes.argmax(axis=1)]
            poses = replace(poses, q=best)
        return poses

    # -- step 3: judgement -------------------------------------------------------------------------------

    def judge(self, field: LabelField, camera: Camera, poses: Poses, *, occlusion: bool) -> PatchScores:
        frames = self.model.kinematics.forward(poses.R, poses.t, poses.q)
        return self.model.score(field, camera, frames, np.arange(len(self.model.patches)), occlusion=occlusion)

    def total(self, scores: PatchScores) -> Array:
        """(H,) votes of an object: markers that speak against themselves count as hidden, at a price."""
        model = self.model
        out = np.zeros(len(scores.votes))
        for c in range(len(self.target.model.components)):
            on = model.component == c
            v = scores.votes[:, on].sum(axis=1)
            out += v if c == self.root else np.maximum(v, -0.5 * scores.area_px[:, on & model.is_marker].sum(axis=1))
        return out

    def used_markers(self, scores: PatchScores) -> np.ndarray:
        """(H, M) markers that the labels support: those that the contours are fitted to."""
        m = self.model.markers
        ok = (scores.votes[:, m] > 0) & (scores.area_px[:, m] > 8) & (scores.agree[:, m] > 0.4)
        return ok

    def find(self, field: LabelField, camera: Camera, contours: list[Array], areas: list[float], log: dict | None = None) -> tuple[Poses, Array, PatchScores, Fit | None]:
        clock = time.perf_counter
        marks = [clock()]
        g = self.guess(field, camera, contours, areas)
        marks.append(clock())
        if not len(g):
            return Poses(np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros((0, 0))), np.zeros(0), None, None  # type: ignore
        poses = self.to_poses(g)
        root_markers = self.model.component[self.model.markers] == self.root
        use = np.tile(root_markers, (len(poses), 1))
        fit = refine(self.model, field, camera, poses, use, COARSE_GATES_PX, self.erosion_px, np.zeros((len(poses), self.model.kinematics.n_joints), bool))
        poses = Poses.concatenate([poses, fit.poses])
        blob = np.tile(g.blob, 2)
        marks.append(clock())
        frames = self.model.kinematics.forward(poses.R, poses.t, poses.q)
        root_patches = np.flatnonzero(self.model.component == self.root)
        s = self.model.score(field, camera, frames, root_patches, occlusion=False).votes.sum(axis=1)
        keep = _best_per_group(s, blob, 40)
        poses, blob = poses[keep], blob[keep]
        marks.append(clock())
        poses = self.search_joints(field, camera, poses)
        total = self.total(self.judge(field, camera, poses, occlusion=False))
        keep = _best_per_group(total, blob, 14)
        poses, blob = poses[keep], blob[keep]
        marks.append(clock())
        for _ in range(2):
            scores = self.judge(field, camera, poses, occlusion=True)
            fit = refine(self.model, field, camera, poses, self.used_markers(scores), FINE_GATES_PX, self.erosion_px)
            both = Poses.concatenate([poses, fit.poses])
            total = self.total(self.judge(field, camera, both, occlusion=True)).reshape(2, -1)
            poses = both[np.arange(len(poses)) + len(poses) * total.argmax(axis=0)]
        scores = self.judge(field, camera, poses, occlusion=True)
        total = self.total(scores)
        marks.append(clock())
        if log is not None:
            log["ms"] = [round(1e3 * d, 1) for d in np.diff(marks)]
            log["n"] = [len(g), len(poses)]
        return poses, total, scores, fit


def _best_per_group(score: Array, group: np.ndarray, n: int) -> np.ndarray:
    """Indices of the `n` best of each group, best first."""
    order = np.lexsort((-score, group))
    rank = np.arange(len(order)) - np.searchsorted(group[order], group[order])
    keep = order[rank < n]
    return keep[np.argsort(-score[keep], kind="stable")]


def blobs_of(labels: np.ndarray, label: int, least_px: int = 6) -> tuple[list[Array], list[float]]:
    mask = (labels == label).astype(np.uint8)
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    out, areas = [], []
    for c in contours:
        a = cv2.contourArea(c) + len(c) / 2 + 1
        if a >= least_px:
            out.append(c[::-1, 0].astype(float))
            areas.append(float(a))
    return out, areas

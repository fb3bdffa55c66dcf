"""Guesses of a spatial object's pose, from each blob that its required component may have made."""

from __future__ import annotations

import numpy as np

from .blobs import Blob
from .compiled.geometry import view_of
from .compiled.guessing import Template, best_alignments
from .compiled.jit import COMPILED
from .datatypes import Camera
from .evidence import LabelField
from .objects import ObjectModel
from .spatial import RING_PX, RING_WIDTH_PX, Poses, SpatialModel
from .transforms import Array
from .views import (
    View,
    align_view,
    blob_couples,
    lift,
    moment_alignments,
    moments_of,
    scale_range,
    score_view,
    view_bank,
)

VIEW_KEEP = 12  # alignments of a view with a blob that go on
BLOB_KEEP = 48  # alignments of a marker with a blob that go on
SMALL_PX = 200.0  # so small a blob tells little of its marker's shape, and a segmenter may have taken much of it
GROWTH = (1.0, 1.2, 1.45)
LEAST_AREA_PX = 14.0  # a marker smaller than this in the image decides nothing


class Guesser:
    """Aligns the required component's markers, from many sides, with blobs."""

    def __init__(self, model: ObjectModel, surface: SpatialModel, root_label: int) -> None:
        self._surface = surface
        self._root_label = root_label
        self._markers = model.required.markers
        self._banks: list[list[View]] = [view_bank(m) for m in self._markers]
        table = surface.table
        self._inside_votes = table[surface.roles.inside(root_label)]
        self._ring_votes = table[surface.roles.ring(root_label, model.required.body_label or 0)]

    def guess(self, field: LabelField, camera: Camera, blob: Blob) -> Poses:
        """Object poses from one blob, the best of each marker by the votes for it."""
        seam_px = field.seam_px(self._root_label)
        contour = blob.contour + seam_px * blob.normals
        area = blob.area_px + seam_px * len(contour)
        tolerances = (1.0, 2.0) if area < 2000 else (1.5, 0.03 * float(np.sqrt(area)))
        couples = blob_couples(contour, tolerances)
        small = is_small(blob)
        return Poses.concatenate(
            [self._of_marker(m, field, camera, couples, contour, area, small) for m in range(len(self._markers))]
        )

    def _of_marker(
        self,
        m: int,
        field: LabelField,
        camera: Camera,
        couples: tuple[Array, Array],
        contour: Array,
        area: float,
        small: bool,
    ) -> Poses:
        similarities, votes, turns = [], [], []
        for view in self._banks[m]:
            T, s = self._align(view, field, camera, couples, contour, area)
            similarities.append(T)
            votes.append(s)
            turns.append(np.tile([view.turn, view.direction], (len(T), 1)))
        s, turn, T = np.concatenate(votes), np.concatenate(turns), np.concatenate(similarities)
        grown = GROWTH if small else GROWTH[:1]
        T = np.concatenate([T * (1, 1, 1, g) for g in grown])
        turn = np.tile(turn, (len(grown), 1))
        R, t = lift(turn[:, 0], turn[:, 1], T, camera)
        found, score = self._to_object(m, R, t), np.tile(s, 2 * len(grown))
        return found[best_distinct(found, score, np.zeros(len(found), int), BLOB_KEEP * len(grown))]

    def _align(
        self,
        view: View,
        field: LabelField,
        camera: Camera,
        couples: tuple[Array, Array],
        contour: Array,
        area: float,
    ) -> tuple[Array, Array]:
        """The VIEW_KEEP best alignments of a view with a blob, and their votes."""
        inside, ring = self._inside_votes, self._ring_votes
        if not COMPILED:
            T = align_view(view, couples, contour, area, LEAST_AREA_PX)
            s = score_view(view, T, field, inside, ring, RING_PX)
            best = np.argsort(-s, kind="stable")[:VIEW_KEEP]
            return T[best], s[best]
        T, s = np.empty((VIEW_KEEP, 4)), np.empty(VIEW_KEEP)
        template = Template(
            view.anchors, view.inside, view.contour, view.contour_normal, view.area, view.perimeter,
            inside, ring, RING_PX, RING_WIDTH_PX,
        )  # fmt: skip
        limits = scale_range(view, area, LEAST_AREA_PX)
        best_alignments(
            *couples,
            moment_alignments(view, moments_of(contour), area),
            template,
            *limits,
            view_of(field, camera),
            T,
            s,
        )
        found = s > -np.inf
        return T[found], s[found]

    def _to_object(self, marker: int, R: Array, t: Array) -> Poses:
        """The object's pose of which a marker's rotation and centroid are known, joints mid-range."""
        kin = self._surface.kinematics
        T = self._markers[marker].T_component_marker
        assert T is not None  # the model is spatial
        rotation = R @ T.rotation.T
        centroid = T.rotation[:, :2] @ self._markers[marker].centroid + T.position
        return Poses(
            rotation, t.reshape(-1, 3) - rotation @ centroid, np.tile((kin.lower + kin.upper) / 2, (len(R), 1))
        )


def is_small(blob: Blob) -> bool:
    """Whether a blob's shape tells little of its marker."""
    return blob.area_px < SMALL_PX


def best_distinct(poses: Poses, score: Array, group: np.ndarray, n: int) -> np.ndarray:
    """Indices of the `n` best hypotheses of each group that differ from each other, best first."""
    order = np.argsort(-score, kind="stable")
    _, first = np.unique(np.column_stack([group, pose_cells(poses)])[order], axis=0, return_index=True)
    order = order[np.sort(first)]  # the best of each cell, best first
    order = order[np.argsort(group[order], kind="stable")]
    rank = np.arange(len(order)) - np.searchsorted(group[order], group[order])
    keep = order[rank < n]
    return keep[np.argsort(-score[keep], kind="stable")]


def pose_cells(poses: Poses) -> np.ndarray:
    """(H, 9) integers, equal for hypotheses that refinement would bring to one place: about 0.7 degrees
    across the view, 6 % of depth, 12 degrees of turn."""
    depth = np.maximum(poses.t[:, 2:], 1e-6)
    place = np.column_stack([poses.t[:, :2] / depth / 0.012, np.log(depth) / 0.06])
    return np.rint(np.column_stack([place, poses.R[:, :, 0] / 0.2, poses.R[:, :, 2] / 0.2])).astype(int)

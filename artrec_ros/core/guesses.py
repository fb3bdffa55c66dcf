"""Guesses of a spatial object's pose, from each blob that its required component may have made."""

from __future__ import annotations

import numpy as np

from .bank import Bank, BlobShape, blob_shape
from .blobs import Blob
from .datatypes import Camera
from .distinct import best_distinct
from .evidence import LabelField
from .objects import ObjectModel
from .spatial import Poses, SpatialModel
from .transforms import Array
from .views import lift, view_bank

BLOB_KEEP = 48  # poses of a marker from a blob that go on
ENOUGH = 2  # alignments for each of them: some are the same pose
SMALL_PX = 200.0  # so small a blob tells little of its marker's shape, and a segmenter may have taken much of it
GROWTH = (1.0, 1.2, 1.45)


class Guesser:
    """Aligns the required component's markers, from many sides, with blobs."""

    def __init__(self, model: ObjectModel, surface: SpatialModel, root_label: int) -> None:
        self._surface = surface
        self._root_label = root_label
        self._markers = model.required.markers
        inside = surface.table[surface.roles.inside(root_label)]
        ring = surface.table[surface.roles.ring(root_label, model.required.body_label or 0)]
        self._banks = [Bank(view_bank(m), inside, ring) for m in self._markers]

    def guess(self, field: LabelField, camera: Camera, blob: Blob) -> Poses:
        """Object poses from one blob, the best of each marker by the votes for it."""
        shape = blob_shape(blob, field.seam_px(self._root_label))
        grown = GROWTH if is_small(blob) else GROWTH[:1]
        return Poses.concatenate([self._of_marker(m, field, camera, shape, grown) for m in range(len(self._markers))])

    def _of_marker(
        self, m: int, field: LabelField, camera: Camera, shape: BlobShape, grown: tuple[float, ...]
    ) -> Poses:
        bank = self._banks[m]
        T, s, view = bank.align(field, camera, shape)
        best = np.argsort(-s, kind="stable")[: ENOUGH * BLOB_KEEP]
        T, s, view = T[best], s[best], view[best]
        T, view = np.concatenate([T * (1, 1, 1, g) for g in grown]), np.tile(view, len(grown))
        R, t = lift(bank.flips[:, view], T, camera)
        found, score = self._to_object(m, R, t), np.tile(s, 2 * len(grown))
        return found[best_distinct(found, score, BLOB_KEEP * len(grown))]

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

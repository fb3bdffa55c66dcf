"""What pixels say of components that may be of several classes: which identity they show, and whether they show one."""

from __future__ import annotations

import numpy as np

from ..base.config import VerdictConfig
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.codes import Codes
from ..image.image_frame import ImageFrame
from ..model.identities import identities_of
from ..model.surface import INSIDE_POINTS
from .surface_model import Poses, SpatialModel


class Alternatives:
    """Those of one object."""

    def __init__(self, surface: SpatialModel, config: VerdictConfig) -> None:
        self._surface = surface
        model, self.identities, self.unique = surface.model, identities_of(surface.model), surface.model.unique
        rows = [
            row for row, p in enumerate(surface.markers.tolist())
            if model.components[surface.patches[p].component].classes
        ]  # fmt: skip
        components = [surface.patches[surface.markers[row]].component for row in rows]
        names = [model.components[c] for c in components]
        self._labels = np.array(
            [[c.classes[identity.classes[c.name]] for c in names] for identity in self.identities], int
        ).reshape(len(self.identities), len(rows))  # (N, M) the label of each marker under each identity
        self._patches = surface.markers[rows]
        inside = [surface.patches[p].inside for p in self._patches]
        self._points = np.concatenate([np.zeros((0, 3)), *inside])
        self._on = np.repeat(np.array(components, int), INSIDE_POINTS)
        self._says = _says(surface.codes, config.identity_floor)

    def evidence(self, frame: ImageFrame, poses: Poses) -> Array:
        """(H, N) log-likelihood of all pixels on the components under each identity, as if each told by itself."""
        out = np.zeros((len(poses), len(self.identities)))
        for m, (labels, by_class) in enumerate(self._by_marker(frame, poses)):
            out += by_class[:, np.searchsorted(labels, self._labels[:, m])]
        return out

    def contradicted(self, frame: ImageFrame, poses: Poses) -> Array:
        """(H,) by how much pixels on the components are likelier with each of the classes that they show best than
        under any identity, as logarithm: an object turned otherwise than it lies may show one that does not exist."""
        if not self.identities or not len(poses):
            return np.zeros(len(poses))
        free, bound = np.zeros(len(poses)), np.zeros((len(poses), len(self.identities)))
        for m, (labels, by_class) in enumerate(self._by_marker(frame, poses)):
            free += by_class.max(axis=1)
            bound += by_class[:, np.searchsorted(labels, self._labels[:, m])]
        return np.asarray(free - bound.max(axis=1))

    def _by_marker(self, frame: ImageFrame, poses: Poses) -> list[tuple[Array, Array]]:
        """Of each marker its classes' labels, ascending, and (H, classes) how likely its pixels are with each."""
        surface = self._surface
        frames = surface.kinematics.forward(poses.R, poses.t, poses.q)
        X = surface.place(frames, self._points, self._on)
        shown = surface.shown(frames, self._patches, INSIDE_POINTS)  # (H, M, points)
        codes = frame.field.at(project(frame.camera, X)).reshape(shown.shape)
        area_px = surface.area[self._patches] * (frame.camera.focal_px / X[:, ::INSIDE_POINTS, 2]) ** 2  # (H, M)
        out = []
        for m, column in enumerate(self._labels.T):
            labels = np.unique(column)
            says = self._says[labels][:, codes[:, m]]  # (classes, H, points)
            out.append((labels, ((says * shown[:, m]).mean(axis=2) * area_px[:, m]).T))
        return out


def _says(codes: Codes, floor: float) -> Array:
    """(256 labels, 256 codes) log-likelihood of a code on a marker of a label, up to a constant."""
    return np.log(np.maximum(codes.share.T, floor))

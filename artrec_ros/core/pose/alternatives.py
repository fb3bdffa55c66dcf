"""What pixels say of components that may be of several classes: which identity they show, and whether they show one."""

from __future__ import annotations

import numpy as np

from ..base.config import VerdictConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..model.identities import identities_of
from .alternatives_kernels import likelihoods
from .surface_model import Poses, SpatialModel


class Alternatives:
    """Those of one object.

    :ivar unique: whether each identity occurs once at most. :ivar components: that tell identities, by their index.
    """

    def __init__(self, surface: SpatialModel, config: VerdictConfig) -> None:
        self._surface = surface
        model, self.identities, self.unique = surface.model, identities_of(surface.model), surface.model.unique
        of_patch = [(p, model.components[surface.patches[p].component]) for p in surface.markers.tolist()]
        several = [(p, component) for p, component in of_patch if component.classes]
        self._patches = np.array([p for p, _ in several], np.int64)
        self.components = frozenset(c for c, component in enumerate(model.components) if component.classes)
        shown = [[c.classes[identity.classes[c.name]] for _, c in several] for identity in self.identities]
        labels = [sorted(set(column)) for column in zip(*shown, strict=True)]
        # (N, M) which of a marker's labels it has under each identity
        self._which = np.array([[own.index(v) for own, v in zip(labels, row, strict=True)] for row in shown], int)
        self._which = self._which.reshape(len(self.identities), len(several))
        log_share = np.log(np.maximum(surface.codes.share.T, config.identity_floor))  # (256 labels, 256 codes)
        most = max(map(len, labels), default=0)
        self._says = np.full((len(several), most, log_share.shape[1]), -np.inf)
        for m, own in enumerate(labels):
            self._says[m, : len(own)] = log_share[own]

    def evidence(self, frame: ImageFrame, poses: Poses) -> Array:
        """(H, N) log-likelihood of all pixels on the components under each identity, as if each told by itself."""
        return self._of_identities(self._by_class(frame, poses))

    def contradicted(self, frame: ImageFrame, poses: Poses) -> Array:
        """(H,) by how much pixels on the components are likelier with the class of each that they show best than under
        any identity, as logarithm: an object turned otherwise than it lies may show one that does not exist. 0 where
        no identities are declared: then all exist."""
        if not self._surface.model.identities or not len(poses):
            return np.zeros(len(poses))
        by_class = self._by_class(frame, poses)
        return np.asarray(by_class.max(axis=2).sum(axis=1) - self._of_identities(by_class).max(axis=1))

    def _of_identities(self, by_class: Array) -> Array:
        """(H, N) under each identity, from (H, M, classes)."""
        out = np.zeros((len(by_class), len(self.identities)))
        for m, which in enumerate(self._which.T):
            out += by_class[:, m, which]
        return out

    def _by_class(self, frame: ImageFrame, poses: Poses) -> Array:
        """(H, M, classes) how likely the pixels of each marker are with each of its classes."""
        out, s = np.empty((len(poses), *self._says.shape[:2])), self._surface
        likelihoods(
            s.compiled, s.kinematics.chain, poses.R, poses.t, poses.q, self._patches, self._says, frame.view, s.limits,
            out,
        )  # fmt: skip
        return out

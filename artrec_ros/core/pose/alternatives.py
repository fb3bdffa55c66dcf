"""What pixels say of components that may be of several classes: which identity they show, and whether they show one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.config import VerdictConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..model.found import SURE
from ..model.identities import identities_of
from .alternatives_kernels import likelihoods
from .poses import Poses
from .surface_model import SpatialModel

_LEAST = 1e-12  # rest of a share that rounds to all


class Reading(NamedTuple):
    """What pixels on the components of H objects say.

    :param evidence: (H, N) log-likelihood under each identity, against that of the class that each marker shows best:
        elsewhere other pixels are seen, and fewer are no likelier.
    :param listed: (H,) log odds that each object is one of these.
    :param shown: (H, M) which class of the palette each marker shows best; -1 where none of it is seen.
    """

    evidence: Array
    listed: Array
    shown: NDArray[np.int64]


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
        # another of its kind may show any of these anywhere
        labels = {label for _, c in several for label in (*c.classes.values(), *c.unborne.values())}
        palette = sorted(label for label in labels if label is not None)
        named = [{v: k for k, v in (*c.classes.items(), *c.unborne.items())} for _, c in several]
        self._names = [[own.get(label, "") for label in palette] for own in named]
        markers = ((surface.patches[p].marker, c) for p, c in several)
        self._markers = [(c.name, "" if marker is None else marker.name) for marker, c in markers]
        shown = [[c.classes[i.classes[c.name]] for _, c in several] for i in self.identities]
        # (N, M) which of the palette a marker has under each identity
        self._which = np.searchsorted(palette, np.array(shown, np.int64).reshape(len(self.identities), len(several)))
        self._different, self._combinations = np.unique(self._which, axis=0), float(len(palette)) ** len(several)
        log_share = np.log(np.maximum(surface.codes.share.T, config.identity_floor))  # (256 labels, 256 codes)
        self._says = np.tile(log_share[palette], (len(several), 1, 1))
        self._independent, self._misread = config.identity_independent, config.misread

    def read(self, frames: Sequence[ImageFrame], poses: Poses) -> Reading:
        """What the pixels of H poses say. :param frames: in which each is read."""
        by_class, rows = np.empty((len(poses), *self._says.shape[:2])), dict[int, list[int]]()
        for row, frame in enumerate(frames):
            rows.setdefault(id(frame), []).append(row)
        for mine in rows.values():
            by_class[mine] = self._by_class(frames[mine[0]], poses[mine])
        by_class *= self._independent
        shown = np.full(by_class.shape[:2], -1)
        if by_class.size:
            shown = np.where((by_class != 0).any(axis=2), by_class.argmax(axis=2), shown)
            by_class -= by_class.max(axis=2, keepdims=True)
        return Reading(self._of_identities(by_class), self._listed(by_class), shown)

    def shows(self, shown: NDArray[np.int64]) -> dict[tuple[str, str], str]:
        """The short name of the class that each component's marker shows, by both their names; those that show another
        one's class, or none, are left out.

        :param shown: (M,) as of `Reading`.
        """
        each = zip(self._markers, self._names, shown.tolist(), strict=False)
        return {marker: names[n] for marker, names, n in each if n >= 0 and names[n]}

    def _listed(self, by_class: Array) -> Array:
        """(H,) logarithms of the odds that what is seen is one of the declared identities, and not another combination
        of classes: these are all as likely as each other, and some object in fifty is of one that is not declared. As
        many components show another class than theirs, any of all, for a light on them or what lies over them; else one
        of many would be as good as all.

        :param by_class: (H, M, classes) against the best of each marker.
        """
        n = len(self._different)
        if not by_class.size or n >= self._combinations:
            return np.full(len(by_class), SURE)
        declared = by_class[:, np.arange(by_class.shape[1]), self._different]  # (H, n, M)
        every = np.logaddexp.reduce(by_class, axis=2).sum(axis=1)  # of all combinations together
        share = np.exp(np.minimum(np.logaddexp.reduce(declared.sum(axis=2), axis=1) - every, 0.0))
        others = every + np.log(np.maximum(1 - share, _LEAST)) - math.log(self._combinations - n)
        any_class = self._misread * np.exp(by_class).mean(axis=2)[:, None]
        some_misread = np.log((1 - self._misread) * np.exp(declared) + any_class).sum(axis=2)
        one = np.logaddexp.reduce(some_misread, axis=1) - math.log(n)
        return np.minimum(one - others + math.log((1 - self._misread) / self._misread), SURE)

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
        if s.stacks:
            out[~s.there(frame, poses)[:, np.isin(s.markers, self._patches)]] = 0.0
        return out

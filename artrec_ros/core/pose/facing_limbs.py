"""First hypotheses of objects that face the camera from the blobs of their other components.

Where the required component's blob is one with others of its class, its outline tells little of where it is; the limbs
that it carries may be plain. Each lies where it does in the image, and the joints that carry it may be bent in any way.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.range_limits import ScaleLimits
from ..geometry.transforms import Array
from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..model.objects import ObjectModel
from .facing_guesses import FacingGuesser
from .poses import Poses
from .ranked import first_of_each
from .surface_model import SpatialModel


class FacingLimbs:
    """Lays the components other than the required one on blobs, as `FacingGuesser` does, where they lead to the object.

    Those of a rigid one with its required component in view do so seldom where that does not, and cost as much time as
    all the rest: they have no joints that hide where it is, and are judged with it wherever it is tried.

    :ivar labels: classes of their blobs; none of a rigid object whose required component must be seen.
    """

    def __init__(self, model: ObjectModel, surface: SpatialModel, config: RecognizerConfig) -> None:
        self._surface, self._config = surface, config.facing
        leads = surface.kinematics.n_joints > 0 or config.required == "visible"
        others = [c for c in range(len(model.components) * leads) if c != surface.root]
        self._guessers = {c: FacingGuesser(model, surface, config, c) for c in others}
        self._patches = {c: np.flatnonzero(np.isin(surface.component, (c, surface.root))) for c in others}
        self.labels = {label for c in others for label in surface.labels[c]}

    def guess(self, frame: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits) -> tuple[Poses, NDArray[np.int64]]:
        """The best of each blob by the votes for a limb that may have made it and for the required component, and of
        which blob each is (H,)."""
        found, votes, of = [self._surface.no_poses], [np.zeros(0)], [np.zeros(0, np.int64)]
        if not len(blobs):
            return found[0], of[0]
        for c, guesser in self._guessers.items():
            mine = np.array([n for n, b in enumerate(blobs) if b.label in guesser.labels], np.int64)
            if not len(mine) or frame.deadline.expired:
                continue
            poses, first, blob = guesser.guess(frame, [blobs[n] for n in mine], limits)
            best = first_of_each(blob, first, self._config.limb_guesses)
            # a grid is coarse, and what it is off at a limb's end is more at the other end of the object
            fitted = guesser.fitted(frame, poses[best])
            found.append(guesser.bends.of(fitted))
            votes.append(self._votes(frame, found[-1], c))
            of.append(np.repeat(mine[blob[best]], len(guesser.bends)))
        every, group = Poses.concatenate(found), np.concatenate(of)
        kept = first_of_each(group, np.concatenate(votes), self._config.limb_keep)
        return every[kept], group[kept]

    def _votes(self, frame: ImageFrame, poses: Poses, component: int) -> Array:
        """(H,) for a limb and the required component, occlusion apart."""
        scores = self._surface.score(frame, poses, self._patches[component], occlusion=False)
        return np.asarray(scores.votes.sum(axis=1))

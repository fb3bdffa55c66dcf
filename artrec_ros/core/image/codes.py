"""What a pixel's code says of its class: one class for sure, or shares of two where its colour leaves a doubt.

A label image's codes are its labels. A colour image's are numbers of pairs of classes with a share of the first, so
that a mixed or shaded pixel says little instead of something wrong, at the price of the same one look-up.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array, readonly

OUTSIDE = 255  # the code and label of what lies beyond the image: says nothing
OWNED = 254  # of pixels that an accepted object explains: says next to nothing
EMPTY = 253  # of unknown pixels with nothing known around: no seam between colours, no speckled shade
UNKNOWN = 0


@dataclass(frozen=True, eq=False)
class Codes:
    """The meaning of codes.

    :param label: (256,) uint8, the class of each code where one must be named.
    :param share: (256, 256) how far each code is of each class; rows add up to 1.
    """

    label: NDArray[np.uint8]
    share: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "share", readonly(self.share))
        own = np.arange(EMPTY, OUTSIDE + 1)
        assert (self.label[own] == own).all() and (self.share[own, own] == 1).all()

    @cached_property
    def unknown(self) -> NDArray[np.bool_]:
        """(256,) codes that are unknown for sure."""
        return (self.label == UNKNOWN) & (self.share[:, UNKNOWN] == 1)

    def votes(self, of_labels: Array) -> Array:
        """(..., 256) votes of codes from those of labels (..., 256): the mean of what a pixel may be."""
        return np.asarray(of_labels @ self.share.T, np.float64)


LABELS = Codes(np.arange(256, dtype=np.uint8), np.eye(256))  # of label images

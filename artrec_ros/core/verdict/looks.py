"""What was seen of the candidates of one frame while its pixels were shared out.

Where some more come the pixels are shared out again, and as long as the same owners have taken theirs, all that the
others showed they show again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..image.label_field import LabelField
from ..pose.finder import WholeObjectFinder
from ..pose.poses import Poses
from .verdicts import Verdicts


class Owner(NamedTuple):
    """Who took pixels: the hypothesis `row` of some poses, by their number, and by how much wider than it is."""

    poses: int
    row: int
    wider_px: float


Owners = tuple[Owner, ...]  # in the order in which they took them
Judged = tuple[Verdicts, Array]  # and what each is worth


class Looks:
    """Those of one frame."""

    def __init__(self) -> None:
        self._judged: dict[tuple[Owners, int, int, bytes], Judged] = {}
        self._left: dict[Owners, LabelField] = {}
        self._poses: list[Poses] = []  # while these are there none else has their numbers

    def at(
        self,
        owners: Owners,
        finder: WholeObjectFinder,
        poses: Poses,
        rows: NDArray[np.int64],
        look: Callable[[], Judged],
    ) -> Judged:
        """Verdicts on some of a target's poses. :param look: makes them where none are known."""
        key = owners, id(finder), id(poses), rows.tobytes()
        if key not in self._judged:
            self._judged[key] = look()
            self._poses.append(poses)
        return self._judged[key]

    def left(
        self, owners: Owners, frame: ImageFrame, solids: Callable[[], Sequence[NDArray[np.float32]]]
    ) -> ImageFrame:
        """A frame without the pixels of the last owners too. :param solids: their silhouettes, as of `without`."""
        if owners not in self._left:
            self._left[owners] = frame.without(solids()).field
        return frame.labelled(self._left[owners])

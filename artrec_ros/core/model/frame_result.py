"""What one frame gives: objects, and what was turned down, with reasons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .found import Detection


@dataclass(frozen=True)
class ConstraintFailure:
    """The dimension in which a learned constraint fails most.

    :param first, second: COMPONENT/MARKER. :param dimension: as in constraint files; its name ends in its unit.
    :param low, high: what is allowed; outside: how far beyond it the value lies, its noise allowed for.
    """

    first: str
    second: str
    dimension: str
    value: float
    low: float
    high: float
    outside: float


@dataclass(frozen=True)
class Rejection:
    """A candidate that became no object, or no part of one, and why.

    :param failed: the constraint that fails by the least, where one does.
    """

    object: str
    reason: str
    score: float = 0.0
    x: float = 0.0
    y: float = 0.0
    failed: ConstraintFailure | None = None


@dataclass(frozen=True)
class StageResult:
    """What one stage of the method finds in one image.

    :param rejected, doubtful: as of `FrameResult`.
    """

    detections: tuple[Detection, ...] = ()
    rejected: Sequence[Rejection] = ()
    doubtful: Sequence[Detection] = ()


@dataclass(frozen=True)
class FrameResult:
    """All that was recognised in one image.

    :param rejected: worked out when it is first looked at.
    :param doubtful: candidates that are not probable enough to be told: what is known from frames before may go on in
        one. Worked out when it is first looked at.
    :param ended_by: the limits that ended the search early, by the parameters' names.
    :param waiting: blobs that were searched in an earlier frame, and wait their turn to be searched again.
    :param blobless: no blob was left to look at; `rejected` says why, where there was something to see.
    :param timing_ms: milliseconds per stage: segmentation, blobs, alignment, grouping, pose, total.
    """

    size: tuple[int, int]
    detections: tuple[Detection, ...] = ()
    rejected: Sequence[Rejection] = ()
    timing_ms: dict[str, float] = field(default_factory=dict)
    ended_by: tuple[str, ...] = ()
    labels: NDArray[np.uint8] | None = field(default=None, repr=False, compare=False)
    waiting: int = 0
    blobless: bool = False
    doubtful: Sequence[Detection] = field(default=(), repr=False, compare=False)

    @property
    def complete(self) -> bool:
        """Whether no limit ended the search early."""
        return not self.ended_by

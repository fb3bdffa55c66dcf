"""Room `image`: the seams of unknown pixels that a segmenter leaves around classes."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param

_EDGES = ("plane", "space", "facing")


@dataclass(frozen=True)
class SeamsConfig(Room):
    """How a class' seam is measured: from its border to the next pixel of another known class."""

    reach_px: float = param(
        4.0,
        "a seam is no wider",
        unit="px",
        low=1,
        high=20,
        paths=_EDGES,
        origin="segmenters leave two pixels where colours blend",
    )
    border_share: float = param(
        0.2,
        "least share of a class' border that must have another known class in reach, for it to have a seam",
        low=0,
        high=1,
        paths=_EDGES,
        origin="less is a neighbour that happens to be near",
    )
    clear_share: float = param(
        0.5,
        "more than this share is a seam's for sure; of less the borders of all classes decide: what is near may be a "
        "neighbour across a gap",
        low=0,
        high=1,
        paths=_EDGES,
        origin="of robots seen from above, patches with gaps between them .1 to .4, where labels leave seams .6 to 1",
    )
    all_share: float = param(
        0.3,
        "the same share of all classes' borders together, without which the segmenter of a label image leaves no seams",
        low=0,
        high=1,
        paths=_EDGES,
        origin="recorded segmentations of quadrupeds .33 to .8, robots with gaps between their patches .06 to .26",
    )

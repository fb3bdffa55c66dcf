"""Room `alignment`: outlines on contours."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ConfigError
from .params import Room, param

_PLANE = ("plane",)


@dataclass(frozen=True)
class AlignmentConfig(Room):
    """How a marker's outline is laid on contours: proposed, counted, thinned out, refined."""

    couple_spans: tuple[int, ...] = param(
        (1, 2),
        "couples are anchors so many places apart along the contour; the paper's are consecutive: 1",
        low=1,
        high=5,
        paths=_PLANE,
        origin="1 as published; 2 survives a false anchor between two true ones",
    )
    tolerance_px: float = param(
        2.0,
        "a point this near to the contour matches it",
        unit="px",
        low=0.5,
        high=20,
        paths=_PLANE,
        origin="as published",
    )
    tolerance_share: float = param(
        0.08,
        "small shapes: tolerance as a share of the root of the shape's area, not below 1 px",
        low=0,
        high=1,
        paths=_PLANE,
        origin="2 px at a shape of 25 px, as published; in proportion below, where 2 px would fit anything",
    )
    min_area_ratio: float = param(
        0.03,
        "least area of a shape relative to its blob (merged blobs)",
        low=0,
        high=1,
        paths=_PLANE,
        origin="a leg's marker in a blob that merged with a body's",
    )
    max_area_ratio: float = param(
        3.0,
        "greatest area of a shape relative to its blob (split blobs)",
        low=1,
        high=100,
        paths=_PLANE,
        origin="a blob that shade or another object robs of two thirds",
    )
    coarse_step: int = param(
        6,
        "the first pass looks up every so many-th of a shape's 120 points",
        low=1,
        high=40,
        paths=_PLANE,
        origin="20 points tell 0.4 from less well enough to sort out nine in ten",
    )
    coarse_match: float = param(
        0.4,
        "least share that must match in the first pass",
        low=0,
        high=1,
        paths=_PLANE,
        origin="the published threshold",
    )
    coarse_keep: int = param(
        200,
        "hypotheses a blob and shape that pass to the full count",
        low=1,
        high=10000,
        paths=_PLANE,
        origin="bounds the time of ragged blobs",
    )
    refine_keep: int = param(
        24,
        "hypotheses a blob and shape that are refined",
        low=1,
        high=1000,
        paths=_PLANE,
        origin="bounds the time; merged blobs hold up to four markers of a shape",
    )
    refine_steps: int = param(
        6,
        "steps of robust least squares",
        low=1,
        high=50,
        paths=_PLANE,
        origin="the gates narrow from 8 to 1.5 px in steps of a factor 1.4",
    )
    max_refined_scale: float = param(
        1.4,
        "greatest factor by which refinement may change a scale",
        low=1,
        high=10,
        paths=_PLANE,
        origin="hypotheses from anchors are within a fifth; more means that it slid to another contour",
    )
    min_visible: float = param(
        0.6,
        "least share of a shape's outline inside the image",
        low=0,
        high=1,
        paths=_PLANE,
        origin="below, the rest of an outline fits straight edges anywhere",
    )
    same_start: float = param(
        0.12,
        "hypotheses closer than this share of the shape's radius are refined as one",
        low=0,
        high=1,
        paths=("plane", "paper"),
        origin="refinement brings both to one place from there",
    )
    same_place: float = param(
        0.04,
        "refined poses closer than this share of the shape's radius are one instance",
        low=0,
        high=1,
        paths=_PLANE,
        origin="twice the scatter of refined poses",
    )
    max_instances: int = param(
        150,
        "instances of a shape and class that are carried on, the best",
        low=1,
        high=5000,
        paths=("plane", "paper"),
        origin="bounds the time of grouping",
    )
    symmetry_px: float = param(
        0.3,
        "turns that move the outline by less cannot be told apart",
        unit="px",
        low=0,
        high=10,
        paths=("plane", "space"),
        origin="half the noise of a contour's place, over a whole outline",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.couple_spans:
            raise ConfigError("expert.alignment.couple_spans: none is given; one or more are needed")

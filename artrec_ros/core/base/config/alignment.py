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
    anchor_share: float = param(
        0.02,
        "tolerance of the polygonal approximation that gives a shape its anchors, as a share of the root of its area",
        low=0,
        high=0.5,
        paths=("plane", "paper"),
        origin="outlines are drawn exactly: only what no image shows goes",
    )
    whole_ways: int = param(
        12,
        "ways in which a shape's whole outline is laid on a blob's whole contour, the best",
        low=1,
        high=60,
        paths=_PLANE,
        origin="a shape may all but repeat itself so often; of turned and scaled shapes four find as many, no faster",
    )
    arc_spans: tuple[float, ...] = param(
        (0.08, 0.16, 0.32),
        "discs: how far apart the three points of a circle are along a contour, shares of its length",
        low=0.001,
        high=0.5,
        paths=_PLANE,
        origin="an arc of a twelfth tells a circle where a disc is merged with something; longer ones tell it better",
    )
    arc_points: int = param(
        48,
        "discs: points of a contour at which circles are laid",
        low=3,
        high=1000,
        paths=_PLANE,
        origin="closer than a tolerance on blobs of up to 30 px",
    )
    tolerance_px: float = param(
        2.0,
        "a point this near to the contour matches it",
        unit="px",
        low=0.5,
        high=15,
        paths=_PLANE,
        origin="as published",
    )
    least_tolerance_px: float = param(
        1.0,
        "the tolerance of the smallest shapes",
        unit="px",
        low=0.3,
        high=15,
        paths=_PLANE,
        origin="a pixel and its neighbour",
    )
    tolerance_share: float = param(
        0.08,
        "small shapes: tolerance as a share of the root of the shape's area, not below least_tolerance_px",
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
        origin="a blob that shade or another object robs of two thirds; 2 loses one object in 90, more changes nothing",
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
    contour_per_start: int = param(
        8,
        "points of a blob's contour for each hypothesis that is refined: a small blob has room for few",
        low=1,
        high=1000,
        paths=_PLANE,
        origin="a marker of 12 px has some 30",
    )
    least_starts: int = param(
        4,
        "hypotheses that are refined however small the blob",
        low=1,
        high=1000,
        paths=_PLANE,
        origin="the turns of a square",
    )
    refine_steps: int = param(
        6,
        "steps of robust least squares",
        low=1,
        high=50,
        paths=_PLANE,
        origin="the gates narrow from 8 to 1.5 px in steps of a factor 1.4",
    )
    gates_px: tuple[float, ...] = param(
        (8.0, 1.5),
        "reach of Tukey's weight in the first and in the last step of refinement",
        unit="px",
        low=0.5,
        high=50,
        length=2,
        paths=_PLANE,
        origin="how far hypotheses may be off, and three times a contour's noise",
    )
    point_step: int = param(
        2,
        "refinement looks at every so many-th of a shape's 120 points",
        low=1,
        high=20,
        paths=_PLANE,
        origin="60 points place four unknowns as well as 120",
    )
    normal_agreement: float = param(
        0.6,
        "least cosine between an outline's normal and the contour's, for a point to match it",
        low=0.01,
        high=1,
        paths=_PLANE,
        origin="a staircase turns normals by up to 45 degrees",
    )
    max_refined_scale: float = param(
        1.4,
        "greatest factor by which refinement may change a scale",
        low=1,
        high=10,
        paths=_PLANE,
        origin="hypotheses from anchors are within a fifth; more means that it slid to another contour",
    )
    slant_gain: float = param(
        0.05,
        "with max_slant_deg: how much more of an outline a squeezed one must match to go before the plain one",
        low=0,
        high=1,
        paths=_PLANE,
        origin="two more unknowns fit anything a little better",
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
        if self.gates_px[1] > self.gates_px[0]:
            raise ConfigError(f"expert.alignment.gates_px: {list(self.gates_px)} must be the first and a smaller last")

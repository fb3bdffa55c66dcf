"""What to look for, and how."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ConfigError
from .params import param, validate


@dataclass(frozen=True)
class ObjectConfig:
    """One object to look for."""

    object_file: str = param("", "what the object is; a path relative to the parameter file, or package://PACKAGE/PATH")
    constraint_file: str = param("", "what was learned about it by artrec train; empty: nothing, poses in space only")
    label: int = param(0, "class number of its pixels, where its components have none of their own", low=1, high=253)


@dataclass(frozen=True)
class RecognizerConfig:
    """The recogniser's parameters, in the order of its stages."""

    profile: str = param(
        "default", "default, or paper: the published method with its values", choices=("default", "paper")
    )
    time_budget_ms: float = param(
        5000.0, "a frame's search ends here with what was found by then", unit="ms", low=1, high=600000
    )
    # whole spatial objects
    whole_object: bool = param(
        True, "fit whole objects in space where markers have places and the camera is calibrated"
    )
    min_votes: float = param(100.0, "least votes of the label image for a whole object", low=0)
    min_probability: float = param(0.3, "least probability of a whole object", low=0, high=1)
    # blobs and anchors
    min_blob_px: int = param(8, "blobs with fewer pixels are specks", unit="px^2", low=1, high=1000000)
    max_blobs: int = param(300, "at most so many blobs of a frame are looked at, the largest", low=1, high=10000)
    anchor_tolerances_px: tuple[float, ...] = param(
        (1.0, 2.0), "tolerances of the polygonal approximation that gives anchors", unit="px", low=0.3, high=20
    )
    anchor_tolerance_share: float = param(
        0.012, "the tolerances grow on blobs above 1/share pixels wide, in proportion", low=0, high=0.2
    )
    max_anchors: int = param(
        80, "ragged blobs are approximated more coarsely until they have no more anchors", low=3, high=1000
    )
    couple_spans: tuple[int, ...] = param(
        (1, 2),
        "couples are anchors so many places apart along the contour; the paper's are consecutive: 1",
        low=1,
        high=5,
    )
    # alignment
    tolerance_px: float = param(2.0, "a point this near to the contour matches it", unit="px", low=0.5, high=20)
    tolerance_share: float = param(
        0.08, "small shapes: tolerance as a share of the root of the shape's area, not below 1 px", low=0, high=1
    )
    min_area_ratio: float = param(0.03, "least area of a shape relative to its blob (merged blobs)", low=0, high=1)
    max_area_ratio: float = param(3.0, "greatest area of a shape relative to its blob (split blobs)", low=1, high=100)
    min_scale: float = param(0.0, "least scale to look for", unit="px/m", low=0)
    max_scale: float = param(0.0, "greatest scale to look for; 0: any", unit="px/m", low=0)
    coarse_step: int = param(6, "the first pass looks up every so many-th of a shape's 120 points", low=1, high=40)
    coarse_match: float = param(0.4, "least share that must match in the first pass", low=0, high=1)
    coarse_keep: int = param(200, "hypotheses a blob and shape that pass to the full count", low=1, high=10000)
    refine_keep: int = param(24, "hypotheses a blob and shape that are refined", low=1, high=1000)
    refine_steps: int = param(6, "steps of robust least squares", low=1, high=50)
    max_refined_scale: float = param(1.4, "greatest factor by which refinement may change a scale", low=1, high=10)
    max_slant_deg: float = param(
        0.0,
        "markers may be turned out of the image plane by so much and be seen squeezed; 0: none is",
        unit="deg",
        low=0,
        high=75,
    )
    min_match: float = param(0.55, "least share of a shape's visible outline that must match", low=0, high=1)
    min_visible: float = param(0.6, "least share of a shape's outline inside the image", low=0, high=1)
    same_start: float = param(
        0.12, "hypotheses closer than this share of the shape's radius are refined as one", low=0, high=1
    )
    same_place: float = param(
        0.04, "refined poses closer than this share of the shape's radius are one instance", low=0, high=1
    )
    max_instances: int = param(150, "instances of a shape and class that are carried on, the best", low=1, high=5000)
    symmetry_px: float = param(
        0.3, "turns that move the outline by less cannot be told apart", unit="px", low=0, high=10
    )
    # grouping
    contour_noise_px: float = param(
        0.5, "standard deviation of a contour's place; constraints are widened by two of it", unit="px", low=0, high=10
    )
    model_noise: float = param(
        0.02, "the same for what a flat rigid model leaves out, as a share of the shape's radius", low=0, high=0.5
    )
    max_scale_ratio: float = param(1.35, "greatest ratio between the scales of an object's components", low=1, high=10)
    missing_cost: float = param(
        0.15, "what a missing component costs, as a share of the contour it would explain", low=0, high=1
    )
    min_group_match: float = param(
        0.7,
        "least mean share matched of an object's components: a half-hidden one needs others that are clear",
        low=0,
        high=1,
    )
    min_alone_match: float = param(
        0.8, "the same for an object that no constraint between components supports", low=0, high=1
    )
    min_satisfied: float = param(0.8, "least share of the constraints that could be checked and hold", low=0, high=1)
    min_components: int = param(2, "least components found (no more than the object has)", low=1, high=100)
    max_overlap: float = param(0.3, "two objects may share this much of an instance's area", low=0, high=1)
    max_group_overlap: float = param(0.7, "two instances of one object may share this much", low=0, high=1)
    min_explained: float = param(
        0.25, "least share of its blobs' contours that accepted objects must explain", low=0, high=1
    )
    groups_per_seed: int = param(4, "groups carried on per instance of the required component", low=1, high=100)
    search_nodes: int = param(20000, "nodes of an exact search before it falls back to the best so far", low=1)
    # classes of configurations
    min_class_seen: float = param(
        0.7, "least share of a class's components, or joints, that an object must show to be of it", low=0, high=1
    )
    min_class_confidence: float = param(0.5, "least confidence of a class; below it there is none", low=0, high=1)
    class_noise: float = param(
        0.04,
        "standard deviation of what classes compare, beyond a contour's noise: of joints and angles in radians, of "
        "distances as a share; classes are widened by two of it",
        low=0,
        high=0.5,
    )
    # the published method's own values, used by profile paper alone
    paper_tolerance_px: float = param(2.0, "paper: half-width of the tolerance area", unit="px", low=0.5, high=20)
    paper_match: float = param(0.4, "paper: least share of contour points inside the tolerance area", low=0, high=1)
    paper_scale_ratio: float = param(1.5, "paper: greatest ratio of scales that is nearly one scale", low=1, high=10)

    def __post_init__(self) -> None:
        validate(self)
        for name in ("anchor_tolerances_px", "couple_spans"):
            if not getattr(self, name):
                raise ConfigError(f"{name}: none is given; one or more are needed")
        if 0 < self.max_scale < self.min_scale:
            raise ConfigError(f"max_scale: {self.max_scale} px/m is below min_scale {self.min_scale}; 0 means any")

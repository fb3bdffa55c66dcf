"""Room `pose`: how uncertain a pose is."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param

_WHOLE, _PLANE = ("space", "facing"), ("plane",)


@dataclass(frozen=True)
class CovarianceConfig(Room):
    """What makes the residuals of a fit err together, and by what poses err that follow from an object's size."""

    reach_px: int = param(
        3,
        "how far edges are looked for about a fitted contour",
        unit="px",
        low=1,
        high=50,
        paths=_WHOLE,
        origin="by hand: what is farther off belongs to something else",
    )
    floor_px: float = param(
        0.15,
        "a contour's points are never surer than this",
        unit="px",
        low=0,
        high=20,
        paths=_WHOLE,
        origin="by hand, held against true poses by benchmarks/covariance.py",
    )
    spread_share: float = param(
        1.0,
        "what of the residuals' own spread counts of each point by itself",
        low=0,
        high=10,
        paths=_WHOLE,
        origin="x",
    )
    seam_share: float = param(
        0.6,
        "deviation of an edge's place in a seam, the same all around, as a share of half the seam",
        low=0,
        high=10,
        paths=("plane", "space", "facing"),
        origin="that of an even distribution over the seam is 0.58",
    )
    shift_px: float = param(
        0.1,
        "deviation of a marker as a whole, in each direction",
        unit="px",
        low=0,
        high=20,
        paths=_WHOLE,
        origin="by hand, held against true poses by benchmarks/covariance.py",
    )
    stretches: int = param(
        4,
        "stretches of a contour, whose points err together",
        low=1,
        high=20,
        paths=_WHOLE,
        origin="by hand: the sides of a marker",
    )
    stretch_share: float = param(
        0.5,
        "what of the stretches' residuals counts",
        low=0,
        high=10,
        paths=_WHOLE,
        origin="the rest is the other terms' already: by hand, held against true poses by benchmarks/covariance.py",
    )
    restart_sigma: float = param(
        3.0,
        "deviations from its rest at which a fit is begun again, to see where it comes to rest then",
        low=0,
        high=10,
        paths=_WHOLE,
        origin="near the border of the region that holds nine in ten of six normal variables, 3.3",
    )
    restart_directions: int = param(
        2,
        "of how many directions, those of which the image tells least",
        low=1,
        high=6,
        paths=_WHOLE,
        origin="x",
    )
    restart_share: float = param(
        1.0,
        "what of the scatter of these rests counts",
        low=0,
        high=10,
        paths=_WHOLE,
        origin="x",
    )
    least_freedom: float = param(
        0.25,
        "least degrees of freedom left by the fit, as a share of the points",
        low=0.01,
        high=1,
        paths=_WHOLE,
        origin="by hand: a fit to few points tells little of their spread",
    )
    most_turn_rad: float = param(
        1.0,
        "deviation of a pose's turn that no contour tells of",
        unit="rad",
        low=0.01,
        high=10,
        paths=_WHOLE,
        origin="by hand: it is known which side is seen",
    )
    most_range_share: float = param(
        0.5,
        "deviation of a pose's place that no contour tells of, as a share of the depth",
        low=0.01,
        high=10,
        paths=_WHOLE,
        origin="by hand: its size in the image is seen",
    )
    flat_tilt_deg: float = param(
        35.0,
        "objects found in the image plane may be tilted by so much; more where recognizer.max_slant_deg allows more",
        unit="deg",
        low=0,
        high=75,
        paths=_PLANE,
        calibrated=True,
        origin="markers turned away by more are missed there",
    )
    flat_edge_px: float = param(
        0.5,
        "deviation of such an object's outline, the same all around, outwards or inwards",
        unit="px",
        low=0,
        high=20,
        paths=_PLANE,
        calibrated=True,
        origin="by hand, held against true poses: squares of 8 to 80 px; benchmarks/covariance.py --image-plane",
    )
    plane_z_m: float = param(
        0.002,
        "deviation of a marker's height from scene.plane",
        unit="m",
        low=0,
        high=10,
        paths=("plane", "facing"),
        origin="by hand: markers on robots that stand on a floor",
    )
    plane_tilt_rad: float = param(
        0.02,
        "deviation of a marker's roll and pitch from scene.plane",
        unit="rad",
        low=0,
        high=1,
        paths=("plane", "facing"),
        origin="by hand: 2 mm over a robot's width of 10 cm",
    )

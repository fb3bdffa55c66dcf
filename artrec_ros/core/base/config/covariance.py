"""Room `pose`: how uncertain a pose is."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param

_FITTED = "benchmarks/covariance_fit.py; 90 % regions of 516 poses hold 91 %, 50 % regions 71 %"
_WHOLE, _PLANE = ("space", "facing"), ("plane",)


@dataclass(frozen=True)
class CovarianceConfig(Room):
    """What makes the residuals of a fit err together, and by what poses err that follow from an object's size."""

    reach_px: int = param(
        4,
        "how far edges are looked for about a fitted contour",
        unit="px",
        low=1,
        high=50,
        paths=_WHOLE,
        origin=f"of 2, 3 and 4 the likeliest; {_FITTED}",
    )
    spread_share: float = param(
        0.604,
        "what of the residuals' spread counts of each point by itself",
        low=0,
        high=10,
        paths=_WHOLE,
        origin=_FITTED,
    )
    seam_share: float = param(
        0.427,
        "deviation of an edge's place in a seam, the same all around, as a share of half the seam",
        low=0,
        high=10,
        paths=("plane", "space", "facing"),
        origin=f"{_FITTED}; that of an even distribution over the seam is 0.58",
    )
    colour_edge_px: float = param(
        0.25,
        "in colour images, deviation of an edge's place between two blended colours, the same all around",
        unit="px",
        low=0,
        high=10,
        paths=("space", "facing"),
        origin="rendered quadrupeds, gantries, lorries and arms, 733 poses: 90 % regions hold 0.74 without, 0.82 with "
        "it (0.15: 0.81, 0.3: 0.83), 50 % regions 0.36 and 0.48",
    )
    shift_px: float = param(
        0.1,
        "deviation of all edges of an image together, along x and along y",
        unit="px",
        low=0,
        high=10,
        paths=_WHOLE,
        origin="the likeliest of 50 pictures of a real board of twelve squares: 90 % regions hold 0.20 without, 0.44 "
        "at 0.05, 0.72 at 0.1, 0.82 at 0.15; drawn pictures, which have none, are likeliest without it",
    )
    stretches: int = param(
        8,
        "stretches of a contour, whose points err together",
        low=1,
        high=20,
        paths=_WHOLE,
        origin=f"of 4 and 8 the likelier; {_FITTED}",
    )
    stretch_share: float = param(
        0.664,
        "what of the stretches' residuals counts",
        low=0,
        high=10,
        paths=_WHOLE,
        origin=_FITTED,
    )
    restart_sigma: float = param(
        3.0,
        "deviations from its rest at which a fit is begun again, to see where it comes to rest then",
        low=0,
        high=10,
        paths=_WHOLE,
        origin="near the border of the region that holds nine in ten of six normal variables, 3.3",
    )
    restart_share: float = param(
        0.342,
        "what of the scatter of these rests counts",
        low=0,
        high=10,
        paths=_WHOLE,
        origin=_FITTED,
    )
    seam_gain: float = param(
        1.85,
        "by how much more all of this counts for each pixel of half a seam",
        low=0,
        high=20,
        paths=_WHOLE,
        origin=_FITTED,
    )
    exact_share: float = param(
        0.75,
        "mean square of the residuals that exact labels leave, as a share of the variance that the labels along the "
        "normals leave to the places of edges",
        low=0,
        high=10,
        paths=_WHOLE,
        origin="three drawn objects whose pixels have the label of most of them: .72 to .84; less than all of it, for "
        "where labels leave it open an edge is taken to lie near the contour",
    )
    rough_gain: float = param(
        5.5,
        "by how much more all of this counts for each square pixel by which residuals' mean square is beyond that",
        unit="1/px^2",
        low=0,
        high=50,
        paths=_WHOLE,
        origin="three drawn objects, labels in cells of 4 px, ragged or mixed up by 1 and 2 px: 90 % regions hold .78, "
        ".63, .66, .88 and .54 by how far residuals are beyond half a pixel, by this .89, .83, .87, .89 and .89; by "
        "3.5 and 7 they are farther from nine in ten",
    )
    least_freedom: float = param(
        0.25,
        "least degrees of freedom left by the fit, as a share of the points",
        low=0.01,
        high=1,
        paths=_WHOLE,
        origin="a fit to few points tells little of their spread: no more than four times their own",
    )
    most_turn_rad: float = param(
        0.9,
        "deviation of a pose's turn that no contour tells of",
        unit="rad",
        low=0.01,
        high=10,
        paths=_WHOLE,
        origin="an even distribution over the half turn that shows a side: pi over the root of 12",
    )
    most_range_share: float = param(
        0.5,
        "deviation of a pose's place that no contour tells of, as a share of the depth",
        low=0.01,
        high=10,
        paths=_WHOLE,
        origin="far more than any marker leaves open whose size in the image is seen; keeps unseen places determined",
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
        origin="benchmarks/covariance_flat.py, markers of 8 to 80 px: 0.15 to 0.6 are the likeliest of some objects; "
        "at 0.5, 90 % regions of others hold 93 %, 50 % regions 81 %",
    )
    plane_z_m: float = param(
        0.002,
        "deviation of a marker's height from scene.plane",
        unit="m",
        low=0,
        high=10,
        paths=("plane", "facing"),
        origin="assumed, for no set at hand tells: what declared heights and a floor leave open",
    )
    plane_tilt_rad: float = param(
        0.02,
        "deviation of a marker's roll and pitch from scene.plane",
        unit="rad",
        low=0,
        high=1,
        paths=("plane", "facing"),
        origin="expert.covariance.plane_z_m over a robot's width of 10 cm",
    )

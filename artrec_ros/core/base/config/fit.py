"""Room `pose`: fits of poses and joints to contours."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ConfigError
from .params import Room, param

_WHOLE = ("space", "facing")


@dataclass(frozen=True)
class FitConfig(Room):
    """How labels tell where an edge is, and how a fit balances edges, joints and short steps."""

    coarse_reach_px: tuple[int, ...] = param(
        (8, 6, 4, 3),
        "how far the steps of a first fit look for edges",
        unit="px",
        low=1,
        high=50,
        paths=_WHOLE,
        origin="guesses are off by as much, each step by less; 2/3: right -1 of 244, 4/3: -1",
    )
    fine_reach_px: tuple[int, ...] = param(
        (4, 3, 3, 2, 2),
        "how far the steps of a later fit do",
        unit="px",
        low=1,
        high=50,
        paths=_WHOLE,
        origin="what climbs leave; 2/3: right -1 of 244, and in 200 other frames errors of places a quarter larger; "
        "4/3: +5, errors of joints a sixth larger",
    )
    edge_vote: float = param(
        1.0,
        "natural logarithm of what a known label says for one side of an edge",
        low=0,
        high=20,
        paths=_WHOLE,
        origin="odds of seven to one between the sides; 2/3: right +3 of 244, 4/3: +1",
    )
    seam_vote: float = param(
        -0.1,
        "natural logarithm of what a pixel in a seam says for the inner side of an edge",
        low=-20,
        high=20,
        paths=_WHOLE,
        origin="nearly silent: an edge lies in a seam's middle, a tenth of a pixel to the marker's side; 2/3: right "
        "-2 of 244, 4/3: +0",
    )
    edge_prior_width: float = param(
        0.6,
        "deviation of an edge's place from the contour before labels are looked at, as a share of the reach",
        low=0.05,
        high=10,
        paths=_WHOLE,
        origin="2/3: right -5 of 244, 4/3: +0",
    )
    edge_beyond: float = param(
        0.3,
        "where it is as likely as this that an edge lies beyond reach, there is none",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="2/3: right -1 of 244; 4/3: -2, found -3",
    )
    colour_reach_px: int = param(
        3,
        "in colour images, how far in and out of a contour colours are compared to find the edge between them",
        unit="px",
        low=1,
        high=20,
        paths=("space",),
        origin="beyond the blur of an edge, short of a neighbour's",
    )
    colour_contrast: float = param(
        0.06,
        "least difference of these colours, share of full scale",
        low=0,
        high=1,
        paths=("space",),
        origin="five times a camera's noise",
    )
    colour_doubt: float = param(
        0.25,
        "what a point counts where they tell no edge and labels do",
        low=0,
        high=1,
        paths=("space",),
        origin="such an edge is one or two pixels off where blur is",
    )
    colour_rounds: int = param(
        6,
        "steps of the last fit to colours at most",
        low=0,
        high=50,
        paths=("space",),
        origin="limbs that all but face the camera come to rest slowly: of 1020 joints of walkers of thirteen parts 23 "
        "are more than 12 degrees off with 3, 15 with 6 and with 10",
    )
    border_px: float = param(
        1.2,
        "an edge so near to the image's border is none",
        unit="px",
        low=0,
        high=20,
        paths=_WHOLE,
        origin="a pixel and its rounding",
    )
    point_sigma_px: float = param(
        0.7,
        "deviation of a contour's point from its edge",
        unit="px",
        low=0.01,
        high=20,
        paths=_WHOLE,
        origin="labels place a boundary this well; 2/3: right -1 of 244, 4/3: +2",
    )
    edges_off_px: float = param(
        0.3,
        "deviation of how far all edges of an object together lie outwards or inwards of where it ends, in the last "
        "fit of one that shows several markers, or a long one: seams, fringes, ink, blur",
        unit="px",
        low=0.001,
        high=20,
        paths=_WHOLE,
        origin="504 random objects in space, error of the place as a share of the range, median and root mean square: "
        "0.001 .90, 2.47 %; 0.1 .74, 2.30; 0.2 .78, 2.26; 0.3 .75, 2.25; 0.5 .71, 2.28; 1 .76, 2.31",
    )
    joint_sigma: float = param(
        1.5,
        "deviation of a joint from the middle of its range, in radians or shares of what slides",
        low=0.01,
        high=100,
        paths=_WHOLE,
        origin="weak: keeps unseen joints determined; 2/3: right +0 of 244, 4/3: -3, found -3",
    )
    shift_sigma: float = param(
        0.05,
        "a step should be no longer (Levenberg): of the place, as a share of the depth",
        low=0.0001,
        high=10,
        paths=_WHOLE,
        origin="2/3: right +1 of 244, 4/3: -2",
    )
    bend_sigma: float = param(
        0.15,
        "a step should be no longer (Levenberg): of a turn or a joint, in radians or shares of what slides",
        low=0.0001,
        high=10,
        paths=_WHOLE,
        origin="2/3: right -2 of 244, 4/3: -1",
    )
    most_shift: float = param(
        0.15,
        "a step may be no longer: of the place, as a share of the depth",
        low=0.0001,
        high=10,
        paths=_WHOLE,
        origin="three deviations",
    )
    most_bend: float = param(
        0.3,
        "a step may be no longer: of a turn or a joint, in radians or shares of what slides",
        low=0.0001,
        high=10,
        paths=_WHOLE,
        origin="two deviations",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("coarse_reach_px", "fine_reach_px"):
            if not getattr(self, name):
                raise ConfigError(f"expert.fit.{name}: none is given; one or more are needed")

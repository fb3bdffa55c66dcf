"""Room `learning`: constraints, classes and colours from examples. Offline: not in parameter files."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class LearningConfig(Room):
    """What `artrec train` and `artrec learn-colours` take for granted about examples."""

    least_width: float = param(
        0.02,
        "width below which a box is not resolved: radians, shares of a ratio, of a pair's greatest distance, of a "
        "sliding joint's range",
        low=0,
        high=1,
        origin="what a pixel tells of a marker of 50 px",
    )
    near_zero: float = param(
        0.15,
        "centroids closer than this share of a marker's size have no direction from one to the other",
        low=0,
        high=1,
        origin="the direction would be uncertain by more than 10 degrees at 50 px",
    )
    folded: float = param(
        0.8,
        "equal sides of a marker are told apart unless their directions fill less than this share of its symmetry's "
        "period",
        low=0,
        high=1,
        origin="a span that fills the period says nothing",
    )
    greatest_margin: float = param(
        2.0,
        "greatest margin of a box, in its widths",
        low=0,
        high=100,
        origin="examples too few for more are reported as such",
    )
    most_colours: int = param(
        4,
        "reference colours of a class at most",
        low=1,
        high=100,
        origin="a marker's own, and its glare",
    )
    least_share: float = param(
        0.05,
        "least share of a class' samples that a further colour must hold",
        low=0,
        high=1,
        origin="wrong samples are fewer",
    )
    least_share_background: float = param(
        0.1,
        "the same of what is unknown",
        low=0,
        high=1,
        origin="it holds a bit of everything",
    )
    least_samples: int = param(
        20,
        "pixels that a class, or a colour of the background, needs",
        low=1,
        high=100000,
        origin="fewer have no median worth the name",
    )
    margin_px: int = param(
        1,
        "pixels so near to an edge of their class are no samples",
        unit="px",
        low=0,
        high=50,
        origin="they are blends of two colours",
    )
    margin_unknown_px: int = param(
        4,
        "the same of what is not labelled",
        unit="px",
        low=0,
        high=50,
        origin="around what is labelled lie pixels of it that are not",
    )

"""Room `verdict`: what is an object, and how far it is trusted."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class VerdictConfig(Room):
    """What a whole object must have, and which objects are judged together."""

    min_votes: float = param(
        100.0,
        "least votes of the label image for a whole object",
        low=0,
        paths=("space", "facing"),
        origin="25 pixels of a marker at 4 votes each",
    )
    identity_independent: float = param(
        0.05,
        "share of a marker's pixels that tell its class independently of each other",
        low=0.0001,
        high=1,
        paths=("space", "facing"),
        origin="blur, compression and shade join pixels to patches of 4 to 5 px",
    )
    identity_floor: float = param(
        0.02,
        "least likelihood of a pixel under any class of its marker",
        low=0.0001,
        high=0.5,
        paths=("space", "facing"),
        origin="a pixel in fifty shows something else: no pixel decides alone",
    )
    margin_px: float = param(
        3.0,
        "two objects that stand nearer in the image are judged again when one of them has got its pixels",
        unit="px",
        low=0,
        high=100,
        paths=("space", "facing"),
        origin="ring_px and a pixel's rounding, of both",
    )
    margin_share: float = param(
        0.1,
        "such objects may be so much farther apart, as a share of the larger side",
        low=0,
        high=1,
        paths=("space", "facing"),
        origin="what a lens bends a box's edges out",
    )

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
        paths=("space",),
        origin="25 pixels of a marker at 4 votes each",
    )
    told_agree: float = param(
        0.2,
        "least share of a marker's pixels with its label for its component to be told, though it is not confirmed: "
        "seen nearly edge-on it may be too thin for that",
        low=0,
        high=1,
        paths=("space",),
        origin="@AGREE",
    )
    told_votes: float = param(
        -0.5,
        "least votes per pixel of such a component's markers",
        low=-20,
        high=20,
        paths=("space",),
        origin="@VOTES",
    )
    margin_px: float = param(
        3.0,
        "two objects that stand nearer in the image are judged again when one of them has got its pixels",
        unit="px",
        low=0,
        high=100,
        paths=("space",),
        origin="ring_px and a pixel's rounding, of both",
    )
    margin_share: float = param(
        0.1,
        "such objects may be so much farther apart, as a share of the larger side",
        low=0,
        high=1,
        paths=("space",),
        origin="what a lens bends a box's edges out",
    )

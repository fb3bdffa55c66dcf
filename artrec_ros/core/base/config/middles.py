"""Room `pose`: poses through the middles of blobs that are to be explained."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param

_WHOLE = ("space", "facing")


@dataclass(frozen=True)
class MiddlesConfig(Room):
    """How poses are sought that have components on blobs which the one found leaves unexplained."""

    starts: int = param(
        32,
        "turns and bends that fits begin with",
        low=1,
        high=10000,
        paths=_WHOLE,
        origin="drawn legs of which none or one of four discs is lost, 180 flat and 180 in space: the right one is "
        "among those kept 170 and 150 times with 8, 174 and 162 with 16, 177 and 168 with 32, 179 and 165 with 64",
    )
    keep: int = param(
        4,
        "of the fits so many climb, and are judged beside what was found",
        low=1,
        high=1000,
        paths=_WHOLE,
        origin="both turns of what is slanted, of both bends of what hangs between two markers",
    )
    looks: int = param(
        4,
        "fits in a frame at most",
        low=0,
        high=1000,
        paths=_WHOLE,
        origin="bounds the time: each takes 10 to 30 ms",
    )
    triples: int = param(
        4,
        "threes of points of an object's rigid markers, their middles, or both ends of a long one and another's "
        "middle, by whose blobs it is found: those that span most",
        low=0,
        high=1000,
        paths=("space",),
        origin="where one of its markers is hidden another three may be seen",
    )
    triples_tried: int = param(
        32,
        "for each of these so many combinations of blobs, those that are most alike in scale",
        low=1,
        high=100000,
        paths=("space",),
        origin="three blobs of each class; a thousandth of a second",
    )
    triples_blobs: int = param(
        16,
        "of each marker's blobs those that make them up, the largest",
        low=1,
        high=100,
        paths=("space",),
        origin="4096 threes of one class; of 300 blobs there would be 27 million",
    )
    triples_kept: int = param(
        64,
        "of the poses so many are judged, those first under which markers look most as large as their blobs",
        low=1,
        high=10000,
        paths=("space",),
        origin="each three allows up to four, a long marker and another one twice as many; 16 were of two pairs of "
        "poles amid their reflections",
    )
    triples_looks: int = param(
        8,
        "of the combinations of blobs under these poses so many are looked at closely, those with most votes",
        low=1,
        high=10000,
        paths=("space",),
        origin="one to three things of a long marker and a disc, 60 drawn frames: right .984 with 4, 1.00 with 8; a "
        "board of twelve squares among furniture: 37 and 45 ms, 54 with 16",
    )
    elongated: float = param(
        2.0,
        "a marker so many times as long as wide has ends that tell where the object is",
        low=1.1,
        high=100,
        paths=("space",),
        origin="what is less so has a long axis that slant turns",
    )
    slant_rad: float = param(
        0.8,
        "turn out of the image plane of a fit's first pose, at most",
        unit="rad",
        low=0,
        high=1.5,
        paths=("space",),
        origin="as guesses.turns_rad; a fit goes on from there",
    )
    place_px: float = param(
        2.0,
        "deviation of a marker's middle from its blob's",
        unit="px",
        low=0.1,
        high=100,
        paths=_WHOLE,
        origin="what hides or shades part of a patch moves its middle by as much",
    )
    size_share: float = param(
        0.15,
        "deviation of a marker's width from its blob's, as a share",
        low=0.01,
        high=10,
        paths=_WHOLE,
        origin="a pixel all around a patch of 14 px; in space what slants it comes on top",
    )

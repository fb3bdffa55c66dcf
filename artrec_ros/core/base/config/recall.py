"""Room `memory`: what of one frame helps the next."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param

_WHOLE = ("space",)


@dataclass(frozen=True)
class RecallConfig(Room):
    """What counts as the same blob, and as the same object, and when what is remembered is looked at anew."""

    moved_px: float = param(
        6.0,
        "a blob that was searched is the same where it moved by no more from one frame to the next",
        unit="px",
        low=0,
        high=1000,
        paths=_WHOLE,
        origin="180 px/s at 30 Hz; more and neighbours of one class are taken for each other",
    )
    changed_share: float = param(
        0.15,
        "and where its width, height and pixels changed by no larger share since it was searched",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="tried on walking robots: frames change blobs by 5 to 10 %, what uncovers a marker by more",
    )
    changed_px: float = param(
        2.0,
        "or by no more than this, and its pixels by its square",
        unit="px",
        low=0,
        high=100,
        paths=_WHOLE,
        origin="a pixel at each end, which noise takes and gives",
    )
    steadiness: float = param(
        0.5,
        "what an object's speeds of before count against those of the last step",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="two frames' noise against steps that change: as guesses are fitted, it matters little",
    )
    kept: float = param(
        0.9,
        "share of its votes that a known object must keep, without which it is looked for anew",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="what it loses from frame to frame while it is followed well is below that",
    )
    gone_s: float = param(
        0.5,
        "an object that was not seen for so long is forgotten",
        unit="s",
        low=0,
        high=100,
        paths=_WHOLE,
        origin="what hides robots that pass each other takes so long; each costs a millisecond a frame",
    )
    climb_rounds: int = param(
        6,
        "rounds of the climb of a known object that its fit alone does not explain",
        low=1,
        high=1000,
        paths=_WHOLE,
        origin="it begins near",
    )

"""Room `memory`: what of one frame helps the next."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param

_SPACE, _WHOLE = ("space",), ("space", "facing")


@dataclass(frozen=True)
class RecallConfig(Room):
    """What counts as the same blob, and as the same object, and when what is remembered is looked at anew."""

    retry_s: float = param(
        0.1,
        "a blob that was searched in vain is searched again after this, then after twice as long each time, up to "
        "refresh_s",
        unit="s",
        low=0.001,
        high=3600,
        paths=_WHOLE,
        origin="what is found in most frames is missed for a tenth of a second, what never is costs four looks more",
    )
    doubt_share: float = param(
        0.25,
        "while newer images wait, the share of time that is left to close looks at what is in doubt",
        low=0.001,
        high=1,
        paths=_SPACE,
        origin="what is known comes first; a blob in doubt takes as long as following some ten objects",
    )
    moved_px: float = param(
        6.0,
        "a blob that was searched is the same where it moved by no more from one frame to the next",
        unit="px",
        low=0,
        high=1000,
        paths=_WHOLE,
        origin="180 px/s at 30 Hz; more and neighbours of one class are taken for each other",
    )
    moved_share: float = param(
        0.25,
        "and besides by this share of its width and height",
        low=0,
        high=10,
        paths=_WHOLE,
        origin="the middle of what is cut otherwise by what hides it moves so",
    )
    grown_share: float = param(
        0.3,
        "where its width, height or pixels have grown by more than this since it was searched, or since they were "
        "least, it waits no longer than retry_s",
        low=0,
        high=10,
        paths=_WHOLE,
        origin="what uncovers a marker does so within a few frames; noise and steps change blobs by 5 to 15 %",
    )
    grown_px: float = param(
        2.0,
        "besides which they may grow by this, the pixels by its square",
        unit="px",
        low=0,
        high=100,
        paths=_WHOLE,
        origin="a pixel at each end, which noise takes and gives",
    )
    little_px: float = param(
        40.0,
        "a blob of fewer pixels is searched once, and then every refresh_s only, whatever it does, until it is larger",
        unit="px^2",
        low=0,
        high=1e6,
        paths=_WHOLE,
        origin="what comes out from behind another grows past it within a few frames; below, one look in some two "
        "hundred finds an object, and takes as long as others",
    )
    steadiness: float = param(
        0.5,
        "what an object's speeds of before count against those of the last step, and likewise log odds of what may be "
        "there instead of it",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="two frames' noise against steps that change: as guesses are fitted, it matters little; what a frame "
        "says of two that look the same is as far off one way as the next is the other way",
    )
    kept: float = param(
        0.9,
        "share of its votes that a known object must keep, without which it is looked for anew; what faces the camera "
        "likewise where it has so many more",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="what it loses from frame to frame while it is followed well is below that",
    )
    strayed: float = param(
        0.3,
        "how far it may be from where it is expected, as a share of how far climbs go, else it is looked for anew",
        low=0,
        high=1,
        paths=_SPACE,
        origin="steps at 30 Hz are below; a tenth of a second's are not",
    )
    left: float = param(
        0.5,
        "share of its votes that a first fit must leave a known object, without which it is not followed",
        low=0,
        high=1,
        paths=_SPACE,
        origin="half of it may be hidden from one frame to the next; where it is not there less is left",
    )
    limbs: float = param(
        2.0,
        "blobs within so many times the size of the required component of an object that is gone are searched at once, "
        "once",
        low=0,
        high=100,
        paths=_SPACE,
        origin="limbs lie there, and half hidden objects are often found from theirs",
    )
    most_gone: int = param(
        8,
        "at most so many of these of each name are remembered, those that were seen last",
        low=0,
        high=1000,
        paths=_WHOLE,
        origin="more than hide one another in a crowd; bounds the time",
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

"""Room `tracking`: how the probability that an object is there is carried on."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class ExistenceConfig(Room):
    """How the probability that an object is there changes from frame to frame."""

    least: float = param(
        0.4,
        "probability from which an object is told, but for predictions recognizer.min_probability where that is less; "
        "one that a single frame would tell waits where frames go on",
        low=0,
        high=1,
        origin="as recognizer.min_probability of one frame",
    )
    newcomer_s: float = param(
        0.09,
        "time between frames from which a newcomer is hardly less likely than in a frame alone",
        unit="s",
        low=0.001,
        high=3600,
        origin="walking quadrupeds: at 30 Hz a newcomer of probability 0.9 is told at once, one of 0.8 when it is seen "
        "again; at 8 Hz none waits that is there",
    )
    memory: float = param(
        0.8,
        "what earlier frames say of an object's existence, times this for each frame that shows it",
        low=0,
        high=1,
        origin="five frames count, as for identities: light and clutter are alike from one frame to the next",
    )
    anew: float = param(
        0.1,
        "a frame says something new of an object that has moved by this since the one before, in sizes of its required "
        "component; of one that stands still, or comes nearer slowly, or shows one of its components alone, it says "
        "what that said",
        low=0.001,
        high=100,
        origin="walking quadrupeds: 0.05 and 0.2 tell the same; with none what stands still is told as all but sure "
        "after five frames",
    )
    found_again: float = param(
        1.0,
        "what it says for an object that has moved that it is found where it was expected: log of a ratio of "
        "probabilities",
        low=0,
        high=20,
        origin="walking quadrupeds",
    )
    detected: float = param(
        0.8,
        "probability that an object that can be seen is found",
        low=0,
        high=0.999,
        origin="recognition of walking quadrupeds is 0.99, less where they are half hidden",
    )
    hide_s: float = param(
        1.0,
        "after how long an object that could be seen cannot be: behind something, turned away, or for no known reason",
        unit="s",
        low=0.01,
        high=3600,
        origin="misses come in rows: one frame is like the next",
    )
    show_s: float = param(0.5, "after how long it can be seen again", unit="s", low=0.01, high=3600, origin="as above")
    stay_s: float = param(
        10.0, "how long objects stay in view", unit="s", low=0.01, high=1e6, origin="as long as a robot takes to cross"
    )
    gone: float = param(
        0.05, "probability below which an object is forgotten", low=0, high=1, origin="it changes nothing any more"
    )
    cut: float = param(
        0.05,
        "share of frames that have nothing to do with the one before, until some have been seen",
        low=0.0001,
        high=0.9999,
        origin="cameras send sequences; where they do not, it is soon seen",
    )
    cut_frames: float = param(
        10.0,
        "from how many frames that share is learned",
        low=1,
        high=10000,
        origin="walking quadrupeds, frames shuffled: 3 of 8,469 objects wait that single frames tell; with 30 it was "
        "twice as many",
    )
    most_odds: float = param(
        20.0,
        "how much an object that is found where it was expected says at most for a sequence that goes on",
        low=1,
        high=1e6,
        origin="objects of another scene can stand at the same place",
    )

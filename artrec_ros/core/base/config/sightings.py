"""Room `tracking`: how exactly a detection tells where an object is."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class SightingsConfig(Room):
    """What tracking takes a detection to be worth: uncertainties beyond those that a fit tells."""

    misturned: float = param(
        0.1,
        "share of detections whose turn is wrong: mirrored, or by a marker's symmetry",
        low=0.001,
        high=0.999,
        origin="rendered quadrupeds: one in ten",
    )
    misturned_share: float = param(
        0.015,
        "how far off such a one is in space, as a share of its range",
        low=0.0001,
        high=1,
        origin="walking quadrupeds: 0.01 to 0.03",
    )
    turn_rad: float = param(
        0.3,
        "least uncertainty of a turn",
        unit="rad",
        low=0.001,
        high=3,
        origin="walking quadrupeds: one rotation in ten is off by 0.1 to 0.2 rad, one in twenty by 0.5; 0.2 to 0.4 "
        "serve alike",
    )
    turn_odds: float = param(
        1.5,
        "log odds of a turn beside which no mirrored one is told",
        low=0,
        high=100,
        origin="of random objects .93 to .99 are right (2.6), but frames err alike: drawn videos of plates, pairs, "
        "laptops, mailboxes and drawbridges like 1 to 2 best",
    )
    turn_correlation: float = param(
        0.2,
        "how much frames that show an object turned one way or its mirrored one err alike; 1: more frames tell no more "
        "than one",
        low=0,
        high=1,
        origin="benchmarks/turns.py",
    )
    turn_memory_s: float = param(
        3.0,
        "how long it counts which way an object was turned: time constant",
        unit="s",
        low=0.001,
        high=1000,
        origin="benchmarks/turns.py",
    )
    range_share: float = param(
        0.01,
        "least uncertainty of a range, as a share of it",
        low=0.0001,
        high=1,
        origin="position errors of 0.4 to 1.1 % of the range",
    )
    bearing_rad: float = param(
        0.002,
        "least uncertainty of the direction in which a place in space lies",
        unit="rad",
        low=0.0001,
        high=1,
        origin="walking quadrupeds: 0.001 to 0.003, parts of them hidden",
    )
    place_px: float = param(
        1.5,
        "uncertainty of a place in the image",
        unit="px",
        low=0.01,
        high=100,
        origin="a blob that is cut or merged moves by so much from frame to frame",
    )
    scale_share: float = param(
        0.05,
        "uncertainty of a scale in the image, as a share",
        low=0.001,
        high=1,
        origin="a pixel at each end of a marker of 40",
    )
    misplaced: float = param(
        0.03,
        "share of detections that are wrong in space altogether, and right in the image only",
        low=0.0001,
        high=0.999,
        origin="walking quadrupeds: farther off than their covariance allows in 2 to 10 %",
    )
    off_share: float = param(
        0.15,
        "how far off its place in the image such a one is, as a share of the required component's size",
        low=0,
        high=10,
        origin="markers that are half hidden, walking quadrupeds",
    )
    off_scale: float = param(
        0.3,
        "how far off its scale in the image such a one is, as a share",
        low=0.001,
        high=10,
        origin="walking quadrupeds: half as far off again, seldom twice",
    )
    misnamed: float = param(
        0.02,
        "share of detections in which the pixels tell of another identity than the object's",
        low=0.0001,
        high=0.999,
        origin="overhead robots: names told at 0.8 and more are wrong in one of fifty",
    )
    far: float = param(
        40.0,
        "squared deviations of place and turn, by the covariances, beyond which a pose is taken to be wrong",
        low=1,
        high=1e6,
        origin="one in two million of six normal variables; walking quadrupeds: 2 to 7 %",
    )
    usual: float = param(
        10.6,
        "squared deviations up to which a pose counts in full, a joint up to a quarter of them; beyond, its "
        "covariance is taken for larger by as much",
        low=1,
        high=1e6,
        origin="nine in ten of six normal variables; 2.7 of one",
    )
    strange: float = param(
        2.0,
        "frames in a row that show an object elsewhere in space than expected, or turned otherwise, before that is "
        "believed",
        low=0,
        high=1000,
        origin="mirrored turns come and go from frame to frame",
    )
    calm: float = param(
        0.2,
        "least speed that an object is taken to have, as a share of tracking.speed and turn_rate: down to it what is "
        "seen of the object counts",
        low=0.001,
        high=1,
        origin="walking quadrupeds: change of the error from frame to frame 0.17 % of the range without, 0.12 % with",
    )
    joint_rad: float = param(
        0.01,
        "least uncertainty of a joint where the fit tells none; of a prismatic one times a length of the object",
        unit="rad",
        low=0.0001,
        high=3,
        origin="walking quadrupeds, 640x480: 0.01",
    )
    joint_turn: float = param(
        0.5,
        "uncertainty of such a joint besides, times that of the body's turn",
        low=0,
        high=100,
        origin="walking quadrupeds: both grow as images are smaller",
    )
    joint_rate: float = param(
        6.0,
        "standard deviation of the rate of joints; of prismatic ones times a length of the object",
        unit="rad/s",
        low=0,
        high=1000,
        origin="legs of walking quadrupeds: 2.8, and half as long steady as bodies",
    )
    identity_memory: float = param(
        0.8,
        "what earlier sightings say of which one of several like objects it is, times this for each frame since",
        low=0,
        high=1,
        origin="five frames count: light and blur are alike from one frame to the next, and prove nothing twice",
    )

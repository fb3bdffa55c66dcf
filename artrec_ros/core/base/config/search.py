"""Room `pose`: how a frame is searched for whole objects."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ConfigError
from .params import Room, param

_SPACE = ("space",)
_WHOLE = ("space", "facing")


@dataclass(frozen=True)
class SearchConfig(Room):
    """Which hypotheses differ, how they climb on the votes, and what ends the search of a blob."""

    search_share: float = param(
        0.9,
        "what of the time that is left may go into the search",
        low=0.01,
        high=1,
        paths=_SPACE,
        origin="the rest is for judging what it found",
    )
    cell_place: float = param(
        0.012,
        "hypotheses nearer than this across the view are one, as a share of the depth",
        low=0.0001,
        high=1,
        paths=_WHOLE,
        origin="0.7 degrees, a fit brings them to one place; 2/3: right +0 of 244, 4/3: -1",
    )
    cell_log_depth: float = param(
        0.06,
        "hypotheses nearer than this in depth are one, as a share of it",
        low=0.0001,
        high=1,
        paths=_WHOLE,
        origin="a fit brings them to one place; 2/3: right -2 of 244, 4/3: -2",
    )
    cell_axis: float = param(
        0.2,
        "hypotheses nearer than this in the components of their x and z axes are one; all three must be so",
        low=0.001,
        high=2,
        paths=_WHOLE,
        origin="about 12 degrees, a fit brings them to one place; 2/3: right +1 of 244, 4/3: +3",
    )
    niche_rad: float = param(
        0.35,
        "hypotheses of a sure object that are turned by less, and nearer than niche_range, climb to one",
        unit="rad",
        low=0,
        high=3.14,
        paths=_SPACE,
        origin="how far climbs go; half as much again changes 3 of 112 frames, and no object",
    )
    niche_range: float = param(
        0.12,
        "hypotheses of a sure object nearer than this share of the range, turned by less than niche_rad, climb to one",
        low=0,
        high=1,
        paths=_SPACE,
        origin="how far climbs go; more changes nothing in 112 frames, but like parts side by side are as near as that",
    )
    joint_step: float = param(
        0.15,
        "joints are sought at values so far apart, the unit of a climb's steps of them, too; in radians or shares of "
        "what slides",
        low=0.01,
        high=3,
        paths=_WHOLE,
        origin="a fit to contours makes the rest good; 2/3: right +1 of 244, 4/3: -2, found -3",
    )
    first_joint_step: float = param(
        0.25,
        "joints of hypotheses that are first looked at are sought at values so far apart",
        low=0.01,
        high=3,
        paths=_WHOLE,
        origin="a climb makes the rest good; 2/3: right +2 of 244, 4/3: +0",
    )
    joint_keep: int = param(
        24,
        "hypotheses of a blob that go on with their joints",
        low=1,
        high=10000,
        paths=_SPACE,
        origin="2/3: right +1 of 244, 4/3: +0",
    )
    fit_keep: int = param(
        8,
        "hypotheses of a blob that go on fitted",
        low=1,
        high=10000,
        paths=_SPACE,
        origin="2/3: right -3 of 244, 4/3: +0",
    )
    flip_keep: int = param(
        3,
        "the best, whose mirrored turns are looked at",
        low=1,
        high=10000,
        paths=_SPACE,
        origin="with 2 right +0 of 244, with 4 +0",
    )
    bend_step: float = param(
        0.1,
        "joints of an object whose joints carry joints are sought together at values so far apart; in radians or "
        "shares of what slides",
        low=0.01,
        high=3,
        paths=_SPACE,
        origin="a peak's place is found to a quarter of it; of 15 chains of twelve links whose joints were wrong, 7 "
        "are right with it, 5 with 0.08 or 0.15",
    )
    bend_ways: int = param(
        16,
        "ways to bend such an object that are followed side by side, from its root to its ends",
        low=1,
        high=100,
        paths=_SPACE,
        origin="with 32 the same of these chains",
    )
    bend_least: float = param(
        0.05,
        "share of an object's votes that its parts must lack on their labels for its joints to be sought anew",
        low=0,
        high=1,
        paths=_SPACE,
        origin="about what one link of a chain of twelve brings; simulated chains, right .76 without, .86 with it, .90 "
        "at 0, which takes a scorpion with a tail of three in plain view four times as long",
    )
    bend_keep: int = param(
        4,
        "of the ways from one pose, and then of those from all, so many are fitted, and climb",
        low=1,
        high=100,
        paths=_SPACE,
        origin="of 25 simulated chains of twelve links that were bent wrongly 14 come right with it, 6 with 1",
    )
    fine_joint_step: float = param(
        0.05,
        "values of joints are so far apart where others than a climb's are looked for, of parts that do not lie on "
        "their labels; in radians or shares of what slides",
        low=0.01,
        high=3,
        paths=_SPACE,
        origin="a third of joint_step: a peak as wide as a marker is long is not stepped over",
    )
    other_joints: int = param(
        4,
        "such poses of an object that are fitted, the best ones",
        low=0,
        high=10000,
        paths=_SPACE,
        origin="gantries with three slides, made by others, right in all joints: 80 of 88 from labels, 73 from colour "
        "without it, 83 and 81 with it",
    )
    near_joints: float = param(
        0.99,
        "share of an object's votes that the best of these must have for a climb; parts that are worth less than the "
        "rest are left where they are, and so are all of a known object that keeps this share of what it had",
        low=0,
        high=1,
        paths=_SPACE,
        origin="a climb adds a hundredth; of the gantries 83 and 81 are right with it, 84 and 80 at 0.97, which takes "
        "twice the time",
    )
    rival: float = param(
        0.8,
        "share of a sure object's votes that makes a rival",
        low=0,
        high=1,
        paths=_SPACE,
        origin="mirrored turns keep so many; 0.53 changes one of 112 frames, and no object",
    )
    hopeless: float = param(
        0.02,
        "candidates of which none is as probable are not worth a climb, nor are, after the first one, those the best "
        "of which does not show its required component",
        low=0,
        high=1,
        paths=_SPACE,
        origin="of 595 long looks at rendered quadrupeds 271 began so, and one of them ended in an object",
    )
    climb_hypotheses: tuple[int, ...] = param(
        (10, 5, 3),
        "at most so many hypotheses of a blob climb, climb after climb",
        low=1,
        high=1000,
        paths=_SPACE,
        origin="2/3: right -1 of 244, 4/3: +0",
    )
    climb_rounds: tuple[int, ...] = param(
        (11, 13, 24),
        "rounds of each of these climbs; an object beyond doubt climbs as the last one does, the last but one's rounds",
        low=1,
        high=1000,
        paths=_SPACE,
        origin="2/3: right -1 of 244, 4/3: -1",
    )
    climb_first_steps: tuple[float, ...] = param(
        (1.5, 1.0, 0.7),
        "first steps of each of these climbs, in units of step_px and the like",
        low=0.01,
        high=100,
        paths=_SPACE,
        origin="a later climb begins nearer",
    )
    step_px: float = param(
        1.5,
        "unit of a climb's steps across the view",
        unit="px",
        low=0.01,
        high=100,
        paths=_WHOLE,
        origin="as far as votes about outlines tell; 2/3: right +2 of 244, facing: -4 of 197; 4/3: -1 and -1",
    )
    step_depth: float = param(
        0.03,
        "unit of a climb's steps along the view, as a share of the depth",
        low=0.0001,
        high=1,
        paths=_WHOLE,
        origin="1.5 px at the edge of an object of 100 px; 2/3: right +0 of 244, 4/3: +3",
    )
    step_rad: float = param(
        0.12,
        "unit of a climb's steps of a turn",
        unit="rad",
        low=0.001,
        high=3,
        paths=_WHOLE,
        origin="2/3: right -1 of 244, 4/3: +2",
    )
    lengthen: float = param(
        1.6,
        "a step of a climb that helped is longer by this factor the next time",
        low=1,
        high=10,
        paths=_WHOLE,
        origin="Rosenbrock 1960 has 3, for more rounds; 2/3: right +2 of 244, 4/3: -2",
    )
    turn: float = param(
        -0.7,
        "a step of a climb that did not help is multiplied with this",
        low=-1,
        high=-0.01,
        paths=_WHOLE,
        origin="Rosenbrock 1960 has -0.5, for more rounds; 2/3: right -3 of 244, 4/3: -2",
    )
    least_step: float = param(
        0.01,
        "a shorter step of a climb is not taken",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="a fit to the contours goes there in one step",
    )
    settled_votes: float = param(
        0.6,
        "share of a hypothesis' votes that must be left after its last fit",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="contours of merged blobs lead astray; with .85, what looks larger or smaller than it is, as fits know "
        "and votes do not, stays at a scale that is a tenth off",
    )
    pieces: int = param(
        2,
        "ranges of sizes, each guesses.piece_ratio below the other, in which blobs that nothing explains beyond doubt "
        "are searched for several objects that make them up",
        low=0,
        high=6,
        paths=_SPACE,
        origin="of 289 rendered hands of eleven parts that overlap, none finds 264 with 1 false, two 272 with 3; "
        "in crowds of quadrupeds, whose markers seldom merge, it changes nothing",
    )
    sure: float = param(
        0.82,
        "trust in an object that takes its pixels: others are not searched for there",
        low=0,
        high=2,
        paths=_WHOLE,
        origin="fit: 3 % of such claims may be wrong (benchmarks/acceptance.py --fit); above 1: none is sure",
    )
    beyond_doubt: float = param(
        0.985,
        "trust in an object that ends a search by few guesses, or in one size of a blob of several things",
        low=0,
        high=2,
        paths=_SPACE,
        origin="fakes that such searches found took the pixels of others: with 0.82 of 1307 quadrupeds in a crowd 1287 "
        "are found, 1131 right, .033 false a frame; with 0.96 1290, 1133, .022; so 1292, 1140, .022, in 8 % more time",
    )
    likely: float = param(
        0.605,
        "trust in one whose blobs need not be looked at again for the same target",
        low=0,
        high=2,
        paths=_SPACE,
        origin="fit: 8 % of such claims may be wrong (benchmarks/acceptance.py --fit); above 1: none is likely",
    )
    explained: float = param(
        0.6,
        "share of a blob's contour that must be a sure or a likely object's, for the blob to be done with",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="more than half, for a blob may be two that merged; 0.12 loses one object in 80, 0.9 takes longer",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        climbs = len(self.climb_hypotheses), len(self.climb_rounds), len(self.climb_first_steps)
        if not climbs[0] or len(set(climbs)) > 1:
            raise ConfigError(
                "expert.search.climb_hypotheses, climb_rounds, climb_first_steps: {}, {} and {} numbers are given; "
                "one climb or more need one of each".format(*climbs)
            )

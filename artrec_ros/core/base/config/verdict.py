"""Room `verdict`: what is an object, and how far it is trusted."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class VerdictConfig(Room):
    """What a whole object must have, and what of it is told."""

    min_votes: float = param(
        100.0,
        "least votes of the label image for a whole object",
        low=0,
        paths=("space", "facing"),
        origin="25 pixels of a marker at 4 votes each",
    )
    least_free: float = param(
        0.25,
        "what nobody else owns of an object's markers, least share for it to be one",
        low=0,
        high=1,
        paths=("space", "facing"),
        origin="what a pixel of rim is of a square of 20; real robots of three teams whose patches bear each other's "
        "colours: 9 objects told on others in 30 images -> 0; crowds of quadrupeds, 360 images: false 4 -> 1",
    )
    least_known: float = param(
        0.1,
        "probability from which an object that is known from images before may go on in a candidate that one image "
        "alone does not tell",
        low=0,
        high=1,
        paths=("space", "facing"),
        origin="a quarter of what one image tells: less likely ones are mostly clutter",
    )
    size_votes: float = param(
        0.9,
        "share of an object's votes that it must have at the size that its edges would give it, where that is beyond "
        "the limits of the scale or of the scene's plane, for this to speak against it",
        low=0,
        high=2,
        paths=("facing",),
        origin="0.6 and 0.8 take .16 off the score of one of 160 robots in bad light whose edges lead astray; with 1 "
        "four of 24 lone squares of .8 of the size are told at .94",
    )
    told_agree: float = param(
        0.2,
        "least share of a marker's pixels with its label for its component to be told where votes speak for it, "
        "though it is not confirmed: seen nearly edge-on it may be too thin for that",
        low=0,
        high=1,
        paths=("space", "facing"),
        origin="half of a shaded marker is unknown, and more of a thin one; 0.13 gets two objects in 208 wrong",
    )
    several_parted: float = param(
        0.5,
        "share of the outline of a component that may be of several classes which, in an image with colours, counts as "
        "all of it where it does not lie amid the class that is shown: blurred edges are blends of these",
        low=0.1,
        high=1,
        paths=("space", "facing"),
        origin="photographs of tags of five squares in five colours: 1 tells 4 of 12, 0.8 10, 0.5 all and 7 false",
    )
    stand_in: float = param(
        0.5,
        "where another component fits better in the required one's place, and the object then explains still this "
        "share of what it did, it is not told",
        low=0,
        high=1,
        paths=("space", "facing"),
        origin="chains whose heads are hidden keep .57 to 1, quadrupeds whose chests are half hidden .25 at most",
    )
    nearer: float = param(
        0.03,
        "share of its range by which an object must lie before another one to hide it, whoever took the pixels; nearer "
        "to each other the one hides that took them, which is the one that explains more",
        low=0,
        high=1,
        paths=("space",),
        origin="in crowds 95 % of places err by less than 2.3 %, so that much between two of them",
    )
    mirrored_votes: float = param(
        0.8,
        "share of the votes of a told pose, or of what a joint carries, from which on the mirrored turn or bend, "
        "fitted likewise, may be the true one, or another target's object in its place",
        low=0,
        high=1,
        paths=("space", "facing"),
        origin="of 351 random objects below it 4 were mirrored",
    )
    turn_odds: tuple[float, ...] = param(
        (-0.5, 6.7, 0.31),
        "log odds of a told pose's mirrored turn, or of a joint's mirrored bend, from labels: before anything is known "
        "of it, for each unit of the logarithm of its share of the votes, and of the root of the contours' log "
        "likelihood ratio",
        low=-20,
        high=50,
        length=3,
        paths=("space", "facing"),
        origin="benchmarks/turns.py; flat objects that look almost the same turned otherwise are judged as these",
    )
    turn_odds_colour: tuple[float, ...] = param(
        (-0.34, 4.8, 0.53),
        "of turns the same from colour images, whose edges are finer",
        low=-20,
        high=50,
        length=3,
        paths=("space",),
        origin="benchmarks/turns.py",
    )
    tilt_odds: tuple[float, ...] = param(
        (-0.3, 3.1, 0.52),
        "the same as turn_odds of a box, a cylinder or another solid of one class that is tilted where it is, of whose "
        "outline more differs; the likelier one is told",
        low=-20,
        high=50,
        length=3,
        paths=("space",),
        origin="1189 such tilts of six simulated boxes and cylinders; on others: benchmarks/tilts.py",
    )
    tilt_odds_colour: tuple[float, ...] = param(
        (0.25, 6.7, 0.55),
        "of tilts the same from colour images",
        low=-20,
        high=50,
        length=3,
        paths=("space",),
        origin="1119 tilts of the same; on others: benchmarks/tilts.py",
    )
    bend_odds_colour: tuple[float, ...] = param(
        (-0.37, 0.0, 0.66),
        "of bends the same from colour images: votes of one marker tell rather how its colours spread",
        low=-20,
        high=50,
        length=3,
        paths=("space",),
        origin="benchmarks/turns.py",
    )
    alone_odds: tuple[float, ...] = param(
        (-1.9, 15.5, 0.0),
        "the same as turn_odds of a required component turned by itself, about the one joint by which all else that is "
        "seen hangs on it",
        low=-20,
        high=100,
        length=3,
        paths=("space",),
        origin="163 poses of 70 worlds, benchmarks/turned_alone.py; on 158 of 70 others log-loss by turn_odds .291, so "
        ".165",
    )
    alone_odds_colour: tuple[float, ...] = param(
        (-1.3, 15.9, 0.41),
        "of such turns the same from colour images",
        low=-20,
        high=100,
        length=3,
        paths=("space",),
        origin="183 poses of 70 worlds; on 195 of 70 others log-loss by turn_odds_colour .363, so .193",
    )
    end_markers: int = param(
        3,
        "hidden ends are thought of where no more markers tell where an object is",
        low=0,
        high=100,
        paths=("space",),
        origin="four and more hold a pose where one of them seems to end; each costs four fits more",
    )
    end_misfit_px2: float = param(
        0.14,
        "they are thought of where contours lie farther from labels' edges, in the mean square",
        unit="px^2",
        low=0,
        high=100,
        paths=("space",),
        origin="of 157 quadrupeds in a film 0.13 in 97 of a hundred; of 15 tapes cut short 0.14 and more in 95",
    )
    end_share: float = param(
        0.5,
        "share of a marker's length without which it is fitted, to leave out what may end it",
        low=0.05,
        high=0.9,
        paths=("space",),
        origin="a tape of which a third is hidden is told by the other half",
    )
    end_votes: float = param(
        0.6,
        "share of the votes of a told pose without which one that leaves an end hidden is not looked at",
        low=0,
        high=1,
        paths=("space",),
        origin="with less log odds are below -3",
    )
    end_apart: tuple[float, ...] = param(
        (0.25, 0.03),
        "such a pose is another one from so far off on: turned (rad), or of its place, a share of the range",
        low=0,
        high=3,
        length=2,
        paths=("space",),
        origin="what poses of few markers are off without anything hidden",
    )
    far_end_odds: tuple[float, ...] = param(
        (1.53, 2.01, 29.2, 3.98),
        "log odds between readings of long markers that face the camera: less by so much for each end beyond which the "
        "class goes on, or may beneath what begins there, for each that lies beyond its class and beneath nothing, and "
        "if all of their sides had no edge, but for what is outermost beside the latter; more by so many times the "
        "logarithm of votes",
        low=0,
        high=100,
        length=4,
        paths=("facing",),
        origin="benchmarks/ends.py",
    )
    far_end_apart: tuple[float, ...] = param(
        (2.1, 0.05),
        "such a reading is another one where some end lies farther off than that (px), and than this share of the "
        "distance between the farthest ends",
        low=0,
        high=50,
        length=2,
        paths=("facing",),
        origin="three deviations of a contour's point, `fit.point_sigma_px`; what widths tell at best",
    )
    in_place_odds: tuple[float, ...] = param(
        (-1.0, 4.0),
        "log odds beside these of a turn that lays the required component's markers onto themselves, as half a turn of "
        "a box, or that a joint on it takes back: before anything is known of it, and for each component that it bears "
        "out more than the pose that was found",
        low=-20,
        high=20,
        length=2,
        paths=("space",),
        origin="of such turns of 11 simulated objects with boxes and plates, 211 that bore out as many 19 were true, "
        "for which `turn_odds` alone say 60; of 20 that bore out one more 18, and no pose that was found; of 421 that "
        "bore out less one; of 731 of drawn cranes and signposts, most of them taken back, all 25 of log odds above 0 "
        "were true, and 8 of the others",
    )
    differing_odds: tuple[float, ...] = param(
        (1.26, 0.024, 3.08, 0.21),
        "log odds between two turns of an object that is one flat marker, or two values of a joint that lay like "
        "markers on each other: so many times the logarithm of how many of the pixels in which both differ speak for "
        "each, and of these many more (px^2); and so many times what votes and contours say, as of turn_odds; by these "
        "two alone between two blobs that what a joint carries may lie on",
        low=0.0,
        high=1000,
        length=4,
        paths=("space", "facing"),
        origin="benchmarks/lone_turns.py; joints' values, whose marks tell as much, are judged as these; 941 pairs of "
        "blobs of drawn arms, sliders and animals alone say 3.1 and .29, log loss .352; by these .357",
    )
    rival_odds: tuple[float, ...] = param(
        (1.8, 0.9, 4.7, 0.17),
        "log odds between objects of two targets that explain the same: as differing_odds, by the pixels in which they "
        "differ where both face the camera or are one marker",
        low=0.0,
        high=1000,
        length=4,
        paths=("space", "facing"),
        origin="benchmarks/like_targets.py",
    )
    least_turn_odds: float = param(
        1.0,
        "log odds from which on the mirrored turn is told in place of the one found, of flat objects another place in "
        "which like markers lie where they are seen; below, both are as likely. Of flat objects that are one marker "
        "also from which on a hypothesis goes no further",
        low=0,
        high=20,
        paths=("space", "facing"),
        origin="of random objects as many are right at less; what was found has more for it than is compared here",
    )
    least_other_turn: float = param(
        0.1,
        "how probable a mirrored turn is at least that is told beside a pose, and counted in its covariance; of flat "
        "objects another place, of it and the one told",
        low=0,
        high=0.5,
        paths=("space", "facing"),
        origin="of what is less probable 90 % regions need not know",
    )
    hidden_share: float = param(
        0.2,
        "share of an object's components that are in the image and not to be seen, for something unknown hides them: "
        "that one should be seen and is not, be it that enough of it is in the image, speaks against a place by no "
        "more; where several components are seen, each so, or all together, and then any number as easily",
        low=0.001,
        high=0.5,
        paths=("space", "facing"),
        origin="a film of a tool that a hand takes up: 35 of 158 images show one part of two; all of 27 that were told "
        "by a pose that lays the other part out of the picture were turned by half, at .92 to 1.0",
    )
    left_over_odds: tuple[float, ...] = param(
        (-0.58, -0.69, 2.5),
        "log odds against the pose of an object that leaves blobs unexplained which may be components that are not "
        "told: at first, and for each number that what is seen tells more than the pose and its joints have, up to so "
        "many: more of them bear out a wrong pose of a solid, too",
        low=-20,
        high=20,
        length=3,
        paths=("space", "facing"),
        origin="benchmarks/left_over.py; up to how many: 337 limbs and solids that leave something",
    )
    left_over_ratio: float = param(
        2.5,
        "such a blob is at most so many times larger or smaller than the component's marker would be",
        low=1,
        high=100,
        paths=("space", "facing"),
        origin="blur and shade make a patch a half larger or smaller, what slants it or hides half of it smaller",
    )
    lengths_off: float = param(
        0.15,
        "by what share of its distance from the nearest part that is seen such a blob may lie farther off than the "
        "object file allows: lengths may be off, or foreshortened",
        low=0,
        high=1,
        paths=("space", "facing"),
        origin="what lengths are off at most in benchmarks/random_limbs.py",
    )
    chance_share: float = param(
        0.4,
        "of the objects that chance makes of blobs of their classes and sizes that nothing explains, by their number, "
        "so many count against a flat object of several components: odds are divided by one and these",
        low=0,
        high=100,
        paths=("facing",),
        origin="benchmarks/chance.py: the most with which scores in usual images are as likely as without (log loss "
        ".185 -> .188, .98 told still); amid many like patches what is wrong at .5 or more 2836 -> 950, .96 of what is "
        "there and was told is told still. The number is an upper bound: places overlap",
    )
    mixed_up: tuple[float, ...] = param(
        (0.22, 0.71, 0.32),
        "how many times as easily chance bears out an object in space because round components of it look alike, more "
        "than once: so much, times the number of other ways to lay what is confirmed to this power, less this "
        "logarithm for each number that it tells more than the pose and its joints have",
        low=0.001,
        high=100,
        length=3,
        paths=("space",),
        origin="benchmarks/mixed_up.py: on worlds left out log-loss of dots .292 -> .216, of patterns .054 -> .050, of "
        "other objects .142 -> .143; of the other half of the worlds .31, .75, .20",
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
    most_by_size: float = param(
        2.0,
        "of rivals for what occurs once, by how much at most who explains more is likelier, log odds",
        low=0,
        high=100,
        paths=("space", "facing"),
        origin="there is the more clutter the smaller it is; a real gate of two poles amid reflections at .97, specks "
        "at .99, is right in 20 of 20 pictures with it; 2 leaves .95 before .6, whatever their sizes",
    )
    misread: float = param(
        0.02,
        "share of objects all of whose pixels show another identity than theirs (of what is followed "
        "sightings.misnamed), or that are of none that is declared; and of components that show another class",
        low=0.0001,
        high=1,
        paths=("space", "facing"),
        origin="overhead robots, as sightings.misnamed: against its pixels an object has a name that others leave from "
        "a score of .995 on",
    )

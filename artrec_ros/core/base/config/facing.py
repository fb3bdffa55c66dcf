"""Rooms `pose` and core: whole objects that face the camera."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param

_FACING = ("facing",)


@dataclass(frozen=True)
class FacingConfig(Room):
    """How blobs are searched for whole objects that are figures of the image plane."""

    guess_share: float = param(
        0.6,
        "what of the time for the search may go into first guesses",
        low=0.01,
        high=1,
        paths=_FACING,
        origin="about what they take; matters where the budget ends a search",
    )
    search_share: float = param(
        0.7,
        "what of the time that is left may go into the search",
        low=0.01,
        high=1,
        paths=_FACING,
        origin="the rest is for judging and telling many objects; matters where the budget ends a search",
    )
    judge_share: float = param(
        0.3,
        "what of the time that is left after the search may go into judging what it found",
        low=0.01,
        high=1,
        paths=_FACING,
        origin="the rest is for telling it",
    )
    grid_points: int = param(
        24,
        "pixels of a blob at which its component's middle is tried",
        low=4,
        high=10000,
        paths=_FACING,
        origin="2.5 px apart in a patch of 12 px: a climb makes the rest good",
    )
    turns: int = param(
        16, "directions that are tried", low=4, high=360, paths=_FACING, origin="22 degrees apart, likewise"
    )
    aligned: int = param(
        8,
        "alignments of the outline of an object that is one marker with that of a large blob that go on beside these",
        low=1,
        high=1000,
        paths=_FACING,
        origin="benchmarks/random_silhouettes.py: of 1440 scaled to a quarter and more 90 were missed, of open rings "
        "most; with these none",
    )
    disc_step: float = param(
        0.6,
        "where the component is a disc, in place of `turns`: by how much markers around it move at most from one "
        "direction that is tried to the next, as a share of their radius (twice the area over the perimeter)",
        low=0.05,
        high=2,
        paths=_FACING,
        origin="of 145 rendered robots of five discs of 7 to 10 px, without calibration, 8 were turned to where other "
        "discs of theirs are, with 16 directions; with this step none, with 0.9 one",
    )
    scale_ratio: float = param(
        1.25,
        "from one scale that is tried to the next",
        low=1.01,
        high=2,
        paths=_FACING,
        origin="half a step is 0.8 px at the edge of a patch of 14 px, likewise",
    )
    swollen_px: float = param(
        1.0,
        "by how much small markers may look larger than they are, all around: where their own pixels alone would tell "
        "the scale, the whole object's are asked, too, with markers that look larger by this and by half of it",
        unit="px",
        low=0.0,
        high=5,
        paths=_FACING,
        origin="blur, ink that runs, and what is dark around a marker; of 199 rendered mice with patches of 8 to 17 px "
        "166 had all parts right without, 187 with it",
    )
    swollen_most: int = param(
        100,
        "blobs of the required component's class up to which markers may look larger than they are",
        low=0,
        high=100000,
        paths=_FACING,
        origin="bounds the time in crowds: 600 robots in an image took half as long again",
    )
    least_area_share: float = param(
        0.4,
        "least area of the component relative to its blob",
        low=0.01,
        high=1,
        paths=_FACING,
        origin="two alike that touch are one blob",
    )
    sizes: int = param(
        2,
        "ranges of the component's size, one below the other, in which large blobs that nothing explains are searched; "
        "each reaches down to least_area_share of the one before",
        low=1,
        high=6,
        paths=_FACING,
        origin="near and far objects merge, and limbs of their class: of 154 rendered hands of eleven parts "
        "that overlap, two to four in a frame, one finds 64, two 86",
    )
    limb_blobs: int = param(
        48,
        "blobs of other components, the largest, from which objects are looked for that their own blob does not tell",
        low=0,
        high=10000,
        paths=_FACING,
        origin="bounds the time among clutter",
    )
    limb_guesses: int = param(
        4,
        "alignments of another component with a blob that go on, before its joints are bent",
        low=1,
        high=1000,
        paths=_FACING,
        origin="of 62 rendered hands of eleven parts that overlap, three find as many, and six one more; bounds the "
        "time",
    )
    limb_keep: int = param(
        64,
        "poses from each blob of other components that go on",
        low=1,
        high=1000,
        paths=_FACING,
        origin="the same: 16 and 32 find one fewer; of seven rendered crabs whose body bears no labels 32 find five, "
        "64 all; bounds the time",
    )
    least_share: float = param(
        0.4,
        "least votes of a hypothesis that is fitted and climbs, as a share of the best one's of its blob",
        low=0,
        high=1,
        paths=_FACING,
        origin="0.5 loses 4 of 1152 robots in benchmarks/overhead.py, 0 saves none",
    )
    per_patch: int = param(
        4,
        "hypotheses that go on, for each time the component goes into its blob, and for each blob of another one",
        low=1,
        high=1000,
        paths=_FACING,
        origin="a square's four turns; about a disc n markers have n (n - 1) to lie on each other's places",
    )
    most_pairs: int = param(
        2000,
        "where more pairs of an image's blobs may be two of an object's, far apart and with an outline, those alone go "
        "on under which more of its other markers lie on their classes than chance brings about once",
        low=0,
        high=1000000,
        paths=_FACING,
        origin="one object among 25 like patches makes some 10, eight among 60 make 350, six of five like squares "
        "among 20 more than 500, two hundred of one class and no object 7000; with 200 of 108 drawn objects among "
        "strays 103 are found for 107, and 15 others for 25",
    )
    rounds: tuple[int, ...] = param(
        (4, 5),
        "rounds of a climb of all hypotheses, and of another of the few that are left of each place",
        low=1,
        high=1000,
        length=2,
        paths=_FACING,
        origin="after four rounds the best of a place seldom changes; eight in place of five find no more",
    )
    first_step: float = param(
        0.7,
        "first steps of the first climb, in its units; of the other one half of them",
        low=0.01,
        high=100,
        paths=_FACING,
        origin="as the last climb's",
    )
    squeezed: float = param(
        1.05,
        "longest over shortest scale at some place of a given plane from which on it is looked at from above",
        low=1.0,
        high=100,
        paths=_FACING,
        origin="18 degrees of slant: less harms less than warping an image does",
    )
    horizon: float = param(
        0.1,
        "where a given plane has less than this share of its greatest scale in the image, nobody looks",
        low=0.001,
        high=1,
        paths=_FACING,
        origin="a view that reached the horizon would be endless; robots of 9 px are found beside ones of 70",
    )
    view_area: float = param(
        2.0,
        "most pixels of the view from above, in those of the image; the view's scale is less where it would have more",
        low=0.1,
        high=100,
        paths=_FACING,
        origin="bounds the time; a field that fills the image has 1.2 at 35 degrees",
    )
    cell_px: float = param(
        2.0,
        "hypotheses nearer than this in the image are one, if turn and scale are alike",
        unit="px",
        low=0.1,
        high=100,
        paths=_FACING,
        origin="a climb brings them to one place",
    )
    rivals: int = param(
        3,
        "hypotheses of one place that are judged: who else has its pixels decides which one it is",
        low=1,
        high=100,
        paths=_FACING,
        origin="the best, its fit to the contours, and one turned otherwise",
    )
    colour_ring_px: float = param(
        2.0,
        "votes.ring_px in colour images: rim and ring are looked at so far inside and outside of an outline",
        unit="px",
        low=0.1,
        high=20,
        paths=_FACING,
        origin="lenses, mosaics and compression carry a colour a pixel beyond its edge, and who draws outlines errs by "
        "half of one; 1.25, as of labels: real robots with a T .95 of 40 found, not 1.00, outlines half a pixel too "
        "small .82, not .95, a real hand .50 of 20, not 1.00",
    )
    colour_inside_empty: float = param(
        -3.5,
        "votes.inside_empty in colour images: on a marker, pixels of no class that lie amid such",
        low=-20,
        high=20,
        paths=_FACING,
        origin="as another class: shade and blur leave a colour a share of its class, where a label image's segmenter "
        "leaves nothing, and half of a marker in a highlight still has votes; random scenes: 98 wrong ones told, 106 "
        "at -2, of 976 right ones none less; -6: 97, and one less; label images: 76 and 77; quadrupeds in space, half "
        "of whose shaded patches is unknown: .983 found, not .995",
    )
    region_ring_px: float = param(
        1.0,
        "colours of and around a marker are looked at so far inside and outside of its outline",
        unit="px",
        low=0.5,
        high=20,
        paths=_FACING,
        origin="most of an edge's blur; at 2 px directions of squares of 16 px are off by 1.1 degrees, not by 0.9",
    )
    region_reach_px: float = param(
        1.5,
        "the last fit, to raw colours, moves an object's points by about so much",
        unit="px",
        low=0.1,
        high=20,
        paths=_FACING,
        origin="what blur and shade take from the labels' boundaries",
    )
    region_rounds: int = param(
        6,
        "rounds of the last fit, to raw colours",
        low=0,
        high=1000,
        paths=_FACING,
        origin="with ten, directions and names in benchmarks/overhead.py are no better",
    )

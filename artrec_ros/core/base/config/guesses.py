"""Room `pose`: where hypotheses of whole objects come from."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ConfigError
from .params import Room, param

_SPACE = ("space",)
_WHOLE = ("space", "facing")


@dataclass(frozen=True)
class GuessesConfig(Room):
    """How the views of a marker are laid on a blob, and how many of the poses that they stand for go on."""

    turns_rad: tuple[float, ...] = param(
        (0.4, 0.7, 0.95, 1.15, 1.32),
        "turns out of the image plane in which a marker is laid on a blob, besides none",
        unit="rad",
        low=0.05,
        high=1.5,
        paths=_SPACE,
        origin="cosines .92 .76 .58 .41 .25: neighbours look alike enough to refine from",
    )
    directions: int = param(
        6,
        "directions of the image in which a marker is turned out of its plane",
        low=1,
        high=72,
        paths=_SPACE,
        origin="30 degrees apart, a climb makes the rest good: with 4 right +3 of 244, with 8 +3",
    )
    solid_directions: int = param(
        100,
        "directions from which markers of one class that meet at an angle, as sides of a box do, are laid on a blob "
        "together",
        low=12,
        high=2000,
        paths=_SPACE,
        origin="20 degrees apart",
    )
    score_points: int = param(
        24,
        "points inside of a view, and on its outline, at which labels are looked up",
        low=8,
        high=400,
        paths=_WHOLE,
        origin="three vector instructions; enough to put views in order",
    )
    anchor_tolerance: float = param(
        0.02,
        "tolerance of the polygon that gives a view's anchors, as a share of its extent",
        low=0.001,
        high=0.5,
        paths=_SPACE,
        origin="leaves a dozen of a disc, and all corners of a polygon",
    )
    most_area_ratio: float = param(
        1.6,
        "greatest area of a view relative to its blob",
        low=1,
        high=100,
        paths=_WHOLE,
        origin="shade, or what hides it, may take a third of a blob; 2/3: right -3 of 244, 4/3: -3",
    )
    most_area_more_px: float = param(
        12.0,
        "greatest area of a view beyond most_area_ratio",
        unit="px^2",
        low=0,
        high=1000,
        paths=_WHOLE,
        origin="small blobs lose a pixel all around; a third either way changes 1 to 3 % of frames and no object, 60 "
        "loses one in 330",
    )
    least_area_px: float = param(
        14.0,
        "a view smaller than this in the image decides nothing",
        unit="px^2",
        low=1,
        high=10000,
        paths=_SPACE,
        origin="four pixels wide and high; 9 brings one false object in 350, 21 gets one wrong",
    )
    least_share: float = param(
        0.5,
        "least votes of an alignment, as a share of the best one's",
        low=0,
        high=1,
        paths=_SPACE,
        origin="bounds the time; 2/3 changes none of 160 frames, 4/3 nine and no object",
    )
    blob_keep: int = param(
        48,
        "alignments of a marker's views with a blob, and poses that they stand for, that go on",
        low=1,
        high=10000,
        paths=_SPACE,
        origin="2/3: right +3 of 244, 4/3: +1; bounds the time",
    )
    piece_ratio: float = param(
        4.0,
        "areas of what makes up a blob with others: from the blob's down to one that is so many times smaller, and "
        "from that on",
        low=1.2,
        high=100,
        paths=_SPACE,
        origin="two to four objects merge, and what is small beside them",
    )
    compact: float = param(
        0.9,
        "a blob is one piece where it fills its convex hull by more than this times what its markers do; others may be "
        "several merged ones",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="rendered hands and chains that face the camera: 0.95 finds one hand in fifty more, and half as many "
        "false ones again",
    )
    small_px: float = param(
        200.0,
        "so small a blob tells little of its marker's shape, and a segmenter may have taken much of it; what objects "
        "leave of one is searched only where it is larger; what faces the camera and lacks more is looked for again",
        unit="px^2",
        low=0,
        paths=_WHOLE,
        origin="14 px wide",
    )
    growth: tuple[float, ...] = param(
        (1.0, 1.2, 1.45),
        "scales that small blobs are tried at, relative to the alignment's; large ones at the first alone. Where range "
        "or scale are limited, a guess may be too near or too far by the greatest",
        low=0.1,
        high=10,
        paths=_SPACE,
        origin="what is left of 14 px when a segmenter takes two on each side is 10; 1.2 alone changes 5 of 220 "
        "frames and no object, none at all 41 and right +1",
    )
    joint_draws: int = param(
        10,
        "values of the joints that carry a component whose blob is started from, besides the middle ones",
        low=1,
        high=1000,
        paths=_WHOLE,
        origin="2/3: right -2 of 244, 4/3: -1",
    )
    few_guesses: int = param(
        24,
        "poses of an object in plain view that are fitted",
        low=1,
        high=10000,
        paths=_SPACE,
        origin="enough for most objects in plain view; 2/3: right +0 of 244, 4/3: +0",
    )
    few_keep: int = param(
        10,
        "poses of an object in plain view that go on",
        low=1,
        high=10000,
        paths=_SPACE,
        origin="enough for most objects in plain view; 2/3: right -1 of 244, 4/3: +1",
    )
    root_keep: int = param(
        40,
        "poses of the required component that go on from a blob",
        low=1,
        high=10000,
        paths=_SPACE,
        origin="2/3: right -1 of 244, 4/3: +1; bounds the time",
    )
    disc_poses: int = param(
        4,
        "of a required component that is a disc or a cylinder so many poses, those that lie or slant otherwise, are "
        "turned in all directions",
        low=1,
        high=1000,
        paths=("space",),
        origin="both mirrored turns, nearer and farther",
    )
    disc_turns: int = param(
        48,
        "directions in which what lies around such a one is looked for",
        low=1,
        high=1000,
        paths=("space",),
        origin="drawn lamps, masts and turtles on round feet, right of 270: 164 without, 206 with 36, 212 with 48, 207 "
        "with 72; a climb mends half a step",
    )
    limb_reach: float = param(
        2.0,
        "a blob of another class than the required component's is searched where one of its class is no farther off "
        "than so many times what the object reaches, as large as blobs show it",
        low=0,
        high=100,
        paths=_SPACE,
        origin="seen from aside by up to 75 degrees blobs look half as large as they are",
    )
    limb_root_share: float = param(
        0.02,
        "least area of that one, as a share of what the required component has by the scale of the other blob",
        low=0,
        high=1,
        paths=_SPACE,
        origin="less of it is no sign of an object: specks of its class, which bad segmentation leaves, would have all "
        "blobs searched",
    )
    limb_guesses: int = param(
        32,
        "poses of each other component that go on, before their joints are bent",
        low=1,
        high=10000,
        paths=_SPACE,
        origin="2/3: right +0 of 244, 4/3: +0; bounds the time",
    )
    limb_keep: int = param(
        64,
        "poses from all blobs of other components that go on",
        low=1,
        high=10000,
        paths=_SPACE,
        origin="2/3: right +0 of 244, 4/3: +0; bounds the time",
    )
    standing_slack: float = param(
        2.0,
        "where a floor is known: guesses may be off it, and lean, by so many times what objects may; they may lean by "
        "30 degrees, and be off by what a tenth of the range makes, in any case",
        low=1,
        high=100,
        paths=_SPACE,
        calibrated=True,
        origin="121 frames of a crowd of quadrupeds: at 1.5 one in forty right ones gets a limb wrong, at 2.5 a "
        "false one comes back",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("turns_rad", "growth"):
            if not getattr(self, name):
                raise ConfigError(f"expert.guesses.{name}: none is given; one or more are needed")

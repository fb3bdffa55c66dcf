"""How large an object's markers are and where its parts sit, from marked ends of axes in images: bundle adjustment.

Object files are measured with a ruler, or guessed. What many images show of a thing that moves in itself fits one set
of lengths alone, but for their common measure: that stays as the required component's first marker has it. Nothing
moves without need: the object file counts as one more measurement, which may be off by so much. Lengths are measured
with joints free, and judged within the limits that go with them (`joint_limits`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..geometry.camera import Camera
from ..model.objects import ObjectModel
from .joint_limits import Carried, LimitChange
from .lengths import Change, Lengths
from .marked_views import Eye, Marks, Start
from .view_fit import Far, Views

_LEAST_BETTER = 0.85  # of the distance that remains: else the object file holds as it is
LEAST_VIEWS = 4
MOST_VIEWS = 80  # seconds of work, and more tell hardly more


@dataclass(frozen=True)
class Measured:
    """:param model: the object with what was measured. :param views: how many were.
    :param extent_m: its diagonal as it was, all joints at 0.
    :param limits: joints whose zero or limits change with it. :param outside: joints whose limits in the object as it
        was hold not all that is marked, and the limits that would.
    :param before_px, after_px: median distance of marked ends from where they should be, joints within limits, by the
        object as it was and by what other views measure.
    :param far: marked axes, the farthest first, by what all measure.
    :param left_out: places of marked objects that are in no pose like the object.
    """

    model: ObjectModel
    extent_m: float
    changes: tuple[Change, ...]
    limits: tuple[LimitChange, ...]
    outside: tuple[LimitChange, ...]
    views: int
    before_px: float
    after_px: float
    far: tuple[Far, ...]
    left_out: tuple[str, ...]

    @property
    def helps(self) -> bool:
        """Whether what some views measure fits others clearly better than what the object file has."""
        return self.after_px < _LEAST_BETTER * self.before_px


@dataclass(frozen=True)
class TooFew:
    """Marked objects that tell too little: `LEAST_VIEWS` must be near to how the object may look.

    :param showing: how many show two markers or more. :param looked_at: of how many of these a pose was sought.
    :param near: how many are near to one. :param off_px: mean distance of marked ends from it, of those that are not.
    """

    showing: int
    looked_at: int
    near: int
    off_px: tuple[float, ...]


def measure(
    model: ObjectModel, marks: Sequence[Marks], camera: Camera | None, most: int = MOST_VIEWS
) -> Measured | TooFew:
    """The lengths that marked images tell of an object whose markers have places.

    :param camera: of the images; None: the object is flat, and seen straight from above by whatever camera.
    :param most: images that are used, evenly drawn.
    """
    showing = [m for m in marks if len(m.marker) > 1]
    marks = showing[:: -(-len(showing) // most) or 1]
    most_px = int(max((m.ends.max() for m in marks), default=1)) + 1
    eye = Eye(model, camera or Camera.facing((most_px, most_px)), camera is None)
    found = eye.starts(marks)
    starts = [start for start in found if start.near]
    if len(starts) < LEAST_VIEWS:
        return TooFew(len(showing), len(marks), len(starts), tuple(s.off_px for s in found if not s.near))
    return _measured(model, eye, marks, starts)


def _measured(model: ObjectModel, eye: Eye, marks: Sequence[Marks], starts: Sequence[Start]) -> Measured:
    """By the starts of some of the marks."""
    lengths, used = Lengths(model), {id(start.marks) for start in starts}
    halves = [Views(eye, lengths, half) for half in (starts[::2], starts[1::2])]
    found = [half.measured() for half in halves]
    before = np.concatenate([half.off_px(lengths.none, Carried.as_is(half.kin)) for half in halves])
    after = np.concatenate([half.off_px(*other) for half, other in zip(halves, found[::-1], strict=True)])
    views = Views(eye, lengths, starts)
    best, joints = views.measured()
    places = [start.marks.place for start in starts]
    return Measured(
        joints.model(lengths.model_of(best)), lengths.extent_m, tuple(lengths.changes(best)),
        tuple(joints.changes(model, places)), tuple(views.as_marked().changes(model, places)), len(starts),
        float(np.median(before)), float(np.median(after)), tuple(views.far(best)),
        tuple(m.place for m in marks if id(m) not in used),
    )  # fmt: skip

"""How large an object's markers are and where its parts sit, from marked ends of axes in images: bundle adjustment.

Object files are measured with a ruler, or guessed. What many images show of a thing that moves in itself fits one set
of lengths alone, but for their common measure: that stays as the required component's first marker has it. Nothing
moves without need: the object file counts as one more measurement, which may be off by so much. Lengths are measured
with joints free, and judged within the limits that go with them (`joint_limits`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..geometry.camera import Camera
from ..geometry.transforms import Array
from ..model.objects import ObjectModel
from .joint_limits import Carried, LimitChange
from .lengths import Change, Lengths
from .marked_views import Eye, Marks, Start
from .view_fit import Far, Views

_LEAST_BETTER = 0.85  # of the distance that remains: else the object file holds as it is
LEAST_VIEWS = 4
MOST_VIEWS = 80  # seconds of work, and more tell hardly more


@dataclass(frozen=True)
class Kept:
    """A joint that stays. :param apart: how far apart halves of the marked objects put it, of the object's extent;
    None: with what is marked its limits would be beyond a whole turn."""

    name: str
    apart: float | None


@dataclass(frozen=True)
class Measured:
    """:param model: the object with what was measured. :param views: how many were. :param showing: how many show
        two markers or more, of which `MOST_VIEWS` at most are looked at.
    :param extent_m: its diagonal as it was, all joints at 0.
    :param limits: joints whose zero or limits change with it. :param outside: joints whose limits in the object as it
        was hold not all that is marked, and the limits that would.
    :param before_px, after_px: median distance of marked ends from where they should be, joints within limits, by the
        object as it was and by what other views measure.
    :param far: marked axes, the farthest first, by what all measure.
    :param left_out: places of marked objects that are in no pose like the object.
    :param kept: joints that marks do not determine, and which stay.
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
    kept: tuple[Kept, ...] = ()
    showing: int = 0

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
    return replace(_measured(model, eye, marks, starts), showing=len(showing))


def _measured(model: ObjectModel, eye: Eye, marks: Sequence[Marks], starts: Sequence[Start]) -> Measured:
    """By the starts of some of the marks."""
    fit, kept = _Fit.of(model, eye, starts, {}), dict[str, Kept]()
    while (unsure := fit.undetermined(kept)) is not None:
        kept |= unsure
        fit = _Fit.of(model, eye, starts, kept)
    joints = fit.joints.without(fit.joints.too_wide(fit.views.kin), fit.views.kin)
    before = np.concatenate([half.off_px(fit.lengths.none, Carried.as_is(half.kin)) for half in fit.halves])
    after = np.concatenate([half.off_px(*other) for half, other in zip(fit.halves, fit.found[::-1], strict=True)])
    places, used = [start.marks.place for start in starts], {id(start.marks) for start in starts}
    return Measured(
        joints.model(fit.lengths.model_of(fit.best)), fit.lengths.extent_m, tuple(fit.lengths.changes(fit.best)),
        tuple(joints.changes(model, places)), tuple(fit.views.as_marked().changes(model, places)), len(starts),
        float(np.median(before)), float(np.median(after)), tuple(fit.views.far(fit.best)),
        tuple(m.place for m in marks if id(m) not in used), tuple(kept.values()),
    )  # fmt: skip


@dataclass(frozen=True)
class _Fit:
    """Lengths with some joints in place. :param found: what each half of the views measures. :param best, joints: what
    all do."""

    lengths: Lengths
    halves: Sequence[Views]
    found: Sequence[tuple[Array, Carried]]
    views: Views
    best: Array
    joints: Carried

    @classmethod
    def of(cls, model: ObjectModel, eye: Eye, starts: Sequence[Start], kept: Collection[str]) -> _Fit:
        lengths = Lengths(model, kept)
        halves = [Views(eye, lengths, half) for half in (starts[::2], starts[1::2])]
        views = Views(eye, lengths, starts)
        return cls(lengths, halves, [half.measured() for half in halves], views, *views.measured())

    def undetermined(self, kept: Collection[str]) -> dict[str, Kept] | None:
        """A component whose joint these views do not determine, the worst alone, for with it in place others may be
        found: halves of them, half of whose difference is the deviation of what all tell, put it farther apart than the
        object file may be off; else one whose limits come to be beyond a whole turn. :param kept: those in place."""
        model = self.views.kin.model
        one, other = (self.lengths.joints(values) for values, _ in self.found)
        off = {name: one[name] - other[name] for name in one}
        worst = max(off, key=lambda name: float(np.linalg.norm(off[name])), default=None)
        if worst is not None and np.sqrt(np.mean(off[worst] ** 2)) / 2 > 1.0:
            return {worst: Kept(_called(model, worst), self.lengths.apart(off[worst]))}
        wide = zip(model.joint_components, self.joints.too_wide(self.views.kin), strict=True)
        found = next((c.name for c, beyond in wide if beyond and c.name not in kept), None)
        return None if found is None else {found: Kept(_called(model, found), None)}


def _called(model: ObjectModel, component: str) -> str:
    """A component's joint, as it is called in results."""
    joint = model.component(component).joint
    return (joint and joint.name) or component

"""What went wrong in a frame, and why, as far as results and truth tell."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...core.geometry.transforms import Array
from ...core.model.found import Detection, Instance
from ...io.results.summary_file import LookedFor
from ...io.truth.records import TrueObject
from .metrics import extent_px, is_on, places_of, reach_px
from .outcomes import Outcome
from .scoring import Evaluation, ScoredFrame

MISSED, NOT_RIGHT, MISNAMED, FAR_OFF, FALSE = "missed", "not right", "wrong name", "far off", "false"
_NEAR = 1.0  # of an object, in its apparent sizes
# a right one is far off that is farther off than these, a share of the range and an angle, and than so many medians
_FAR, _FAR_RAD, _FAR_TIMES = 0.02, math.radians(10), 5.0


@dataclass(frozen=True)
class Failure:
    """:param kind: MISSED, NOT_RIGHT, MISNAMED, FAR_OFF or FALSE. :param name: the object's.
    :param place: (2,) pixels, where known. :param radius_px: about how large it is there."""

    kind: str
    name: str
    reason: str
    place: Array | None
    radius_px: float


@dataclass(frozen=True)
class FailedFrame:
    """A frame with what failed in it."""

    frame: ScoredFrame
    failures: tuple[Failure, ...]


def failed_frames(evaluation: Evaluation) -> list[FailedFrame]:
    """The frames in which anything failed, in order."""
    far = _Far.of(evaluation)
    found = [FailedFrame(f, tuple(_failures(f, evaluation.run.objects, far))) for f in evaluation.frames]
    return [f for f in found if f.failures]


class _Far(NamedTuple):
    """From which errors on a right object is far off: of its place, as a share of the range, and of its turn."""

    place: float
    turn_rad: float

    @classmethod
    def of(cls, evaluation: Evaluation) -> _Far:
        right = [o for _, o in evaluation.outcomes() if o.counted and o.right is not False]
        places = [e for e in (o.position_error for o in right) if e is not None]
        turns = [e for e in (o.rotation_error_rad for o in right) if e is not None]
        times = [_FAR_TIMES * float(np.median(off)) if off else 0.0 for off in (places, turns)]
        return cls(max(_FAR, times[0]), max(_FAR_RAD, times[1]))

    def says(self, outcome: Outcome) -> str:
        """How far off it is; empty: it is not far."""
        place, turn = outcome.position_error, outcome.rotation_error_rad
        if place is None or turn is None or (place <= self.place and turn <= self.turn_rad):
            return ""
        return f"its place is {place:.1%} of the range off, its turn {math.degrees(turn):.0f} degrees"


def _failures(frame: ScoredFrame, objects: Mapping[str, LookedFor], far: _Far) -> Iterator[Failure]:
    for name, part in frame.by_name.items():
        root = objects[name].required
        for outcome in part.outcomes:
            if not outcome.counted:
                continue
            if outcome.recognised and outcome.own_name is False:
                kind, reason = MISNAMED, _why_misnamed(outcome)
            elif outcome.recognised and outcome.right is not False:
                kind, reason = FAR_OFF, far.says(outcome)
            elif outcome.recognised:
                kind, reason = NOT_RIGHT, _why_not_right(outcome, root)
            else:
                kind, reason = MISSED, _why_missed(outcome, name, root, frame)
            if not reason:
                continue
            place = next(iter(places_of(outcome.truth, root)), None)
            yield Failure(kind, name, reason, place, extent_px(outcome.truth))
        for d in part.false:
            place = np.array([d.image.x, d.image.y])
            yield Failure(FALSE, name, _why_false(d, name, frame, objects), place, _radius_px(d))


def _why_misnamed(outcome: Outcome) -> str:
    found = outcome.detection
    assert found is not None and found.identity is not None
    told, share = found.identity.name, found.identity.probability
    called = f"told as {found.object}_{told} with {share:.0%}" if told else "told by no name"
    return f"it is {found.object}_{outcome.identity}, and {called}"


def _why_not_right(outcome: Outcome, root: str) -> str:
    assert outcome.detection is not None
    wrong = {component for component, hit in outcome.hits if not hit}
    reasons = [_where(c, outcome) for c in outcome.detection.components if c.component in wrong]
    reasons += [f"{component} was missed" for component in sorted(outcome.missed)]
    return "; ".join(reasons) or f"{root} lies elsewhere"


def _where(instance: Instance, outcome: Outcome) -> str:
    on = [name.removesuffix("@") for name, c in outcome.truth.components.items() if is_on(instance, c)]
    return f"{instance.component} lies on {on[0]}" if on else f"{instance.component} lies on none of its markers"


def _why_missed(outcome: Outcome, name: str, root: str, frame: ScoredFrame) -> str:
    record, truth = frame.record, outcome.truth
    if record is None:
        return "the replay has no result for this frame"
    if record.error is not None:
        return f"the frame could not be used: {record.error}"
    if others := taken_for(outcome, name, root, frame):
        return f"taken for '{others[0]}'"
    rejected = [r for r in record.rejected if r.object == name and _is_near(r.x, r.y, truth, root)]
    if rejected:
        best = max(rejected, key=lambda r: r.score)
        return f"turned down: {best.reason}"
    return "no candidate near it" + (f"; {' and '.join(record.ended_by)} ended the search" if record.ended_by else "")


def taken_for(outcome: Outcome, name: str, root: str, frame: ScoredFrame) -> list[str]:
    """Names of the other objects that were found where this one is."""
    detections = frame.record.detections if frame.record else ()
    others = (d for d in detections if d.object != name)
    return sorted({d.object for d in others if _is_near(d.image.x, d.image.y, outcome.truth, root)})


def _is_near(x: float, y: float, truth: TrueObject, root: str) -> bool:
    reach = _NEAR * extent_px(truth)
    return any(np.hypot(x - p[0], y - p[1]) <= reach for p in places_of(truth, root))


def _why_false(d: Detection, name: str, frame: ScoredFrame, objects: Mapping[str, LookedFor]) -> str:
    for other, part in frame.by_name.items():
        for outcome in part.outcomes:
            gaps = [
                np.hypot(d.image.x - p[0], d.image.y - p[1]) for p in places_of(outcome.truth, objects[other].required)
            ]
            if min(gaps, default=np.inf) > _NEAR * extent_px(outcome.truth):
                continue
            if other != name:
                return f"score {d.score:.2f}: lies on '{other}'"
            told = f"score {d.score:.2f}: {min(gaps):.3g} px from an object '{name}'"
            if outcome.detection is not None:
                return f"{told}; another detection lies there, too"
            return f"{told}, which it would be up to {reach_px(outcome.truth):.3g} px, half of its size"
    return f"score {d.score:.2f}: no object there"


def _radius_px(d: Detection) -> float:
    """Half of what its components span, and a little more."""
    places = np.array([[c.x, c.y] for c in d.components] or [[d.image.x, d.image.y]])
    return float(max(8.0, 0.7 * np.ptp(places, axis=0).max()))

"""How well detections agree with truth: the rules, frame by frame, and counts that add up; rates divide last.

An object counts when its required component is in view: one of its markers has 30 px or more, half of it visible.
It is recognised when a detection of its name lies on it, one detection an object (the assignment with the least sum
of distances). It is right when, besides, every component of the detection lies on that object's own component and no
well visible component is missed. Components of which the truth does not speak are not judged.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from ...core.geometry.transforms import Array, wrap_angle
from ...core.model.found import Detection, Instance
from ...io.truth.records import Told, TrueComponent, TrueObject
from .image_errors import image_errors
from .outcomes import FrameOutcome, Outcome
from .same_looks import told_otherwise

COUNTED_PX, COUNTED_SHARE = 30.0, 0.5  # the least required component of an object that counts
_EXPECTED_PX, _EXPECTED_SHARE = 25.0, 0.7  # the least other component whose absence is a miss
_NEAR = 0.5  # farthest detection of an object, in square roots of its largest marker's area
_LEAST_EXTENT_PX = 4.0
_ON_COMPONENT, _ON_COMPONENT_PX = 0.35, 1.0  # the same of a component, and pixels besides
_LEAST_COMPONENT_PX = 9.0
_FAR = 1e3  # the distance of pairs that no assignment should make


def turned_by(error_rad: float) -> float:
    """How far a joint that turns is off, radians: no more than half a turn."""
    return float(abs(wrap_angle(error_rad)))


@dataclass(frozen=True)
class Counts:
    """What was counted over some frames; counts of different frames or names add up."""

    frames: int = 0
    frames_without_result: int = 0
    objects: int = 0
    recognised: int = 0
    judged: int = 0  # objects of whose components the truth speaks
    right: int = 0
    false: int = 0
    named: int = 0  # objects found of which the truth says which of several like ones each is
    names_right: int = 0
    names_wrong: int = 0  # told by another's; those of none are neither
    components_right: int = 0
    components_wrong: int = 0
    components_missed: int = 0
    position_errors: tuple[float, ...] = ()
    position_errors_m: tuple[float, ...] = ()
    rotation_errors_rad: tuple[float, ...] = ()
    joint_errors_rad: tuple[float, ...] = ()
    joint_errors_m: tuple[float, ...] = ()
    image_errors_px: tuple[float, ...] = ()
    direction_errors_rad: tuple[float, ...] = ()

    def __add__(self, other: Counts) -> Counts:
        return Counts(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(self)))

    @classmethod
    def of(cls, outcomes: Iterable[Outcome], sliding: Iterable[str] = ()) -> Counts:
        """Of true objects; of false detections they tell nothing. :param sliding: names of the prismatic joints."""
        counted = [o for o in outcomes if o.counted]
        met = [o for o in counted if o.detection is not None]
        sliding = frozenset(sliding)
        joints = [(name in sliding, e) for o in met for name, e in o.joint_errors.items()]
        hits = [hit for o in met for _, hit in o.hits]
        return cls(
            objects=len(counted),
            recognised=len(met),
            judged=sum(o.right is not None for o in counted),
            right=sum(o.right is True for o in counted),
            named=sum(o.own_name is not None for o in met),
            names_right=sum(o.own_name is True for o in met),
            names_wrong=sum(o.anothers_name for o in met),
            components_right=sum(hits),
            components_wrong=len(hits) - sum(hits),
            components_missed=sum(len(o.missed) for o in met),
            position_errors=_known(o.position_error for o in met),
            position_errors_m=_known(o.position_error_m for o in met),
            rotation_errors_rad=_known(o.rotation_error_rad for o in met),
            joint_errors_rad=tuple(turned_by(e) for slides, e in joints if not slides),
            joint_errors_m=tuple(e for slides, e in joints if slides),
            image_errors_px=tuple(px for o in met for px, _ in o.image_errors),
            direction_errors_rad=_known(rad for o in met for _, rad in o.image_errors),
        )

    def rates(self) -> dict[str, float | None]:
        """The figures that rank set-ups, without intervals. None: there was nothing to measure."""
        found = self.components_right + self.components_wrong
        return {
            "recognition_rate": _ratio(self.recognised, self.objects),
            "precision": _ratio(self.recognised, self.recognised + self.false),
            "right_rate": _ratio(self.right, self.judged),
            "false_per_frame": _ratio(self.false, self.frames),
            "component_precision": _ratio(self.components_right, found),
            "component_recall": _ratio(self.components_right, self.components_right + self.components_missed),
            "position_error_median": _median(self.position_errors),
            "rotation_error_deg_median": _median(np.degrees(self.rotation_errors_rad)),
        }


def judge_frame(
    objects: Sequence[TrueObject],
    detections: Sequence[Detection],
    root: str,
    siblings: Sequence[Mapping[str, str]] = (),
) -> FrameOutcome:
    """One object name in one frame. An object that does not count excuses the detection that lies on it.

    :param siblings: see there: how else an object may be told that looks the same so.
    """
    ways = [[o, *(told_otherwise(o, names) for names in siblings)] for o in objects]
    distances = np.array([[min(_distance(way, d, root) for way in of) for d in detections] for of in ways])
    pairs: dict[int, int] = {}
    if distances.size:
        rows, columns = linear_sum_assignment(distances)
        pairs = {int(i): int(j) for i, j in zip(rows, columns, strict=True) if distances[i, j] <= _NEAR}
    outcomes = tuple(
        _judge_best(of, detections[pairs[i]], root) if i in pairs else _missed_object(of[0], root)
        for i, of in enumerate(ways)
    )
    used = set(pairs.values())
    return FrameOutcome(outcomes, tuple(d for j, d in enumerate(detections) if j not in used))


def _judge_best(ways: Sequence[TrueObject], d: Detection, root: str) -> Outcome:
    """A detection of an object by the way to tell it that suits it best, of those that look the same."""
    o, near = ways[0], [way for way in ways if _distance(way, d, root) <= _NEAR]
    outcomes = [_judge(way, d, root) for way in near]
    best = max(outcomes, key=lambda one: sum(hit for _, hit in one.hits) - len(one.missed))
    return replace(best, truth=o, counted=_is_in_view(o, root))


def _is_in_view(o: TrueObject, root: str) -> bool:
    """Whether an object counts: enough of its required component can be seen."""
    return any(_is_seen(c) for name, c in o.components.items() if shows(name, root))


def shows_others(o: TrueObject) -> bool:
    """Whether so much can be seen of any component."""
    return any(map(_is_seen, o.components.values()))


def _is_seen(c: TrueComponent) -> bool:
    return c.centre is not None and c.full_px >= COUNTED_PX and c.visible_px >= COUNTED_SHARE * c.full_px


def shows(truth_name: str, component: str) -> bool:
    """Whether a name of the truth ('front_left@front', 'torso_left') is one of this component's markers."""
    name = truth_name.split("@")[0]
    return name == component or (name == truth_name and name.startswith(component + "_"))


def places_of(o: TrueObject, root: str) -> list[Array]:
    """Where in the image a detection of an object may have its required component."""
    places = [c.centre for name, c in o.components.items() if shows(name, root)] + [o.centre_px]
    return [p for p in places if p is not None]


def extent_px(o: TrueObject) -> float:
    """Apparent size: the square root of the largest marker's area."""
    return max(max((c.full_px for c in o.components.values()), default=1.0) ** 0.5, _LEAST_EXTENT_PX)


def reach_px(o: TrueObject) -> float:
    """How far off a detection of an object may lie at most."""
    return _NEAR * extent_px(o)


def is_on(instance: Instance, truth_component: TrueComponent) -> bool:
    """Whether an instance lies on a marker of the truth."""
    c = truth_component
    if c.centre is None:
        return False
    reach = _ON_COMPONENT * max(c.full_px, _LEAST_COMPONENT_PX) ** 0.5 + _ON_COMPONENT_PX
    return _offset(instance.x, instance.y, c.centre) <= reach


def _distance(o: TrueObject, d: Detection, root: str) -> float:
    """From the detection's required component to the object's, over the object's apparent size. Where the truth does
    not tell that one, as of an object whose annotator could not see it, from any other one to the object's own."""
    offsets = [_offset(d.image.x, d.image.y, p) for p in places_of(o, root)]
    if not any(shows(name, root) for name in o.components):
        own = [(name, c.centre) for name, c in o.components.items() if c.centre is not None]
        offsets += [_offset(c.x, c.y, at) for c in d.components for name, at in own if shows(name, c.component)]
    return min(offsets, default=_FAR) / extent_px(o)


def _missed_object(o: TrueObject, root: str) -> Outcome:
    return Outcome(o, _is_in_view(o, root), right=None if o.told is Told.REQUIRED else False)


def _judge(o: TrueObject, d: Detection, root: str) -> Outcome:
    hits = [(c.component, hit) for c in d.components if (hit := _is_on_its_component(c, o)) is not None]
    missed = _missed(o, {c.component for c in d.components}, root)
    right = None if o.told is Told.REQUIRED else all(hit for _, hit in hits) and not missed
    others = tuple((component, hit) for component, hit in hits if component != root)
    return Outcome(o, _is_in_view(o, root), d, others, frozenset(missed), right, image_errors(d, o))


def _is_on_its_component(instance: Instance, o: TrueObject) -> bool | None:
    """None: the truth does not speak of this component."""
    own = [c for name, c in o.components.items() if c.centre is not None and shows(name, instance.component)]
    if not own and o.told is not Told.ALL:
        return None
    return any(is_on(instance, c) for c in own)


def _missed(o: TrueObject, found: set[str], root: str) -> set[str]:
    """Components that are well visible and were not found."""

    def is_expected(c: TrueComponent) -> bool:
        return c.full_px >= _EXPECTED_PX and c.visible_px >= _EXPECTED_SHARE * c.full_px

    expected = {name.split("@")[0] for name, c in o.components.items() if is_expected(c) and not shows(name, root)}
    return expected - found


def _offset(x: float, y: float, point: Array) -> float:
    return float(np.hypot(x - point[0], y - point[1]))


def _known(values: Iterable[float | None]) -> tuple[float, ...]:
    return tuple(v for v in values if v is not None)


def _ratio(part: int, whole: int) -> float | None:
    return part / whole if whole else None


def _median(values: Sequence[float] | Array) -> float | None:
    return float(np.median(values)) if len(values) else None

"""Where the figures come from: component by component, and which name was taken for which."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from . import intervals
from .failures import taken_for
from .intervals import Estimate
from .metrics import turned_by
from .outcomes import Outcome
from .scoring import Evaluation

NOTHING = "nothing"


@dataclass(frozen=True)
class ComponentCounts:
    """One component of one object name, of the objects that count.

    :param found: lies on its own marker. :param wrong: does not. :param missed: well visible, and not found.
    :param joint_error: what 95 % of its joint's errors are below, degrees or, where it `slides`, millimetres.
    """

    object: str
    component: str
    found: int
    wrong: int
    missed: int
    joint_error: Estimate = Estimate()
    slides: bool = False

    @property
    def precision(self) -> Estimate:
        return intervals.rate(self.found, self.found + self.wrong)


def component_counts(evaluation: Evaluation) -> list[ComponentCounts]:
    """The required component, for which the object as a whole stands, first; then the others by name.

    Other components are judged on objects that were found.
    """
    rows = []
    for name in evaluation.names:
        outcomes = [o for _, o in evaluation.outcomes([name]) if o.counted]
        root = evaluation.run.objects[name].required
        found = sum(o.recognised for o in outcomes)
        rows.append(ComponentCounts(name, root, found, sum(1 for _ in evaluation.false([name])), len(outcomes) - found))
        hits = Counter(hit for o in outcomes for hit in o.hits)
        missed = Counter(component for o in outcomes if o.recognised for component in o.missed)
        joints = _joints(evaluation, name)
        for component in sorted({c for c, _ in hits} | {*missed}):  # so that two runs list them alike
            joint = joints.get(component, component)
            slides = joint in evaluation.sliding.get(name, ())
            error = _joint_error(outcomes, joint, slides)
            counts = hits[component, True], hits[component, False], missed[component]
            rows.append(ComponentCounts(name, component, *counts, error, slides))
    return rows


def _joints(evaluation: Evaluation, name: str) -> dict[str, str]:
    """What the joints that carry an object's components are called, as far as its file is known."""
    model = evaluation.run.models.get(name)
    if model is None:
        return {}
    return {c.name: joint for c, joint in zip(model.joint_components, model.joint_names, strict=True)}


def _joint_error(outcomes: Sequence[Outcome], joint: str, slides: bool) -> Estimate:
    """What 95 % of a joint's errors are below: its component may lie on its marker while it is wrong."""
    errors = [o.joint_errors[joint] for o in outcomes if joint in o.joint_errors]
    inside = [1e3 * e if slides else float(np.degrees(turned_by(e))) for e in errors]
    return intervals.quantile(inside, 0.95)


def confusion(evaluation: Evaluation) -> dict[str, Counter[str]]:
    """True name -> how often it was found as which name, or as `NOTHING`.

    Under `NOTHING`: detections, by name, that lie on no object of any name.
    """
    found: dict[str, Counter[str]] = {name: Counter() for name in [*evaluation.names, NOTHING]}
    for true, seen in _taken(evaluation):
        found[true][seen] += 1
    return found


def _taken(evaluation: Evaluation) -> Iterator[tuple[str, str]]:
    roots = {name: o.required for name, o in evaluation.run.objects.items()}
    for frame in evaluation.frames:
        claimed: Counter[str] = Counter()
        for name, part in frame.by_name.items():
            for outcome in (o for o in part.outcomes if o.counted):
                others = [] if outcome.recognised else taken_for(outcome, name, roots[name], frame)
                claimed.update(others[:1])
                yield name, name if outcome.recognised else next(iter(others), NOTHING)
        for name, part in frame.by_name.items():
            for _ in range(max(0, len(part.false) - claimed[name])):
                yield NOTHING, name

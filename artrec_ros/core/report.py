"""Groups turned into detections, and candidates that became no object into reasons."""

from __future__ import annotations

import numpy as np

from .axis_offsets import AxisOffset
from .candidates import Candidates, violations
from .config import RecognizerConfig
from .constraints import ConstraintSet
from .datatypes import Detection, ImagePose, Instance, Rejection, Target
from .grouping import Group, GroupSearch
from .matching import Matches
from .pairs import Key, configuration
from .solution import Solution
from .transforms import wrap_angle

_MAX_REJECTIONS = 20  # a frame; the strongest


def instance_of(candidates: Candidates, n: int, matches: Matches) -> Instance:
    """A candidate as users see it."""
    component, marker = candidates.key(n)
    pose, match = candidates.poses, int(candidates.match[n])
    outline = matches.shapes[matches.placed.shape[match]].outline @ np.array([1, 1j])
    where = matches.placed.take(np.array([match])).where(outline)[0]
    contour = np.stack([where.real, where.imag], axis=1)
    return Instance(
        component,
        marker,
        float(candidates.score[n]),
        float(pose.x[n]),
        float(pose.y[n]),
        float(pose.theta[n]),
        float(pose.scale[n]),
        contour,
    )


def detections_of(
    groups: list[Group], matches: Matches, targets: tuple[Target, ...], *, as_annotated: bool = False
) -> tuple[Detection, ...]:
    """Detections by target and score; ids count within a target.

    :param as_annotated: directions of axes are those that annotations would have, where training knows how.
    """
    detections = []
    for target in targets:
        mine = sorted((g for g in groups if g.candidates.target is target), key=lambda g: -g.score)
        for number, group in enumerate(mine):
            order = sorted(group.members, key=lambda n: int(group.candidates.component[n]))
            parts = tuple(instance_of(group.candidates, n, matches) for n in order)
            if as_annotated:
                parts = tuple(_as_annotated(p, target) for p in parts)
            base = next(p for p in parts if p.component == target.model.required.name)
            image = ImagePose(base.x, base.y, base.theta, base.scale)
            detections.append(Detection(target.name, number, group.score, image, parts))
    return tuple(detections)


def _as_annotated(instance: Instance, target: Target) -> Instance:
    learned = target.constraints
    axes: dict[Key, AxisOffset] = {a.key: a for a in learned.axes} if isinstance(learned, ConstraintSet) else {}
    axis = axes.get((instance.component, instance.marker))
    if axis is None:
        return instance
    return axis.corrected(instance, target.model.component(instance.component).marker(instance.marker))


def rejections_of(
    solution: Solution, searches: list[GroupSearch], matches: Matches, config: RecognizerConfig
) -> tuple[Rejection, ...]:
    """Why instances of required components became no object, the strongest candidates first."""
    used = {m for g in solution.accepted for m in g.matches}
    grouped = {g.seed: g for g in reversed(solution.lost)}
    rows = []
    for search in searches:
        told: set[int] = set()
        for seed in search.seeds[np.argsort(-search.candidates.score[search.seeds], kind="stable")]:
            match = int(search.candidates.match[seed])
            if match in used or match in told or len(told) >= _MAX_REJECTIONS:
                continue
            told.add(match)  # once an instance, whichever way it is turned
            if used and float(matches.overlap[match, sorted(used)].max()) > config.max_overlap:
                reason = "its pixels belong to an object that explains more"
            elif match in grouped:
                reason = _reason_lost(grouped[match])
            else:
                reason = _reason_alone(search, int(seed), config)
            rows.append(_rejection(search.candidates, int(seed), reason))
    return tuple(sorted(rows, key=lambda r: -r.score)[:_MAX_REJECTIONS])


def _rejection(candidates: Candidates, n: int, reason: str) -> Rejection:
    name, pose = candidates.key(n)[0], candidates.poses
    return Rejection(
        candidates.target.name, f"{name}: {reason}", float(candidates.score[n]), float(pose.x[n]), float(pose.y[n])
    )


def _reason_lost(group: Group) -> str:
    return f"a group of {len(group.members)} components loses its pixels, or leaves its blobs' contours unexplained"


def _reason_alone(search: GroupSearch, seed: int, config: RecognizerConfig) -> str:
    """Which constraint fails by the least, in which dimension, by how much."""
    c, table = search.candidates, search.table
    others = [comp.name for comp in c.target.model.components if not comp.required]
    near = np.flatnonzero(~table.forbidden[seed] & table.checked[seed])
    if not len(near):
        return f"no instance of {' or '.join(others)} with a learned constraint and a like scale"
    best = int(near[np.argmin(table.violation[seed, near])])
    if table.violation[seed, best] <= 0:
        return f"too few components ({config.min_components} are wanted) or too few of their constraints hold"
    constraints = c.target.constraints
    assert isinstance(constraints, ConstraintSet)  # something was checked
    swap = constraints.pair(c.key(seed), c.key(best)) is None
    first, second = (best, seed) if swap else (seed, best)
    pair = constraints.pair(c.key(first), c.key(second))
    assert pair is not None
    a, b = c.poses.at(np.array([first])), c.poses.at(np.array([second]))
    outside = violations(pair, a, b, config)
    worst = max(outside, key=lambda d: float(outside[d][0]))
    value, interval = float(configuration(a, b)[worst][0]), pair.allowed[worst]
    if interval.period:
        value = float(wrap_angle(value - interval.low, interval.period)) + interval.low
    return (
        f"nearest is {'/'.join(c.key(best))} at ({c.poses.x[best]:.0f}, {c.poses.y[best]:.0f}), "
        f"but {worst} {value:.3g} lies {float(outside[worst][0]):.3g} outside {interval.low:.3g} to {interval.high:.3g}"
    )

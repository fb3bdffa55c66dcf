"""Why a candidate of the image plane became no object: what failed, in which dimension, by how much."""

from __future__ import annotations

import numpy as np

from ..base.config import RecognizerConfig
from ..constraints.constraint_set import ConstraintSet
from ..constraints.pair_boxes import reach_m
from ..constraints.pairs import PairConstraint, configuration, configuration_noise
from ..geometry.transforms import Array, wrap_angle
from ..grouping.candidates import Candidates, ImagePoses
from ..grouping.group_search import GroupSearch
from ..grouping.solution import Lost
from ..model.frame_result import ConstraintFailure


def failure_of(candidates: Candidates, a: int, b: int) -> ConstraintFailure | None:
    """The dimension in which two candidates violate their constraint most; None where they satisfy it, or have none."""
    constraints = candidates.target.constraints
    if not isinstance(constraints, ConstraintSet):
        return None
    first, second = (b, a) if constraints.pair(candidates.key(a), candidates.key(b)) is None else (a, b)
    pair = constraints.pair(candidates.key(first), candidates.key(second))
    if pair is None:
        return None
    left, right = (candidates.poses.at(np.array([n])) for n in (first, second))
    outside = {d: float(v[0]) for d, v in violations(pair, left, right).items()}
    reach = reach_m(pair)
    worst = max(outside, key=lambda d: outside[d] / reach if d.endswith("_m") else outside[d])
    if outside[worst] <= 0:
        return None
    value, interval = float(configuration(left, right)[worst][0]), pair.allowed[worst]
    if interval.period:
        value = float(wrap_angle(value - interval.low, interval.period)) + interval.low
    names = tuple("/".join(candidates.key(n)) for n in (first, second))
    return ConstraintFailure(names[0], names[1], worst, value, interval.low, interval.high, outside[worst])


def violations(p: PairConstraint, first: ImagePoses, second: ImagePoses) -> dict[str, Array]:
    """Per dimension, by how much T_ij lies outside what is allowed beyond twice its noise; 0 inside."""
    T = configuration(first, second)
    noise = configuration_noise(first, second, T)
    return {d: np.maximum(interval.excess(T[d]) - 2 * noise[d], 0.0) for d, interval in p.allowed.items() if d in noise}


def text_of(failure: ConstraintFailure) -> str:
    return (
        f"{failure.dimension} {failure.value:.3g} lies {failure.outside:.3g} outside {failure.low:.3g} to "
        f"{failure.high:.3g}"
    )


def reason_lost(lost: Lost, config: RecognizerConfig) -> str:
    """Why a group that could have been an object is none."""
    group = lost.group
    if lost.explained is not None:
        return (
            f"a group of {len(group.members)} components explains {lost.explained:.2f} of its blobs' contours, "
            f"{config.grouping.min_explained:g} is wanted"
        )
    text = f"a group of {len(group.members)} components that explains {group.weight:.0f} px of contour loses its pixels"
    if not lost.rivals:
        return text + " to a heavier choice"
    rival = max(lost.rivals, key=lambda r: r.weight)
    poses, seed = rival.candidates.poses, rival.members[0]
    at = f"({poses.x[seed]:.0f}, {poses.y[seed]:.0f})"
    return f"{text} to {rival.candidates.target.name} at {at}, which explains {rival.weight:.0f} px"


def reason_alone(search: GroupSearch, seed: int, config: RecognizerConfig) -> tuple[str, ConstraintFailure | None]:
    """Why an instance of the required component found no group."""
    c, table = search.candidates, search.table
    others = [comp.name for comp in c.target.model.components if not comp.required]
    near = np.flatnonzero(~table.forbidden[seed] & table.checked[seed])
    if not len(near):
        if not others or config.min_in_plane < 2:
            return _too_faint(float(c.share[seed]), "min_alone_match", config), None
        if not c.target.constraints:
            return f"nothing tells how {' or '.join(others)} may lie to it: no constraints are given", None
        return f"no instance of {' or '.join(others)} with a learned constraint and a like scale", None
    best = int(near[np.argmin(table.violation[seed, near])])
    failure = failure_of(c, seed, best) if table.violation[seed, best] > 0 else None
    if failure is not None:
        at = f"({c.poses.x[best]:.0f}, {c.poses.y[best]:.0f})"
        return f"nearest is {'/'.join(c.key(best))} at {at}, but {text_of(failure)}", failure
    return _reason_together(search, seed, config)


def _too_faint(share: float, name: str, config: RecognizerConfig) -> str:
    """:param name: of the parameter that asks for more."""
    wanted = getattr(config.grouping, name)
    return f"{share:.2f} of its outline matches on average, {wanted:g} is wanted (expert.grouping.{name})"


def _reason_together(search: GroupSearch, seed: int, config: RecognizerConfig) -> tuple[str, ConstraintFailure | None]:
    """Of a seed that has others around it which agree with it: what the heaviest of each component lack together."""
    c, table = search.candidates, search.table
    fits = ~table.forbidden[seed] & table.checked[seed] & (table.violation[seed] <= 0)
    members = [seed]
    for component in np.unique(c.component[fits]):
        mine = np.flatnonzero(fits & (c.component == component))
        members.append(int(mine[np.argmax(c.weight[mine])]))
    wanted = min(config.min_in_plane, len(c.target.model.components))
    if len(members) < wanted:
        return f"{len(members)} components agree, {wanted} are wanted", None
    index = np.ix_(members, members)
    checked, violation = np.triu(table.checked[index], 1), table.violation[index]
    held = checked & (violation <= 0)
    if held.sum() < config.grouping.min_satisfied * checked.sum():
        a, b = np.unravel_index(int(np.argmax(np.where(checked, violation, -1.0))), violation.shape)
        failure = failure_of(c, members[int(a)], members[int(b)])
        text = f"{held.sum()} of {checked.sum()} constraints hold, {config.grouping.min_satisfied:g} of them are wanted"
        if failure is not None:
            text += f"; {failure.first} - {failure.second} {text_of(failure)}"
        return text, failure
    return _too_faint(float(np.mean(c.share[members])), "min_group_match", config), None

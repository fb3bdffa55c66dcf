"""Groups turned into detections, and candidates that became no object into reasons."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..alignment.matching import Matches
from ..base.config import RecognizerConfig
from ..constraints.constraint_set import ConstraintSet
from ..geometry.transforms import Array
from ..grouping.candidates import Candidates
from ..grouping.group_search import Group, GroupSearch
from ..grouping.solution import Solution
from ..model.found import Detection, ImagePose, Instance
from ..model.frame_result import ConstraintFailure, Rejection
from ..model.target import Target
from .explain import failure_of, reason_alone, reason_lost, text_of
from .trust import probability

_MAX_REJECTIONS = 20  # a frame; the strongest


def instance_of(candidates: Candidates, n: int, matches: Matches) -> Instance:
    """A candidate as users see it."""
    component, marker = candidates.key(n)
    pose, match = candidates.poses, int(candidates.match[n])
    placed, corners = matches.placed, matches.shapes[matches.placed.shape[match]].corners
    where = placed.t[match] + placed.z[match] * corners + placed.w[match] * np.conj(corners)
    return Instance(
        component,
        marker,
        float(candidates.score[n]),
        float(pose.x[n]),
        float(pose.y[n]),
        float(pose.theta[n]),
        float(pose.scale[n]),
        where.view(np.float64).reshape(-1, 2),
    )


def detections_of(
    groups: list[Group],
    matches: Matches,
    targets: tuple[Target, ...],
    margins: Sequence[float | None] = (),
    *,
    literal: bool = False,
) -> tuple[Detection, ...]:
    """Detections by target and score; ids count within a target.

    :param margins: of each group, where they are known.
    :param literal: scores and directions as the published method has them; else scores are probabilities, and axes
        point where annotations would have them, as far as training could tell.
    """
    detections = []
    margin_of = dict(zip(map(id, groups), margins, strict=False))
    for target in targets:
        own = [(g.score if literal else probability(g), g) for g in groups if g.candidates.target is target]
        for number, (score, group) in enumerate(sorted(own, key=lambda o: -o[0])):
            order = sorted(group.members, key=lambda n: int(group.candidates.component[n]))
            parts = tuple(instance_of(group.candidates, n, matches) for n in order)
            if not literal:
                parts = tuple(_as_annotated(p, target) for p in parts)
            base = next(p for p in parts if p.component == target.model.required.name)
            image = ImagePose(base.x, base.y, base.theta, base.scale)
            margin = margin_of.get(id(group))
            detections.append(Detection(target.name, number, score, image, parts, margin=margin))
    return tuple(detections)


def _as_annotated(instance: Instance, target: Target) -> Instance:
    learned, key = target.constraints, (instance.component, instance.marker)
    axis = next((a for a in learned.axes if a.key == key), None) if isinstance(learned, ConstraintSet) else None
    if axis is None:
        return instance
    return axis.corrected(instance, target.model.component(instance.component).marker(instance.marker))


def rejections_of(
    solution: Solution, searches: list[GroupSearch], overlap: Array, config: RecognizerConfig
) -> tuple[Rejection, ...]:
    """Why instances of required components became no object, the strongest candidates first; then why objects that
    were found lack components.

    :param overlap: of all instances (`Matches.overlap`).
    """
    used = {m for g in solution.accepted for m in g.matches}
    grouped = {lost.group.seed: lost for lost in reversed(solution.lost)}
    rows = []
    for search in searches:
        told: set[int] = set()
        for seed in search.seeds[np.argsort(-search.candidates.score[search.seeds], kind="stable")]:
            match = int(search.candidates.match[seed])
            if match in used or match in told or len(told) >= _MAX_REJECTIONS:
                continue
            told.add(match)  # once an instance, whichever way it is turned
            failure = None
            if used and float(overlap[match, sorted(used)].max()) > config.grouping.max_overlap:
                reason = "its pixels belong to an object that explains more"
            elif match in grouped:
                reason = reason_lost(grouped[match], config)
            else:
                reason, failure = reason_alone(search, int(seed), config)
            rows.append(_rejection(search.candidates, int(seed), reason, failure))
    rows = sorted(rows, key=lambda r: -r.score)[:_MAX_REJECTIONS]
    missing = [r for g in solution.accepted for s in searches for r in _missing(g, s, used)]
    return (*rows, *missing[:_MAX_REJECTIONS])


def _missing(group: Group, search: GroupSearch, used: set[int]) -> Iterator[Rejection]:
    """Of each component that an object lacks, the candidate that came nearest to it, and what it fails."""
    if search.candidates is not group.candidates:
        return
    c, table, seed = group.candidates, search.table, group.members[0]
    unused = table.checked[seed] & ~table.forbidden[seed] & ~np.isin(c.match, sorted(used))
    for component in sorted(set(range(len(c.target.model.components))) - set(group.components)):
        near = np.flatnonzero(unused & (c.component == component))
        if not len(near):
            continue
        members = np.array(group.members)
        forbidden = table.forbidden[np.ix_(near, members)].any(axis=1)
        worst = np.where(forbidden, np.inf, table.violation[np.ix_(near, members)].max(axis=1))
        best = int(near[np.argmin(worst)])
        against = int(members[np.argmax(table.violation[best, members])])
        failure = failure_of(c, against, best)
        if failure is not None and np.isfinite(worst.min()):
            text = f"not part of the object found, for {failure.first} - {failure.second} {text_of(failure)}"
            yield _rejection(c, best, text, failure)


def _rejection(candidates: Candidates, n: int, reason: str, failure: ConstraintFailure | None) -> Rejection:
    name, pose, score = candidates.key(n)[0], candidates.poses, float(candidates.score[n])
    place = float(pose.x[n]), float(pose.y[n])
    return Rejection(candidates.target.name, f"{name}: {reason}", score, *place, failure)

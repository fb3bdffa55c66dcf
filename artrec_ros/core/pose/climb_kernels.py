"""Local search of a pose and joints on the votes themselves, which see bodies and what hides what."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted
from ..geometry.pixel_kernels import LabelView
from ..model.chain_kernels import Chain, copy_frame, copy_rotation, place_seen, turn_by
from .sharing_kernels import choose_of_stacks, explain_once
from .surface_kernels import Room, Surface, SurfaceLimits, room_of
from .vote_kernels import Scores, score_hypothesis


class Value(NamedTuple):
    """How patches' votes add up to a whole object's."""

    n_components: int
    root: int
    hidden_cost: float
    occlusion: bool  # whether bodies hide what is behind them


class Steps(NamedTuple):
    """What a parameter's steps are measured in, and what becomes of them: values of `SearchConfig`."""

    px: float  # across the ray
    depth: float  # along it, a share
    rad: float
    joint: float  # of a joint's unit
    lengthen: float  # factors on the next step after one helped,
    turn: float  # and after it did not
    least: float  # a shorter one is not taken


class Moves(NamedTuple):
    """What a step needs to know of the camera and of the joints."""

    steps: Steps
    focal: float
    near_m: float  # least and greatest depth: no step passes them
    far_m: float
    lower: Any  # (J,)
    upper: Any
    unit: Any
    endless: Any  # (J,) bool


class Body(NamedTuple):
    """One hypothesis placed: frames of its components, and what its patches are worth."""

    R: Any  # (C, 3, 3)
    t: Any  # (C, 3)
    joints: Any  # (2, J, 3) axes and origins
    scores: Scores  # as it was scored last,
    tried: Scores  # and as if it were elsewhere,
    once: Any  # (3, P) what is left of that where each pixel is explained once: votes, pixels, agreement
    sums: Any  # (2, C)
    scratch: Any  # (3, 3, 3)
    everything: Any  # (C,) True: components that move with the pose


class Tried(NamedTuple):
    """A hypothesis a step away from another."""

    R: Any  # (3, 3)
    t: Any  # (3,)
    q: Any  # (J,)
    scratch: Any  # (3, 3, 3)


@melted
def total(s: Surface, value: Value, votes: Any, area_px: Any, sums: Any) -> float:
    """Votes of a whole object from those of its patches (P,); a component that speaks against itself counts as hidden,
    at a price.

    :param sums: (2, C) scratch.
    """
    sums[:] = 0.0
    for p in range(len(votes)):
        c = s.component[p]
        sums[0, c] += votes[p]
        if s.marker_of[p] >= 0:
            sums[1, c] += area_px[p]
    whole = 0.0
    for c in range(value.n_components):
        whole += sums[0, c] if c == value.root else max(sums[0, c], -value.hidden_cost * sums[1, c])
    return whole


@jit
def totals(s: Surface, value: Value, votes: Any, area_px: Any, out: Any) -> None:
    """Fill out (H,) with the votes of whole objects from those of their patches (H, P)."""
    sums = np.empty((2, value.n_components))
    for h in range(len(out)):
        out[h] = total(s, value, votes[h], area_px[h], sums)


@melted
def whole_votes(
    s: Surface, patches: Any, chain: Chain, R: Any, t: Any, q: Any, moved: Any, view: LabelView, limits: SurfaceLimits,
    value: Value, body: Body, room: Room,
) -> float:  # fmt: skip
    """Votes of a whole object under one hypothesis (3, 3), (3,), (J,), with `body.tried` and `body.once` filled.

    :param moved: (C,) components that are elsewhere than `body.scores` are of.
    """
    copy_scores(body.scores, body.tried)
    place_seen(chain, R, t, q, body.R, body.t, body.joints[0], body.joints[1], body.scratch)
    score_hypothesis(s, body.R, body.t, patches, moved, view, limits, value.occlusion, room, body.tried)
    said, once = body.tried, body.once
    for p in range(len(patches)):
        once[0, p], once[1, p], once[2, p] = said.votes[p], said.area_px[p], said.agree[p]
    choose_of_stacks(s, patches, once[0], once[1], once[2])
    f2 = view.K[0, 0] * view.K[1, 1]
    explain_once(s, body.R, body.t, f2, limits, False, room, once[0], once[1], once[2])
    return total(s, value, once[0], once[1], body.sums)


@melted
def copy_scores(scores: Scores, out: Scores) -> None:
    """Copy what is said of P patches."""
    for p in range(len(out.votes)):
        out.votes[p], out.area_px[p], out.near[p] = scores.votes[p], scores.area_px[p], scores.near[p]
        out.agree[p] = scores.agree[p]


@melted
def move(m: Moves, z: Any, R: Any, t: Any, q: Any, tried: Tried) -> None:
    """Step by z (6 + J,), in the units of `m.steps`: across the ray and along it, turned, bent."""
    t_new, q_new, steps = tried.t, tried.q, m.steps
    near = 1 + steps.depth * z[2]
    if z[2] != 0.0 and t[2] > 0.0:
        near = min(max(near, min(m.near_m / t[2], 1.0)), max(m.far_m / t[2], 1.0))
    across = steps.px / m.focal * t[2]
    t_new[0], t_new[1], t_new[2] = t[0] * near + across * z[0], t[1] * near + across * z[1], t[2] * near
    copy_rotation(R, tried.R)
    turn_by(steps.rad * z[3], steps.rad * z[4], steps.rad * z[5], tried.R, tried.scratch)
    for j in range(len(q)):
        value = q[j] + steps.joint * m.unit[j] * z[6 + j]
        if m.endless[j]:
            value = m.lower[j] + (value - m.lower[j]) % (2 * math.pi)
        else:
            value = min(max(value, m.lower[j]), m.upper[j])
        q_new[j] = value


@jit
def body_of(s: Surface, value: Value, n_joints: int) -> Body:
    """Room for one hypothesis of a surface."""
    n_c, n_p = value.n_components, len(s.area)
    near = np.zeros((2, n_p), np.int64)
    said = np.zeros((2, 3, n_p))
    return Body(
        np.empty((n_c, 3, 3)), np.empty((n_c, 3)), np.empty((2, n_joints, 3)),
        Scores(said[0, 0], said[0, 1], said[0, 2], near[0]), Scores(said[1, 0], said[1, 1], said[1, 2], near[1]),
        np.empty((3, n_p)), np.empty((2, n_c)), np.empty((3, 3, 3)), np.ones(n_c, np.bool_),
    )  # fmt: skip


@jit
def votes_of(
    s: Surface, chain: Chain, view: LabelView, limits: SurfaceLimits, value: Value, R: Any, t: Any, q: Any, out: Any
) -> None:
    """Fill out (H,) with the votes of hypotheses R (H, 3, 3), t (H, 3), q (H, J)."""
    patches, room, body = np.arange(len(s.area)), room_of(s), body_of(s, value, q.shape[1])
    for h in range(len(R)):
        out[h] = whole_votes(
            s, patches, chain, R[h], t[h], q[h], body.everything, view, limits, value, body, room
        )  # fmt: skip


@jit
def sweep(
    s: Surface, chain: Chain, view: LabelView, limits: SurfaceLimits, value: Value, grids: Any, R: Any, t: Any, q: Any,
    votes: Any,
) -> None:  # fmt: skip
    """Move the joints of hypotheses R (H, 3, 3), t (H, 3), q (H, J) with their votes (H,), one after the other, to the
    best of the values in `grids` (J, n; NaN ends a row), where one is better."""
    patches, room, body = np.arange(len(s.area)), room_of(s), body_of(s, value, q.shape[1])
    for h in range(len(R)):
        whole_votes(s, patches, chain, R[h], t[h], q[h], body.everything, view, limits, value, body, room)
        copy_scores(body.tried, body.scores)
        for j in range(len(grids)):
            best = q[h, j]
            for at in grids[j]:
                if math.isnan(at):
                    break
                q[h, j] = at
                found = whole_votes(
                    s, patches, chain, R[h], t[h], q[h], chain.moves[j], view, limits, value, body, room
                )  # fmt: skip
                if found > votes[h]:
                    votes[h], best = found, at
                    copy_scores(body.tried, body.scores)
            q[h, j] = best


@jit
def climb(
    s: Surface, chain: Chain, view: LabelView, limits: SurfaceLimits, value: Value, m: Moves, rounds: int, steps: Any,
    R: Any, t: Any, q: Any, votes: Any,
) -> None:  # fmt: skip
    """So many rounds of steps of hypotheses R (H, 3, 3), t (H, 3), q (H, J) with their votes (H,), one parameter
    after the other, until no step is long enough to be taken.

    A step that helps is kept, and the parameter's next one is longer; one that does not is turned round and shortened
    (Rosenbrock 1960, along the parameters' own axes throughout).

    :param steps: (H, 6 + J) the next one of each parameter, in the units of `m.steps`.
    """
    patches, room, body, n_joints = np.arange(len(s.area)), room_of(s), body_of(s, value, q.shape[1]), q.shape[1]
    tried = Tried(np.empty((3, 3)), np.empty(3), np.empty(n_joints), np.empty((3, 3, 3)))
    step = np.zeros(6 + n_joints)
    for h in range(len(R)):
        taken = True
        if n_joints:  # else each step moves all of it, and nothing that was said before is looked at
            whole_votes(s, patches, chain, R[h], t[h], q[h], body.everything, view, limits, value, body, room)
            copy_scores(body.tried, body.scores)
        for _ in range(rounds):
            if not taken:
                break
            taken = False
            for k in range(6 + n_joints):
                if abs(steps[h, k]) < m.steps.least:
                    continue
                taken = True
                step[k] = steps[h, k]
                move(m, step, R[h], t[h], q[h], tried)
                step[k] = 0.0
                moved = body.everything if k < 6 else chain.moves[k - 6]
                found = whole_votes(
                    s, patches, chain, tried.R, tried.t, tried.q, moved, view, limits, value, body, room
                )  # fmt: skip
                steps[h, k] *= m.steps.lengthen if found > votes[h] else m.steps.turn
                if found > votes[h]:
                    votes[h] = found
                    copy_scores(body.tried, body.scores)
                    copy_frame(tried.R, tried.t, R[h], t[h])
                    for j in range(n_joints):
                        q[h, j] = tried.q[j]

"""Local search on the votes, a hypothesis and a try at a time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .chains import Chain, copy_frame, copy_rotation, place_all, turn_by
from .geometry import View
from .jit import jit, lean
from .scoring import score_hypothesis
from .surface import Limits, Room, Surface, room_of


class Value(NamedTuple):
    """How patches' votes add up: `WholeObjectFinder.total`."""

    n_components: int
    root: int
    hidden_cost: float
    occlusion: bool  # whether bodies hide what is behind them


class Moves(NamedTuple):
    """The steps of `local_search`, and the joints' limits."""

    px: float
    depth: float
    rad: float
    joint: float
    lengthen: float
    turn: float
    least: float
    focal: float
    lower: Any  # (J,)
    upper: Any
    unit: Any
    endless: Any  # (J,) bool


class Body(NamedTuple):
    """One hypothesis placed: frames of its components, and what its patches are worth."""

    R: Any  # (C, 3, 3)
    t: Any  # (C, 3)
    joints: Any  # (2, J, 3) axes and origins
    votes: Any  # (P,)
    area_px: Any
    agree: Any
    sums: Any  # (2, C)
    scratch: Any  # (3, 3, 3)


class Tried(NamedTuple):
    """A hypothesis a step away from another."""

    R: Any  # (3, 3)
    t: Any  # (3,)
    q: Any  # (J,)
    scratch: Any  # (3, 3, 3)


@lean
def total_votes(s: Surface, patches: Any, view: View, limits: Limits, value: Value, body: Body, room: Room) -> float:
    """Votes of a whole placed object; a component that speaks against itself counts as hidden, at a price."""
    hidden = value.occlusion
    score_hypothesis(s, body.R, body.t, patches, view, limits, hidden, room, body.votes, body.area_px, body.agree)
    body.sums[:] = 0.0
    for p in range(len(patches)):
        c = s.component[p]
        body.sums[0, c] += body.votes[p]
        if s.marker_of[p] >= 0:
            body.sums[1, c] += body.area_px[p]
    total = 0.0
    for c in range(value.n_components):
        votes = body.sums[0, c]
        total += votes if c == value.root else max(votes, -value.hidden_cost * body.sums[1, c])
    return total


@lean
def move(m: Moves, z: Any, R: Any, t: Any, q: Any, tried: Tried) -> None:
    """A try: `local_search._stepped` of one hypothesis."""
    t_new, q_new = tried.t, tried.q
    near = 1 + m.depth * z[2]
    across = m.px / m.focal * t[2]
    t_new[0], t_new[1], t_new[2] = t[0] * near + across * z[0], t[1] * near + across * z[1], t[2] * near
    copy_rotation(R, tried.R)
    turn_by(m.rad * z[3], m.rad * z[4], m.rad * z[5], tried.R, tried.scratch)
    for j in range(len(q)):
        value = q[j] + m.joint * m.unit[j] * z[6 + j]
        if m.endless[j]:
            value = m.lower[j] + (value - m.lower[j]) % (2 * math.pi)
        else:
            value = min(max(value, m.lower[j]), m.upper[j])
        q_new[j] = value


@jit
def body_of(s: Surface, value: Value, n_joints: int) -> Body:
    """Room for one hypothesis of a surface."""
    n_c, n_p = value.n_components, len(s.area)
    return Body(
        np.empty((n_c, 3, 3)), np.empty((n_c, 3)), np.empty((2, n_joints, 3)),
        np.empty(n_p), np.empty(n_p), np.empty(n_p), np.empty((2, n_c)), np.empty((3, 3, 3)),
    )  # fmt: skip


@jit
def votes_of(
    s: Surface, chain: Chain, view: View, limits: Limits, value: Value, R: Any, t: Any, q: Any, out: Any
) -> None:
    """Fill out (H,) with the votes of hypotheses R (H, 3, 3), t (H, 3), q (H, J) as `WholeObjectFinder.votes` does."""
    patches, room, body = np.arange(len(s.area)), room_of(s), body_of(s, value, q.shape[1])
    for h in range(len(R)):
        place_all(chain, R[h], t[h], q[h], body.R, body.t, body.joints[0], body.joints[1], body.scratch)
        out[h] = total_votes(s, patches, view, limits, value, body, room)


@jit
def sweep(
    s: Surface, chain: Chain, view: View, limits: Limits, value: Value, grid: Any, R: Any, t: Any, q: Any, votes: Any
) -> None:
    """Move each joint of hypotheses R (H, 3, 3), t (H, 3), q (H, J) to its best value in `grid` (J, n), one after the
    other, as `local_search.sweep` does; NaN ends a joint's row."""
    patches, room, body = np.arange(len(s.area)), room_of(s), body_of(s, value, q.shape[1])
    for h in range(len(R)):
        votes[h] = _sweep_one(s, patches, chain, view, limits, value, grid, R[h], t[h], q[h], votes[h], body, room)


@lean
def _sweep_one(
    s: Surface, patches: Any, chain: Chain, view: View, limits: Limits, value: Value, grid: Any,
    R: Any, t: Any, q: Any, votes: float, body: Body, room: Room,
) -> float:  # fmt: skip
    for j in range(len(q)):
        best = q[j]
        for at in grid[j]:
            if math.isnan(at):
                break
            q[j] = at
            place_all(chain, R, t, q, body.R, body.t, body.joints[0], body.joints[1], body.scratch)
            found = total_votes(s, patches, view, limits, value, body, room)
            if found > votes:
                votes, best = found, at
        q[j] = best
    return votes


@jit
def climb(
    s: Surface, chain: Chain, view: View, limits: Limits, value: Value, m: Moves, rounds: int, spread: float,
    R: Any, t: Any, q: Any, votes: Any,
) -> None:  # fmt: skip
    """Move hypotheses R (H, 3, 3), t (H, 3), q (H, J) to better ones nearby, as `local_search.climb` does."""
    patches, room, body, n_joints = np.arange(len(s.area)), room_of(s), body_of(s, value, q.shape[1]), q.shape[1]
    tried = Tried(np.empty((3, 3)), np.empty(3), np.empty(n_joints), np.empty((3, 3, 3)))
    steps, step = np.empty(6 + n_joints), np.zeros(6 + n_joints)
    for h in range(len(R)):
        steps[:] = spread
        votes[h] = _climb_one(
            s, patches, chain, view, limits, value, m, rounds, steps, step,
            R[h], t[h], q[h], votes[h], tried, body, room,
        )  # fmt: skip


@lean
def _climb_one(
    s: Surface, patches: Any, chain: Chain, view: View, limits: Limits, value: Value, m: Moves, rounds: int,
    steps: Any, step: Any, R: Any, t: Any, q: Any, votes: float, tried: Tried, body: Body, room: Room,
) -> float:  # fmt: skip
    """:param steps: (6 + J,) the first one of each parameter; step: (6 + J,) zeros."""
    for _ in range(rounds):
        over = True
        for k in range(len(steps)):
            if abs(steps[k]) < m.least:
                continue
            over = False
            step[k] = steps[k]
            move(m, step, R, t, q, tried)
            step[k] = 0.0
            place_all(chain, tried.R, tried.t, tried.q, body.R, body.t, body.joints[0], body.joints[1], body.scratch)
            found = total_votes(s, patches, view, limits, value, body, room)
            steps[k] *= m.lengthen if found > votes else m.turn
            if found > votes:
                votes = found
                copy_frame(tried.R, tried.t, R, t)
                for j in range(len(q)):
                    q[j] = tried.q[j]
        if over:
            break
    return votes

"""Forward kinematics of articulated objects, batched over hypotheses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from .chain_kernels import Chain, face_cameras, forward
from .objects import Component, ObjectModel


def within_limits(q: Array, lower: Array, upper: Array, endless: NDArray[np.bool_]) -> Array:
    """Joints (..., J) within limits (J,); those that turn without limit go round."""
    begin = np.where(endless, lower, 0.0)
    turned = begin + (q - begin) % (2 * np.pi)
    return np.where(endless, turned, np.minimum(np.maximum(q, lower), upper))


@dataclass(frozen=True)
class Frames:
    """Component frames of H hypotheses in the camera's optical frame, and where their joints are.

    :param R, t: (H, C, 3, 3), (H, C, 3): X_camera = R X_component + t.
    :param axis, origin: (H, J, 3) joint axes and origins in the camera's frame.
    """

    R: Array
    t: Array
    axis: Array
    origin: Array


class Kinematics:
    """A model's joints as arrays. The joint vector's order is `ObjectModel.joint_components`."""

    def __init__(self, model: ObjectModel) -> None:
        self.model = model
        self._grids: dict[float, Array] = {}
        index = {c.name: i for i, c in enumerate(model.components)}
        self.parent = [-1 if c.joint is None else index[c.joint.parent] for c in model.components]
        joints = [c.name for c in model.joint_components]
        self.joint_of = [joints.index(c.name) if c.name in joints else -1 for c in model.components]
        spans = np.array([j.span for j in model.joints.values()], float).reshape(-1, 2)
        self.lower, self.upper = (np.ascontiguousarray(end) for end in spans.T)
        self.revolute = np.array([j.kind == "revolute" for j in model.joints.values()], bool)

        # what a joint's step is measured in: a radian, or the size of what slides
        self.unit = np.array(
            [1.0 if c.joint.kind == "revolute" else _size(c) for c in model.joint_components if c.joint]
        )

    @property
    def relief(self) -> float:
        """By what share of their extent markers that all face one way stand one above the other, joints mid-range."""
        frames = self.in_object(self.middle[None])
        placed = [
            (frames.R[0, n] @ T.rotation, frames.R[0, n] @ T.position + frames.t[0, n], marker.outline)
            for n, component in enumerate(self.model.components)
            for marker in component.markers
            if (T := marker.T_component_marker) is not None
        ]
        corners = np.concatenate([outline @ R[:, :2].T + t for R, t, outline in placed])
        return float(np.ptp(corners @ placed[0][0][:, 2]) / np.linalg.norm(np.ptp(corners, axis=0)))

    def bound(self, q: Array) -> Array:
        """Joints (..., J) within their limits; one that turns without limit goes round."""
        return within_limits(q, self.lower, self.upper, self.endless)

    def grid(self, j: int, step: float) -> Array:
        """Values of joint `j` from limit to limit, at most `step` units apart."""
        n = max(3, int(np.ceil((self.upper[j] - self.lower[j]) / (step * self.unit[j]))) + 1)
        return np.linspace(self.lower[j], self.upper[j], n)

    def grids(self, step: float) -> Array:
        """(J, n) such values of all joints; NaN fills up the rows of those with fewer."""
        if step not in self._grids:
            rows = [self.grid(j, step) for j in range(self.n_joints)]
            grids = np.full((len(rows), max(map(len, rows), default=0)), np.nan)
            for row, values in zip(grids, rows, strict=True):
                row[: len(values)] = values
            self._grids[step] = grids
        return self._grids[step]

    @cached_property
    def endless(self) -> np.ndarray:
        """(J,) bool: joints that turn without limit."""
        return np.array([j.is_endless for j in self.model.joints.values()], bool)

    @property
    def n_joints(self) -> int:
        return len(self.lower)

    @property
    def middle(self) -> Array:
        """(J,) half way between each joint's limits."""
        return (self.lower + self.upper) / 2

    @cached_property
    def carried(self) -> np.ndarray:
        """(J,) the component that each joint carries."""
        return np.array([self.joint_of.index(j) for j in range(self.n_joints)], np.int64)

    @cached_property
    def moves(self) -> np.ndarray:
        """(C, J) bool: does joint j move component c."""
        out = np.zeros((len(self.parent), self.n_joints), bool)
        for c, (parent, j) in enumerate(zip(self.parent, self.joint_of, strict=True)):
            if parent >= 0:
                out[c] = out[parent]
            if j >= 0:
                out[c, j] = True
        return out

    def rigid_to(self, component: int) -> NDArray[np.bool_]:
        """(C,) which other components the same joints move."""
        rigid = np.asarray((self.moves == self.moves[component]).all(axis=1))
        rigid[component] = False
        return rigid

    @cached_property
    def line(self) -> np.ndarray:
        """(C,) components, each branch from its root to its ends, then the next."""
        children: list[list[int]] = [[] for _ in range(len(self.parent) + 1)]
        for c, parent in enumerate(self.parent):
            children[parent].append(c)  # of the object's frame: the last
        line, rest = [], [-1]
        while rest:
            line.append(rest.pop())
            rest += children[line[-1]][::-1]
        return np.array(line[1:], np.int64)

    @cached_property
    def chain(self) -> Chain:
        """The same for compiled code."""
        joints = [c.joint for c in self.model.components]
        none = (np.eye(3), np.zeros(3), np.zeros(3), False)
        rows = [
            none if j is None else (j.T_parent_joint.rotation, j.T_parent_joint.position, j.axis, j.kind == "revolute")
            for j in joints
        ]
        R, t, axis, revolute = (np.array(values) for values in zip(*rows, strict=True))
        balls = [c.ball for c in self.model.components]
        ball = np.array([0.0 if b is None else b.radius for b in balls])
        middle = np.array([np.zeros(3) if b is None else b.centre for b in balls])
        return Chain(
            np.array(self.parent), np.array(self.joint_of), R, t, axis, revolute, self.moves.T.copy(), ball, middle
        )  # fmt: skip

    def forward(self, R: Array, t: Array, q: Array) -> Frames:
        """Component frames for object poses R (H, 3, 3), t (H, 3) in the camera and joints q (H, J)."""
        return frames_of(self.chain, R, t, q)

    def seen(self, R: Array, t: Array, q: Array) -> Frames:
        """The same with balls as the camera sees them: discs that face it, as much nearer as their outlines are."""
        frames = self.forward(R, t, q)
        if self.chain.ball.any():
            face_cameras(self.chain, frames.R, frames.t)
        return frames

    def in_object(self, q: Array) -> Frames:
        """Component frames in the object's own at joints q (H, J)."""
        return self.forward(np.tile(np.eye(3), (len(q), 1, 1)), np.zeros((len(q), 3)), q)


def frames_of(chain: Chain, R: Array, t: Array, q: Array) -> Frames:
    """The same of joints as arrays."""
    H, C, J = len(R), len(chain.parent), q.shape[1]
    out = Frames(np.empty((H, C, 3, 3)), np.empty((H, C, 3)), np.empty((H, J, 3)), np.empty((H, J, 3)))
    # copies: each kind of array, as a broadcast or a constant one, would be compiled for anew
    forward(chain, R.copy(), t.copy(), q.copy(), out.R, out.t, out.axis, out.origin)
    return out


def _size(component: Component) -> float:
    """Metres across the largest of a component's markers."""
    return max(float(np.linalg.norm(np.ptp(m.outline, axis=0))) for m in component.markers)

"""Flat robots from above, coloured patches that tell which one each is, and exact pictures of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Identity, Joint, ObjectModel
from artrec_ros.core.pose.poses import Poses

TEAM, BODY = 3, 8
COLOURS = {"g": 4, "r": 5, "v": 6}
SIZE = (150, 120)
SIDE = 0.075
_H = SIDE / 2
BACK = np.array([(-_H, -_H), (0.0, -_H), (0.0, _H), (-_H, _H)])  # the half behind, in the team's colour
LEFT = np.array([(0.0, 0.0), (_H, 0.0), (_H, _H), (0.0, _H)])
RIGHT = LEFT * (1, -1)
ARM = np.array([(0.0, -0.012), (0.09, -0.012), (0.09, 0.012), (0.0, 0.012)])
DISC = 0.014 * np.column_stack([np.cos(np.pi * np.arange(16) / 8), np.sin(np.pi * np.arange(16) / 8)])
DOTS = {"front": (0.036, 0.026), "left": (-0.026, 0.034), "back": (-0.026, -0.034), "right": (0.036, -0.026)}
# as they lie: turned by a quarter the file's fit a little better
BUILT = {"front": (0.030, 0.032), "left": (-0.026, 0.035), "back": (-0.031, -0.029), "right": (0.035, -0.026)}
PAIRS = (("gr", "g", "r"), ("gv", "g", "v"), ("rg", "r", "g"), ("vr", "v", "r"))


def patch(name, outline, T=None):
    """A marker in the object's plane z = 0, seen from above."""
    outline = np.array(outline, float)
    head = outline.mean(axis=0) + (0.02, 0.0)
    return Marker(name, outline, outline.mean(axis=0), head, T_component_marker=T or Pose.identity())


def robot(identities=PAIRS, unique=True, alternatives=True):
    """Half in the team's colour, behind; in front two patches of one of three colours each."""
    either = dict(COLOURS) if alternatives else {}
    return ObjectModel(
        "robot",
        (
            Component("team", (patch("back", BACK),), required=True),
            Component("left", (patch("left", LEFT),), label=None if alternatives else COLOURS["g"], classes=either),
            Component("right", (patch("right", RIGHT),), label=None if alternatives else COLOURS["r"], classes=either),
        ),
        tuple(Identity(name, {"left": a, "right": b}) for name, a, b in identities) if alternatives else (),
        unique and alternatives,
    )


def plate():
    """Five discs, of which one corner is of one colour and the others of another."""
    classes, first, *others = {c: COLOURS[c] for c in "gr"}, *DOTS
    corners = [Component(name, (patch(name, DISC + at),), classes=classes) for name, at in DOTS.items()]
    pairs = [Identity(a + b, {first: a, **dict.fromkeys(others, b)}) for a, b in ("gr", "rg")]
    team = Component("team", (patch("team", DISC),), required=True)
    return ObjectModel("plate", (team, *corners), tuple(pairs), unique=True)


def gate():
    """A robot and an arm of another colour that swings about its front's middle."""
    plain = robot(alternatives=False)
    arm = Component("arm", (patch("arm", ARM),), label=7, joint=hinge("team", (_H, 0.0, 0.0), (0, 0, 1)))
    return ObjectModel("gate", (*plain.components, arm))


def hinge(parent, at, axis, kind="revolute", limits=(-1.2, 1.2)):
    return Joint(parent, Pose(np.eye(3), np.array(at, float)), np.array(axis, float), *limits, kind)


ROBOT = {"plain": robot(alternatives=False), "gate": gate()}


@dataclass(frozen=True)
class Placing:
    """A robot in the image: its origin x, y and scale in pixels; `turn` of its x axis, counter-clockwise as the image
    shows it, radians; which one it is; its arm's angle."""

    x: float
    y: float
    turn: float
    scale: float
    name: str = "gr"
    arm: float | None = None

    def at(self, points):
        """(n, 2) pixels of points (n, 2) of the robot; its y is up in the image where it is not turned."""
        c, s = np.cos(self.turn), np.sin(self.turn)
        x, y = np.asarray(points, float).T
        return np.column_stack([self.x + self.scale * (c * x - s * y), self.y - self.scale * (s * x + c * y)])

    def pose(self, camera: Camera) -> Poses:
        """The same as a pose before a camera that it faces."""
        c, s, depth = np.cos(self.turn), np.sin(self.turn), camera.focal_px / self.scale
        R = np.array([[c, -s, 0], [-s, -c, 0], [0, 0, -1.0]])
        xy = (np.array([self.x, self.y]) - camera.matrix[:2, 2]) / camera.focal_px * depth
        q = np.zeros((1, 0)) if self.arm is None else np.array([[self.arm]])
        return Poses(R[None], np.array([[*xy, depth]]), q)

    def patches(self):
        """(outline in pixels, label) of all patches."""
        left, right = self.name
        out = [(self.at(BACK), TEAM), (self.at(LEFT), COLOURS[left]), (self.at(RIGHT), COLOURS[right])]
        if self.arm is not None:
            c, s = np.cos(self.arm), np.sin(self.arm)
            out.append((self.at(ARM @ np.array([[c, s], [-s, c]]) + (_H, 0.0)), 7))
        return out


class Plate(Placing):
    """A plate; its corners look much the same in each quarter turn but for their colours."""

    def patches(self):
        one, others = self.name
        corners = [(at, COLOURS[one if n == 0 else others]) for n, at in enumerate(BUILT.values())]
        return [(self.at(DISC + at), label) for at, label in [((0, 0), TEAM), *corners]]


def rendered(*placed, size=SIZE, background=0, fine=8):
    """(H, W) the class that fills most of each pixel."""
    width, height = size
    u = (np.arange(width * fine) + 0.5) / fine - 0.5
    v = (np.arange(height * fine) + 0.5) / fine - 0.5
    full = np.full((height * fine, width * fine), background, np.uint8)
    for robot_ in placed:
        for outline, label in robot_.patches():
            full[_within(outline, u, v)] = label
    return _majority(full, fine)


def _within(outline, u, v):
    """(V, U) bool: which pixels lie in a convex polygon; both senses."""
    (x0, y0), (x1, y1) = outline.min(axis=0), outline.max(axis=0)
    inside = np.zeros((len(v), len(u)), bool)
    columns, rows = np.flatnonzero((u >= x0) & (u <= x1)), np.flatnonzero((v >= y0) & (v <= y1))
    if not len(columns) or not len(rows):
        return inside
    X, Y = np.meshgrid(u[columns], v[rows])
    sides = [
        (b - a)[0] * (Y - a[1]) - (b - a)[1] * (X - a[0]) for a, b in zip(outline, np.roll(outline, -1, 0), strict=True)
    ]
    inside[np.ix_(rows, columns)] = (np.array(sides) >= 0).all(axis=0) | (np.array(sides) <= 0).all(axis=0)
    return inside


def _majority(full, fine):
    height, width = (n // fine for n in full.shape)
    cells = full.reshape(height, fine, width, fine)
    classes = np.unique(full)
    counts = np.stack([(cells == c).sum(axis=(1, 3)) for c in classes])
    return classes[counts.argmax(axis=0)].astype(np.uint8)

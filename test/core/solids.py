"""Small objects with places in space, and exact pictures of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.model.kinematics import Kinematics
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.core.verdict.verdicts import Verdict, Verdicts
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import PlacedObject, Scene
from artrec_ros.simulation.sensor import majority_labels

RED, BLUE, BODY, BACKGROUND = 3, 2, 5, 1

# Marker frames (columns x right, y up, z out) on the sides of an object with x forward, y left, z up.
RIGHT_SIDE = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)
LEFT_SIDE = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]], float)
FRONT = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], float)
SIDE_ON = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)  # an object's turn that shows the camera its right side

BENT = (-0.28, 0.09, 0.001, -0.0008, -0.01)  # a wide lens, plumb_bob
RATIONAL = (0.3, -0.05, 0.001, 0.0005, 0.01, 0.55, 0.02, 0.005)

CAB = np.array([(-0.1, -0.04), (0.1, -0.04), (0.1, -0.01), (0.05, 0.04), (-0.02, 0.04), (-0.03, 0.0), (-0.1, 0.0)])
GATE = np.array([(-0.05, -0.04), (0.05, -0.04), (0.05, -0.01), (0.01, 0.04), (-0.05, 0.04)])


def camera_of(size=(320, 240), focal=300.0, distortion=()):
    matrix = [[focal, 0, (size[0] - 1) / 2 + 3], [0, 1.02 * focal, (size[1] - 1) / 2 - 2], [0, 0, 1]]
    return Camera(np.array(matrix), np.array(distortion, float), size)


def marker(name, outline, rotation, position):
    outline = np.array(outline, float)
    tail, head = outline.min(axis=0), outline.max(axis=0)
    return Marker(name, outline, tail, head, T_component_marker=Pose(rotation, np.array(position, float)))


def rectangle(width, height, at=(0.0, 0.0)):
    return np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (width / 2, height / 2) + at


def truck(bodies=True):
    """A patch on each side and in front, and two legs of unlike lengths on either side."""
    torso = Component(
        "torso",
        (
            marker("right", CAB, RIGHT_SIDE, (0, -0.0605, 0)),
            marker("left", CAB * (-1, 1), LEFT_SIDE, (0, 0.0605, 0)),
            marker("front", GATE, FRONT, (0.1105, 0, 0)),
        ),
        required=True,
        bodies=(Box(Pose.identity(), np.array([0.22, 0.12, 0.1])),) if bodies else (),
        body_label=BODY if bodies else None,
    )
    legs = []
    for name, x, length in (("fore", 0.075, 0.12), ("hind", -0.075, 0.09)):
        strip = rectangle(0.026, length, (0, -0.02 - length / 2))
        box = Box(Pose.from_xyz_rpy((0, 0, -0.02 - length / 2)), np.array([0.03, 0.14, length + 0.01]))
        legs.append(
            Component(
                name,
                (
                    marker("outer_right", strip, RIGHT_SIDE, (0, -0.0705, 0)),
                    marker("outer_left", strip, LEFT_SIDE, (0, 0.0705, 0)),
                ),
                joint=Joint("torso", Pose.from_xyz_rpy((x, 0, -0.04)), np.array([0.0, 1.0, 0.0]), -0.8, 0.8),
                bodies=(box,) if bodies else (),
                body_label=BODY if bodies else None,
            )
        )
    return ObjectModel("truck", (torso, *legs))


def sign():
    """One component, one marker, nothing else."""
    return ObjectModel("sign", (Component("plate", (marker("face", CAB, RIGHT_SIDE, (0, 0, 0)),), required=True),))


def plate():
    """One component, one marker that is about as wide as long."""
    return ObjectModel("plate", (Component("plate", (marker("face", GATE, RIGHT_SIDE, (0, 0, 0)),), required=True),))


def slide():
    """A prismatic joint: a bar that moves along the plate's length."""
    plate = Component("plate", (marker("face", CAB, RIGHT_SIDE, (0, -0.001, 0)),), required=True)
    bar = Component(
        "bar",
        (marker("face", rectangle(0.04, 0.06), RIGHT_SIDE, (0, -0.001, 0)),),
        joint=Joint("plate", Pose.from_xyz_rpy((0, 0, 0.09)), np.array([1.0, 0, 0]), -0.1, 0.1, "prismatic"),
    )
    return ObjectModel("slide", (plate, bar))


def cabinet():
    """A box, and a drawer that comes out of its front: of the strips on the drawer's sides it hides what is inside."""
    carcass = Component(
        "carcass",
        (marker("right", CAB * 1.4, RIGHT_SIDE, (0, -0.1505, 0)), marker("left", CAB * 1.4, LEFT_SIDE, (0, 0.1505, 0))),
        required=True,
        bodies=(Box(Pose.identity(), np.array([0.3, 0.3, 0.2])),),
    )
    drawer = Component(
        "drawer",
        (
            marker("front", rectangle(0.22, 0.06), FRONT, (0.0005, 0, 0)),
            marker("right", rectangle(0.12, 0.04), RIGHT_SIDE, (-0.075, -0.1305, 0)),
            marker("left", rectangle(0.12, 0.04), LEFT_SIDE, (-0.075, 0.1305, 0)),
        ),
        label=BLUE,
        joint=Joint("carcass", Pose.from_xyz_rpy((0.155, 0, 0.02)), np.array([1.0, 0, 0]), 0.0, 0.2, "prismatic"),
        bodies=(Box(Pose.from_xyz_rpy((-0.13, 0, 0)), np.array([0.26, 0.26, 0.08])),),
    )
    return ObjectModel("cabinet", (carcass, drawer))


def chain():
    """Every kind of joint, one on another, none of them aligned."""
    base = Component("base", (marker("face", CAB, RIGHT_SIDE, (0.01, -0.02, 0)),), required=True)
    turn = Joint("base", Pose.from_xyz_rpy((0.1, 0.02, 0.03), (0.3, -0.2, 0.5)), np.array([0.0, 0.6, 0.8]), -1.0, 0.5)
    push = Joint("arm", Pose.from_xyz_rpy((0.15, 0, 0), (0, 0.4, 0)), np.array([0.8, 0.0, 0.6]), 0.0, 0.1, "prismatic")
    hold = Joint("rod", Pose.from_xyz_rpy((0.05, 0.01, 0), (1.0, 0, 0)), np.array([1.0, 0, 0]), 0, 0, "fixed")
    spin = Joint("hand", Pose.from_xyz_rpy((0, 0, 0.06), (0, 1.2, 0.1)), np.array([1.0, 0, 0]), -2.0, 2.0)
    strip = rectangle(0.08, 0.02, (0.05, 0))
    joints = {"arm": turn, "rod": push, "hand": hold, "finger": spin}
    parts = tuple(Component(n, (marker("face", strip, RIGHT_SIDE, (0, -0.01, 0)),), joint=j) for n, j in joints.items())
    return ObjectModel("chain", (base, *parts))


def pose(x=0.0, y=0.0, z=1.0, heading=0.0, tilt=0.0, model=None, joints: Mapping[str, float] | None = None) -> Poses:
    """One hypothesis: side on, turned by `heading` about the vertical, then by `tilt` about the line of sight."""
    R = rotation_from_rotvec([0.0, 0.0, tilt]) @ SIDE_ON @ rotation_from_rotvec([0.0, 0.0, heading])
    names = [c.name for c in model.joint_components] if model else []
    return Poses(R[None], np.array([[x, y, z]], float), np.array([[(joints or {}).get(n, 0.0) for n in names]]))


def render(
    camera: Camera, objects: Sequence[tuple[ObjectModel, Poses, int]], background: int = BACKGROUND
) -> np.ndarray:
    """(H, W) the class that fills most of each pixel; `objects` are (model, one hypothesis, label)."""
    placed = []
    for model, at, label in objects:
        joints = {c.name: float(v) for c, v in zip(model.joint_components, at.q[0], strict=True)}
        placed.append(PlacedObject(Target(model.name, model, label), Pose(at.R[0], at.t[0]), joints))
    labels = majority_labels(Renderer(camera).render(Scene(tuple(placed), (), None)).sample_labels)
    return np.where(labels == 0, background, labels).astype(np.uint8)


def covered(labels, camera: Camera, at: Poses, model: ObjectModel, share: float):
    """The same picture with something unknown over so much of the first marker of the first component, which stands in
    the object's frame, from its left."""
    (first, *_), position = model.components[0].markers, at.t[0]
    corners = first.T_component_marker.apply(np.column_stack([first.outline, np.zeros(len(first.outline))]))
    pixels = project(camera, corners @ at.R[0].T + position)
    (left, top), (right, bottom) = pixels.min(axis=0).astype(int) - 3, pixels.max(axis=0).astype(int) + 3
    out = labels.copy()
    out[max(top, 0) : bottom, max(left, 0) : left + int(share * (right - left))] = 0
    return out


def random_poses(rng: np.random.Generator, model: ObjectModel, n: int, depth=(0.8, 1.6)) -> Poses:
    """Any turn, in front of the camera, joints within their limits."""
    kin = Kinematics(model)
    z = rng.uniform(*depth, n)
    t = np.column_stack([rng.uniform(-0.3, 0.3, (n, 2)) * z[:, None], z])
    q = rng.uniform(kin.lower, kin.upper, (n, kin.n_joints))
    return Poses(rotation_from_rotvec(rng.normal(0, 1.5, (n, 3))), t, q)


def jolted(rng: np.random.Generator, poses: Poses, n: int, shift: float, turn: float, bend: float) -> Poses:
    """`n` neighbours of one hypothesis: shifted by a share of its depth, turned and bent by radians (sigmas)."""
    depth = poses.t[0, 2]
    R = rotation_from_rotvec(rng.normal(0, turn, (n, 3))) @ poses.R[0]
    t = poses.t[0] + rng.normal(0, shift * depth, (n, 3)) * (1, 1, 2)
    return Poses(R, t, poses.q[0] + rng.normal(0, bend, (n, poses.q.shape[1])))


@dataclass(frozen=True)
class StubJudge(Judge):
    """Trusts claims of votes enough by what a test gives, whatever the labels confirm of them."""

    min_votes: float = 100.0
    min_probability: float = 0.0
    given: Callable[[Verdict], float] = lambda verdict: 1.0

    def trust(self, verdict: Verdict) -> float:
        return self.given(verdict) if verdict.claim.votes > self.min_votes else 0.0

    def worth(self, verdicts: Verdicts) -> np.ndarray:
        trusted = [self.given(v) * v.claim.votes if v.claim.votes > self.min_votes else -np.inf for v in verdicts]
        return np.array(trusted)


def turn_between(A, B) -> float:
    """Angle between two rotations, radians."""
    return float(np.arccos(np.clip((np.trace(np.asarray(A).T @ B) - 1) / 2, -1, 1)))


def frames_of(surface, poses):
    return surface.kinematics.forward(poses.R, poses.t, poses.q)


def facing(surface, frames, patches):
    """(H, P) cosine of the angle under which each patch is seen."""
    c = surface.component[patches]
    normal = np.einsum("hpij,pj->hpi", frames.R[:, c], surface.normal[patches])
    centre = np.einsum("hpij,pj->hpi", frames.R[:, c], surface.centre[patches]) + frames.t[:, c]
    return -np.sum(normal * centre, axis=-1) / np.linalg.norm(centre, axis=-1)


def contour_pixels(surface, camera, poses):
    """(H, M, m, 2) where the contours of all markers land."""
    frames, c = frames_of(surface, poses), surface.component[surface.markers]
    X = np.einsum("hmij,mkj->hmki", frames.R[:, c], surface.contour) + frames.t[:, c, None]
    return project(camera, X)

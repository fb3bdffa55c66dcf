"""What the compiler has to do, in pieces that need nothing of each other: each runs a part of recognition.

They run on one example. Whatever the objects, the compiled code is the same; so it has some of everything: joints,
bodies, a disc.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import cv2
import numpy as np

from .alignment.contour_map import ContourMap
from .alignment.matching import Matches
from .alignment.placements import Evidence, Placements
from .alignment.shapes import SAMPLES, Shape
from .base.config import RecognizerConfig
from .base.deadline import Deadline
from .constraints.constraint_set import ConstraintSet
from .constraints.intervals import Interval
from .constraints.pairs import PairConstraint
from .facing_stage import FacingStage
from .flat_stage import FlatStage
from .geometry.camera import Camera
from .geometry.projection import project
from .geometry.transforms import Pose
from .grouping.packing import pack
from .image.blobs import Blob, find_blobs
from .image.image_frame import ImageFrame
from .image.label_field import LabelField
from .model.chain_kernels import face_cameras
from .model.marker import Marker
from .model.objects import Box, Component, Joint, ObjectModel
from .model.target import Target
from .pose.colour_fit import ColourFit
from .pose.contour_steps import ContourSteps
from .pose.finder import WholeObjectFinder
from .pose.guesses import Guesser
from .pose.pose_fit import contour_fit, fit_poses
from .pose.poses import Poses
from .pose.rebends import Rebends
from .pose.through_middles import Middles
from .spatial_stage import SpatialStage
from .verdict.judge import Judge
from .verdict.nearer import met_by_each
from .verdict.parts import part_probabilities

PLANE, SPACE = "plane", "space"
# whose compiled functions a part needs
ROOMS = {PLANE: ("image", "geometry", "alignment", "constraints", "grouping"),
         SPACE: ("image", "geometry", "model", "pose", "verdict")}  # fmt: skip
_SIZE_PX, _FOCAL_PX, _LABEL, _BODY = (200, 150), 150.0, 1, 2
_FACING = np.diag([1.0, -1.0, -1.0])  # a marker's frame as its camera sees it


@dataclass(frozen=True)
class Piece:
    """:param part: PLANE or SPACE. :param seconds: of CPU to compile it, about: pieces are shared out by them."""

    part: str
    seconds: float
    run: Callable[[], object]


def _target() -> Target:
    """A plate of 0.4 m on a box, and a disc on an arm beside it, facing the camera."""
    side, angle = 0.4 * (np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]) - 0.5), np.linspace(0, 2 * np.pi, 32, False)
    circle, axis = 0.2 * np.stack([np.cos(angle), np.sin(angle)], axis=1), (np.zeros(2), np.array([0.1, 0]))
    plate = Marker("plate", side, *axis, T_component_marker=Pose(_FACING, np.zeros(3)))
    disc = Marker("disc", circle, *axis, 0.2, Pose(_FACING, np.array([0.25, 0.0, 0.0])))
    box = Box(Pose(np.eye(3), np.array([0.0, 0.0, 0.06])), np.array([0.4, 0.4, 0.1]))
    joint = Joint("base", Pose(np.eye(3), np.array([0.25, 0.0, 0.0])), np.array([0.0, 0.0, 1.0]), -0.3, 0.3)
    base = Component("base", (plate,), required=True, bodies=(box,), body_label=_BODY)
    model = ObjectModel("example", (base, Component("arm", (disc,), joint=joint)))
    far = {"distance_m": Interval(0.1, 1.0)}
    pair = PairConstraint(("base", "plate"), ("arm", "disc"), 9, far, far)
    return Target(model.name, model, _LABEL, ConstraintSet(model.name, 0.95, (pair,)))


class Example:
    """A target, and a frame that shows it a metre ahead."""

    def __init__(self) -> None:
        self.target, self.config = _target(), RecognizerConfig(max_slant_deg=10.0)
        labels = np.zeros(_SIZE_PX[::-1], np.uint8)
        cv2.rectangle(labels, (40, 45), (100, 105), _LABEL, cv2.FILLED)
        cv2.circle(labels, (145, 75), 30, _LABEL, cv2.FILLED)
        K = np.array([[_FOCAL_PX, 0, 70], [0, _FOCAL_PX, 75], [0, 0, 1]])
        self.frame = ImageFrame(LabelField(labels), Camera(K, np.zeros(0), _SIZE_PX))
        self.blobs = find_blobs(labels, {_LABEL}, self.config)

    @property
    def blob(self) -> Blob:
        """The plate's."""
        return self.blobs[0]

    def finder(self) -> WholeObjectFinder:
        return WholeObjectFinder(self.target, self.config)

    def ahead(self, finder: WholeObjectFinder) -> Poses:
        return Poses(np.eye(3)[None], np.array([[0.0, 0.0, 1.0]]), finder.surface.kinematics.middle[None])


example = cache(Example)


def _bend() -> None:
    finder = example().finder()
    finder.surface.search_joints(example().frame, example().ahead(finder), finder.first_grids)
    rebends = Rebends(finder.surface, finder.config.search, finder.config.votes.hidden_cost)
    rebends.of(example().frame, example().ahead(finder))


def _fit() -> None:
    finder = example().finder()
    poses, use = example().ahead(finder), np.ones((1, len(finder.surface.markers)), bool)
    fit_poses(finder.surface, example().frame, poses, use, (3, 2), finder.config.fit)
    fit = contour_fit(finder.surface, example().frame, poses, use, 3, finder.config.fit)
    steps = ContourSteps(finder.surface, finder.config.fit, facing=False)
    steps.step(steps.begun(example().frame, use), poses, fit, fit.residual, fit.weight)
    finder.refit.of(example().frame, poses, (0.0, np.inf))


def _look() -> None:
    """For edges of colours."""
    finder, image = example().finder(), np.repeat(example().frame.field.codes[..., None], 3, axis=2)
    used = np.ones((1, len(finder.surface.markers)), bool)
    seen = replace(example().frame, image=image), example().ahead(finder)
    fit = ColourFit(finder.surface, finder.config)
    fit.edges(*seen, used)
    fit.fitted(*seen, used)


def _go_through() -> None:
    finder, camera = example().finder(), example().frame.camera
    poses, patches = example().ahead(finder), finder.surface.markers
    at = finder.through_middles.places(poses, patches)[0]
    middles = Middles(patches, project(camera, at), camera.focal_px / at[:, 2])
    finder.through_middles.begun(camera, poses, middles)


def _climb() -> None:
    finder = example().finder()
    finder.warm_up(example().frame, example().ahead(finder))


def _guess() -> None:
    finder = example().finder()
    Guesser(finder.target.model, finder.surface, finder.root, finder.config).guess(example().frame, example().blob)


def _show() -> None:
    surface, poses = (finder := example().finder()).surface, example().ahead(finder)
    finder.alternatives.read([example().frame] * len(poses), poses)
    frames, patches = surface.kinematics.seen(poses.R, poses.t, poses.q), surface.markers
    surface.place(frames, surface.centre[patches], surface.component[patches])
    surface.shown(frames, patches, 1)
    face_cameras(surface.kinematics.chain, frames.R, frames.t)  # asked where there are balls


def _judge() -> None:
    finder = example().finder()
    poses = example().ahead(finder)
    verdicts = Judge.of(finder.config).verdicts(finder, poses[[0, 0]], example().frame)
    part_probabilities(list(verdicts))
    met_by_each([verdicts[0]], [verdicts[1]], poses.t[None])


def _align() -> None:
    _stage("default").align(example().frame, example().blobs)


def _group() -> None:
    """Of placements of both markers."""
    e = example()
    shapes = [Shape.from_marker(m) for m in e.target.model.markers.values()]
    both = np.arange(2, dtype=np.int32)
    t, z = np.array([70 + 75j, 145 + 75j]), np.full(2, _FOCAL_PX, complex)
    placed = Placements.similarities(t, z, both, both, np.zeros(2, np.int32))
    found = Evidence(np.ones(2), np.ones(2), np.ones(2), np.full((2, SAMPLES), -1, np.int32))
    cmap = ContourMap.build(e.blobs, e.frame.size)
    _, rejected, _ = _stage("default").group(e.frame, Matches(shapes, placed, np.full(2, _LABEL), found, cmap))
    list(rejected)  # reasons are worked out when they are looked at
    row = np.abs(np.subtract.outer(np.arange(3), np.arange(3))) < 2  # the middle one of three is in the others' way
    pack(np.array([1.0, 1.5, 1.0]), row, 100, Deadline())


def _stage(profile: str) -> FlatStage:
    return FlatStage((example().target,), replace(example().config, profile=profile), ())


def _plane() -> None:
    for profile in ("default", "paper"):
        stage = _stage(profile)
        _, rejected, _ = stage.group(example().frame, stage.align(example().frame, example().blobs))
        list(rejected)
    example().frame.field.seam_px(_LABEL)  # asked where images are calibrated


def _space() -> None:
    found = SpatialStage((example().target,), example().config).recognize(example().frame, example().blobs)
    assert found.detections, "the example is found, so that all of the method has run"


def _face() -> None:
    example_of, stage = example(), FacingStage((example().target,), example().config)
    image = np.repeat(example_of.frame.field.codes[..., None] * np.uint8(100), 3, axis=2)
    frame = replace(example_of.frame, calibration=None, image=image)
    assert stage.recognize(frame, example_of.blobs).detections, (
        "the example is found, so that all of the method has run"
    )


PIECES = {
    "align": Piece(PLANE, 15, _align),
    "group": Piece(PLANE, 13, _group),
    "fit": Piece(SPACE, 38, _fit),
    "climb": Piece(SPACE, 17, _climb),
    "bend": Piece(SPACE, 14, _bend),
    "go through": Piece(SPACE, 3, _go_through),
    "guess": Piece(SPACE, 3, _guess),
    "look": Piece(SPACE, 1, _look),
    "show": Piece(SPACE, 3, _show),
    "judge": Piece(SPACE, 16, _judge),
}
# last, with all that the pieces do not call themselves
WHOLE = {
    PLANE: (_group, _plane),
    SPACE: (_bend, _go_through, _fit, _look, _climb, _guess, _show, _judge, _space, _face),
}

"""`artrec train --from-joints`: learns from the declared places and joints and a range of views, without any image."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from ...core.base.errors import ConfigError
from ...core.constraints.constraint_set import ConstraintSet
from ...core.learning.pair_learning import Example, learn
from ...core.model.objects import ObjectModel
from ...core.model.target import Target
from ...io.base.bars import bar
from ...io.images.cameras import load_camera
from ...simulation.config import SceneConfig
from ...simulation.joint_examples import joint_examples
from ...simulation.simulator import pinhole_camera
from ..options.scene_options import add_options, given_options
from ..options.seed import seed

_FIELDS = ("size", "elevation_deg", "tilt_rad", "joint_range")
_IMAGE_PX = (640, 480)  # constraints are metric: its size only sets how far a range of apparent sizes is off
_VIEW_ANGLE_DEG = 60.0


def add_from_joints(parser: Any) -> None:
    """The options that set the range of views."""
    group = parser.add_argument_group("with --from-joints")
    group.add_argument("--views", type=int, default=1000, metavar="N", help="views to learn from (%(default)s)")
    group.add_argument("--seed", type=seed, default=0, help="the same seed gives the same views (%(default)s)")
    group.add_argument(
        "--view-angle", type=float, default=_VIEW_ANGLE_DEG, metavar="DEG",
        help="of the image's width, without --camera-info (%(default)g)",
    )  # fmt: skip
    add_options(group, SceneConfig, _FIELDS)


def examples_from_joints(args: argparse.Namespace, model: ObjectModel) -> list[Example]:
    """What would be annotated in views of the object with its joints anywhere in their ranges.

    :raises ConfigError: markers have no places, or an option is out of its range.
    """
    if args.views < 2:
        raise ConfigError(f"--views: {args.views} is too few; 2 or more")
    if not 5 <= args.view_angle <= 150:
        raise ConfigError(f"--view-angle: {args.view_angle} is not within 5 .. 150 degrees")
    camera = load_camera(args.camera_info) if args.camera_info else pinhole_camera(_IMAGE_PX, args.view_angle)
    scene = SceneConfig(objects=(1, 1), distractors=0, facing=0.0, margin=0.0, **given_options(args, SceneConfig))
    views = joint_examples(Target(model.name, model, 1), camera, scene, args.seed, args.views)
    return [e for e in bar(views, "looking", total=args.views, unit="view", leave=False) if e]


def constraints_from(model: ObjectModel, examples: Sequence[Example], coverage: float) -> ConstraintSet:
    """:raises ConfigError: no two components are ever seen together."""
    constraints = learn(model, examples, coverage, 2)
    if not constraints.pairs and len(model.components) > 1:
        raise ConfigError(
            f"in {len(examples)} views no two components of object '{model.name}' face the camera together; "
            "widen --elevation-deg, or look at its sheet (artrec model --sheet)"
        )
    return constraints

"""`artrec simulate`: frames with known truth of any object whose file says where its markers sit."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Sequence
from typing import Any

from ..core.base.config import GREATEST_LABEL
from ..core.base.errors import ConfigError
from ..core.model.target import Target
from ..io.base.bars import bar, say
from ..io.objects.object_reader import load_object
from ..io.parameters.parameter_file import load_parameters
from ..simulation.config import SceneConfig, SensorConfig
from ..simulation.motion import MotionConfig, simulate_motion
from ..simulation.output import write_frames
from ..simulation.simulator import simulate
from .inspecting.oddities import oddities
from .options.camera_options import add_camera, camera_of
from .options.paths import path
from .options.scene_options import add_options, given_options
from .options.seed import seed

_FIRST_LABEL = 2  # 1 is the floor's by default
_MOST_NOISE = 1000.0  # from where on every pixel gets its class by chance


def add_parser(subparsers: Any) -> None:
    """Adds the command to `artrec`'s subcommands."""
    parser = subparsers.add_parser(
        "simulate",
        help="render scenes with known truth: a bag to test with and annotated images to train on",
        description="Renders random scenes of objects. Writes bag/, truth.jsonl, camera.yaml, images/ with "
        "annotations.json (COCO keypoints), and preview/. The object files must say where each marker sits (pose). The "
        "bag bears the true poses and joints, too. The same seed and options give the same bytes.",
    )
    parser.add_argument("object_files", nargs="*", type=path, metavar="OBJECT.yaml", help="objects to show")
    parser.add_argument(
        "--params-file", type=path, action="append",
        help="show the objects of this parameter file, with its labels; may be given again: later ones go before",
    )  # fmt: skip
    parser.add_argument("--label", type=int, nargs="+", help=f"class labels of the object files ({_FIRST_LABEL}, ...)")
    parser.add_argument("-o", "--output", type=path, required=True, metavar="DIR", help="a new folder")
    parser.add_argument("-s", "--storage", choices=("mcap", "sqlite3"), default="mcap", help="kind of bag (mcap)")
    parser.add_argument("--frames", type=int, default=100, help="number of frames (100)")
    parser.add_argument("--seed", type=seed, default=0, help="the same seed gives the same frames (0)")
    parser.add_argument("--colour", action="store_true", help="the bag bears colour images, too")
    parser.add_argument(
        "--noise", type=float, default=1.0,
        help="factor on the defaults of light, blur, noise and speckle (1); 0: none of them",
    )  # fmt: skip
    add_camera(parser)
    add_options(parser.add_argument_group("scene"), SceneConfig)
    add_options(parser.add_argument_group("light, optics, sensor and segmentation"), SensorConfig)
    group = parser.add_argument_group("motion")
    group.add_argument("--motion", action="store_true", help="one scene, in which objects move and joints swing")
    add_options(group, MotionConfig)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Writes the frames and says where they are."""
    targets = _targets(args)
    for line in (line for t in targets for line in oddities(t)):
        say(f"warning: {line}")
    if not 0 <= args.noise <= _MOST_NOISE:
        raise ConfigError(f"--noise: {args.noise} is not within 0 .. {_MOST_NOISE:g}")
    scene = SceneConfig(**given_options(args, SceneConfig))
    sensor = dataclasses.replace(SensorConfig().scaled(args.noise), **given_options(args, SensorConfig))
    motion = given_options(args, MotionConfig)
    if motion and not args.motion:
        raise ConfigError(f"--{next(iter(motion)).replace('_', '-')} goes with --motion")
    if args.frames < 1:
        raise ConfigError(f"--frames: {args.frames} is none; 1 or more")
    camera = camera_of(args)
    scene = _with_floor(scene, targets, chosen=args.floor_label is not None)
    if args.motion:
        frames = simulate_motion(targets, camera, scene, MotionConfig(**motion), sensor, args.seed, args.frames)
    else:
        frames = simulate(targets, camera, scene, sensor, args.seed, args.frames)
    shown = bar(frames, "rendering", total=args.frames, unit="frame", leave=False)
    write_frames(shown, targets, args.output, args.storage, args.colour)
    print(f"{args.frames} frames in {args.output}: bag, truth.jsonl, annotations.json, camera.yaml, images, preview")
    return 0


def _with_floor(scene: SceneConfig, targets: Sequence[Target], *, chosen: bool) -> SceneConfig:
    """The same scene, its floor of another class where nobody chose one and the default is an object's.

    :raises ConfigError: the class that was chosen is an object's.
    """
    of = {label: t.name for t in targets for label in labels_of(t)}
    if not scene.floor_label or scene.floor_label not in of:
        return scene
    if chosen:
        raise ConfigError(
            f"--floor-label: {scene.floor_label} is a label of '{of[scene.floor_label]}'; choose another, or 0"
        )
    return dataclasses.replace(scene, floor_label=next(n for n in range(1, GREATEST_LABEL + 1) if n not in of))


def _targets(args: argparse.Namespace) -> tuple[Target, ...]:
    if bool(args.object_files) == bool(args.params_file):
        raise ConfigError("simulate: name object files or --params-file, one of the two")
    if args.params_file:
        return load_parameters(*args.params_file).targets
    count = len(args.object_files)
    labels = args.label or range(_FIRST_LABEL, _FIRST_LABEL + count)
    if len(labels) != count:
        raise ConfigError(f"--label: {len(labels)} given for {count} object file(s)")
    for label in labels:
        if not 1 <= label <= GREATEST_LABEL:
            raise ConfigError(f"--label: {label} is not within 1 .. {GREATEST_LABEL}")
    models = [load_object(path, {}) for path in args.object_files]
    names = [model.name for model in models]
    if len(set(names)) != count:
        raise ConfigError("simulate: two object files have the same name; use --params-file to name objects")
    return tuple(Target(model.name, model, label) for model, label in zip(models, labels, strict=True))


def labels_of(target: Target) -> set[int]:
    """The class labels that an object's markers and bodies bear."""
    return {*target.labels, *(c.body_label for c in target.model.components if c.body_label is not None)}

"""`artrec simulate`: frames with known truth of any object whose file says where its markers sit."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path
from typing import Any

from tqdm import tqdm

from ..core.datatypes import Camera, Target
from ..core.errors import ConfigError
from ..io.cameras import load_camera
from ..io.objects import load_object
from ..io.parameters import load_parameters
from ..simulation.config import SceneConfig, SensorConfig
from ..simulation.output import write_frames
from ..simulation.simulator import pinhole_camera, simulate

_FIRST_LABEL = 2  # 1 is the floor's by default


def add_parser(subparsers: Any) -> None:
    """Adds the command to `artrec`'s subcommands."""
    parser = subparsers.add_parser(
        "simulate",
        help="render scenes with known truth: a bag to test with and annotated images to train on",
        description="Renders random scenes of objects. Writes bag/, truth.jsonl, images/ with annotations.json (COCO "
        "keypoints), and preview/. The object files must say where each marker sits (pose).",
    )
    parser.add_argument("object_files", nargs="*", type=Path, metavar="OBJECT.yaml", help="objects to show")
    parser.add_argument("--params-file", type=Path, help="show the objects of this parameter file, with its labels")
    parser.add_argument("--label", type=int, nargs="+", help=f"class labels of the object files ({_FIRST_LABEL}, ...)")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="a new folder")
    parser.add_argument("-s", "--storage", choices=("mcap", "sqlite3"), default="mcap", help="kind of bag (mcap)")
    parser.add_argument("--frames", type=int, default=100, help="number of frames (100)")
    parser.add_argument("--seed", type=int, default=0, help="the same seed gives the same frames (0)")
    parser.add_argument("--colour", action="store_true", help="the bag bears colour images, too")
    parser.add_argument(
        "--noise", type=float, default=1.0, help="strength of light, blur, noise and speckle (1); 0: none"
    )
    _add_camera(parser.add_argument_group("camera"))
    _add_scene(parser.add_argument_group("scene"))
    parser.set_defaults(run=run)


def _add_camera(group: Any) -> None:
    group.add_argument("--camera-info", type=Path, metavar="FILE.yaml", help="a ROS calibration file; or else:")
    group.add_argument(
        "--image-size", type=int, nargs=2, default=(320, 240), metavar=("W", "H"), help="pixels (320 240)"
    )
    group.add_argument("--view-angle", type=float, default=60.0, metavar="DEG", help="of the image's width (60)")


def _add_scene(group: Any) -> None:
    """One option for each field of `SceneConfig`, which holds defaults, units and meanings."""
    for field in dataclasses.fields(SceneConfig):
        default, meta = field.default, field.metadata
        paired = isinstance(default, tuple)
        sample = default[0] if isinstance(default, tuple) and default else default
        shown = " ".join(map(str, default)) if isinstance(default, tuple) else default
        group.add_argument(
            "--" + field.name.replace("_", "-"),
            type=int if isinstance(sample, int) else float,
            nargs=2 if paired else None,
            metavar=("MIN", "MAX") if paired else "VALUE",
            help=meta["description"] + (f" ({shown})" if shown != "" else ""),
        )


def run(args: argparse.Namespace) -> int:
    """Writes the frames and says where they are."""
    targets = _targets(args)
    given: dict[str, Any] = {f.name: getattr(args, f.name) for f in dataclasses.fields(SceneConfig)}
    given = {k: tuple(v) if isinstance(v, list) else v for k, v in given.items() if v is not None}
    scene = SceneConfig(**given)
    sensor = SensorConfig().scaled(args.noise)
    if args.frames < 1:
        raise ConfigError(f"--frames: {args.frames} is none; 1 or more")
    frames = simulate(targets, _camera(args), scene, sensor, args.seed, args.frames)
    bar = tqdm(frames, total=args.frames, unit="frame", disable=None, leave=False)
    write_frames(bar, targets, args.output, args.storage, args.colour)
    print(f"{args.frames} frames in {args.output}: bag, truth.jsonl, annotations.json, images, preview")
    return 0


def _targets(args: argparse.Namespace) -> tuple[Target, ...]:
    if bool(args.object_files) == bool(args.params_file):
        raise ConfigError("simulate: name object files or --params-file, one of the two")
    if args.params_file:
        return load_parameters(args.params_file).targets
    count = len(args.object_files)
    labels = args.label or range(_FIRST_LABEL, _FIRST_LABEL + count)
    if len(labels) != count:
        raise ConfigError(f"--label: {len(labels)} given for {count} object file(s)")
    models = [load_object(path, {}) for path in args.object_files]
    names = [model.name for model in models]
    if len(set(names)) != count:
        raise ConfigError("simulate: two object files have the same name; use --params-file to name objects")
    return tuple(Target(model.name, model, label) for model, label in zip(models, labels, strict=True))


def _camera(args: argparse.Namespace) -> Camera:
    if args.camera_info:
        return load_camera(args.camera_info, "camera_optical_frame")
    width, height = args.image_size
    if not (16 <= width <= 8192 and 16 <= height <= 8192):
        raise ConfigError(f"--image-size: {width} {height} is not within 16 .. 8192")
    if not 5 <= args.view_angle <= 150:
        raise ConfigError(f"--view-angle: {args.view_angle} is not within 5 .. 150 degrees")
    return pinhole_camera((width, height), args.view_angle)

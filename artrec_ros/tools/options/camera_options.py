"""The camera that a command reckons with: from a calibration file, or from an image size and a view angle."""

from __future__ import annotations

import argparse
from typing import Any

from ...core.base.errors import ConfigError
from ...core.geometry.camera import Camera
from ...io.images.cameras import load_camera
from ...simulation.simulator import pinhole_camera
from .paths import path


def add_camera(parser: Any, size: tuple[int, int] = (320, 240)) -> None:
    """The options --camera-info, --image-size and --view-angle, with this default size."""
    group = parser.add_argument_group("camera")
    group.add_argument("--camera-info", type=path, metavar="FILE.yaml", help="a ROS calibration file; or else:")
    group.add_argument(
        "--image-size", type=int, nargs=2, default=size, metavar=("W", "H"), help="pixels ({} {})".format(*size)
    )
    group.add_argument("--view-angle", type=float, default=60.0, metavar="DEG", help="of the image's width (60)")


def camera_of(args: argparse.Namespace) -> Camera:
    """:raises ConfigError: no calibration file, or values out of range."""
    if args.camera_info:
        return load_camera(args.camera_info, "camera_optical_frame")
    width, height = args.image_size
    if not (16 <= width <= 8192 and 16 <= height <= 8192):
        raise ConfigError(f"--image-size: {width} {height} is not within 16 .. 8192")
    if not 5 <= args.view_angle <= 150:
        raise ConfigError(f"--view-angle: {args.view_angle} is not within 5 .. 150 degrees")
    return pinhole_camera((width, height), args.view_angle)

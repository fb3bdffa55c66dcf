"""What a frame is to the search."""

from __future__ import annotations

from ..geometry.camera import Camera
from ..geometry.pixel_kernels import View
from .label_field import LabelField


def view_of(field: LabelField, camera: Camera) -> View:
    """What compiled code needs of an image and its camera."""
    height, width = field.labels.shape
    return View(field.padded, width, height, camera.matrix, camera.rational, camera.bent, camera.fold)

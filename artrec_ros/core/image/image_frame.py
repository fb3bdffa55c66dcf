"""What one frame is to the search: its labels, the camera that took them, and the time that is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from dataclasses import field as of
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..base.deadline import Deadline
from ..geometry.camera import Camera
from ..geometry.pixel_kernels import LabelView
from ..geometry.scene import Scene
from ..geometry.transforms import Array
from .label_field import LabelField


@dataclass(frozen=True, eq=False)
class ImageFrame:
    """One frame.

    :param field: the label image.
    :param calibration: of the camera that took it; None: not known, and nothing is sought in space.
    :param deadline: when the search ends with what it has.
    :param image: (H, W, 3) uint8 the colours of which the labels were made; None: the labels came as they are.
    :param scene: what is known of where objects are.
    :param gamma: the colours' values grow with light to the power of its reciprocal.
    :param expected: by their names poses at which objects of frames before are expected: turns (K, 3, 3), places (K, 3)
        and joints (K, J).
    """

    field: LabelField
    calibration: Camera | None = None
    deadline: Deadline = of(default_factory=Deadline)
    image: NDArray[np.uint8] | None = None
    scene: Scene = Scene()
    gamma: float = 1.0
    expected: Mapping[str, tuple[Array, Array, Array]] = of(default_factory=dict)

    @property
    def camera(self) -> Camera:
        """The calibration, of a frame that has one."""
        assert self.calibration is not None  # the stages in space are not asked without
        return self.calibration

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) pixels."""
        height, width = self.field.codes.shape
        return int(width), int(height)

    @cached_property
    def colours(self) -> NDArray[np.uint8]:
        """The image, of a frame that has one, as compiled code takes it: what may not be written to, or has gaps, would
        be of another kind."""
        assert self.image is not None  # the caller's condition
        return np.require(self.image, np.uint8, ["C", "W"])

    @cached_property
    def view(self) -> LabelView:
        """What compiled code needs of the labels and the camera."""
        return LabelView(self.field.padded, *self.size, *self.camera.lens)

    def without(self, solids: Sequence[NDArray[np.float32]], *, nearer: bool = False) -> ImageFrame:
        """The same frame with the pixels in convex hulls of points (n, 2) owned by somebody: see `LabelField`."""
        return self.labelled(self.field.without(solids, nearer=nearer)) if solids else self

    def labelled(self, labels: LabelField) -> ImageFrame:
        """The same frame with other labels."""
        return self._but("field", labels)

    @cached_property
    def unowned(self) -> ImageFrame:
        """The same frame with no pixel owned by anybody."""
        return self if self.field.unowned is self.field else self.labelled(self.field.unowned)

    def faced(self) -> ImageFrame:
        """The same frame to objects that face the camera, whichever took it: they stand on no floor."""
        return replace(self, calibration=Camera.facing(self.size), scene=replace(self.scene, floor=None))

    def expecting(self, poses: Mapping[str, tuple[Array, Array, Array]]) -> ImageFrame:
        """The same frame with what is expected in it."""
        return self._but("expected", poses)

    def unhurried(self) -> ImageFrame:
        """The same frame with all the time it takes."""
        return self._but("deadline", Deadline())

    def hurried(self, share: float) -> ImageFrame:
        """The same frame with a share of the time that is left, so that later stages get theirs."""
        return self._but("deadline", self.deadline.part(share))

    def _but(self, name: str, value: LabelField | Deadline | Mapping[str, tuple[Array, Array, Array]]) -> ImageFrame:
        """The same frame with another value, and with what is known of the others: some forty are made of each image,
        and `replace` would have all worked out anew for each."""
        other, known = object.__new__(type(self)), {**self.__dict__, name: value}
        known.pop("unowned", None)
        if name == "field":
            known.pop("view", None)
        other.__dict__.update(known)
        return other

"""Values that travel between the stages and out to users."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .objects import ObjectModel
from .transforms import Array, Pose, readonly

_MAX_RADIUS = 3.0  # normalised: 72 degrees from the axis


@dataclass(frozen=True)
class Camera:
    """A pinhole camera with lens distortion, in the units of the image that is given.

    :param matrix: (3, 3) K, pixels; a pixel's centre has integer coordinates.
    :param distortion: coefficients as OpenCV orders them (plumb_bob, rational_polynomial); empty: none.
    :param size: (width, height) pixels.
    :param frame_id: the optical frame, as the image's header names it.
    """

    matrix: Array
    distortion: Array
    size: tuple[int, int]
    frame_id: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "matrix", readonly(self.matrix).reshape(3, 3))
        object.__setattr__(self, "distortion", readonly(self.distortion).reshape(-1))

    @cached_property
    def rational(self) -> Array:
        """(8,) coefficients k1 k2 p1 p2 k3 k4 k5 k6 of OpenCV's rational model; those that are not given are 0."""
        return readonly(np.pad(self.distortion, (0, max(0, 8 - len(self.distortion))))[:8])

    @cached_property
    def bent(self) -> bool:
        """Whether the lens distorts at all."""
        return bool(self.distortion.any())

    @cached_property
    def fold(self) -> float:
        """Squared normalised radius up to which the lens' radial factor grows; points behind it would fold back."""
        k1, k2, _, _, k3, k4, k5, k6 = self.rational
        r = np.linspace(0, _MAX_RADIUS, 3001)
        r2 = r * r
        seen = r * (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        falls = np.flatnonzero(~(np.diff(seen) > 0))
        return float(r2[falls[0]]) if len(falls) else float(r2[-1])


@dataclass(frozen=True)
class Instance:
    """A marker found in the image: paper, step 5.

    :param x, y: centroid of the marker's outline, pixels.
    :param theta: direction of its axis (tail to head), radians from +x towards +y.
    :param scale: pixels per metre.
    :param score: 0..1, share of evidence that agrees.
    :param contour: (n, 2) the marker's outline in the image, pixels, for drawing.
    """

    component: str
    marker: str
    score: float
    x: float
    y: float
    theta: float
    scale: float
    contour: Array = field(default_factory=lambda: np.zeros((0, 2)), repr=False, compare=False)


@dataclass(frozen=True)
class ImagePose:
    """Where an object's required component lies in the image; units as in `Instance`."""

    x: float
    y: float
    theta: float
    scale: float


@dataclass(frozen=True)
class ClassFit:
    """The class of configurations that an object shows.

    :param name: None: it lies outside every class, or could be of more than one.
    :param confidence: 0..1, of the class, or that there is none.
    :param runner_up: the class that fits next best, with its confidence; None: there is one class only.
    :param reason: why it is of no class: which dimension of the best fitting one fails, by how much.
    """

    name: str | None
    confidence: float
    runner_up: str | None = None
    runner_up_confidence: float = 0.0
    reason: str = ""


@dataclass(frozen=True)
class Detection:
    """One recognised object. `pose` is the object's frame in the camera's optical frame, None without calibration.

    :param joints: component name -> joint angle in radians (metres for prismatic joints).
    :param margin: how much lighter the best choice of objects without this one is, as a share of what this one explains
        (1: nothing else explains it, 0: another choice is as good); None where that is not known.
    :param class_fit: None where the object has no classes of configurations.
    :param pose_covariance: (6, 6) of (x, y, z, rotation about x, y, z fixed axes), m^2 and rad^2; None without pose.
    """

    object: str
    id: int
    score: float
    image: ImagePose
    components: tuple[Instance, ...]
    pose: Pose | None = None
    joints: dict[str, float] = field(default_factory=dict)
    pose_covariance: Array | None = field(default=None, repr=False, compare=False)
    class_fit: ClassFit | None = None
    margin: float | None = None


@dataclass(frozen=True)
class ConstraintFailure:
    """The dimension in which a learned constraint fails most.

    :param first, second: COMPONENT/MARKER. :param dimension: as in constraint files; its name ends in its unit.
    :param low, high: what is allowed; outside: how far beyond it the value lies, its noise allowed for.
    """

    first: str
    second: str
    dimension: str
    value: float
    low: float
    high: float
    outside: float


@dataclass(frozen=True)
class Rejection:
    """A candidate that became no object, or no part of one, and why.

    :param failed: the constraint that fails by the least, where one does.
    """

    object: str
    reason: str
    score: float = 0.0
    x: float = 0.0
    y: float = 0.0
    failed: ConstraintFailure | None = None


@dataclass(frozen=True)
class FrameResult:
    """All that was recognised in one image.

    :param rejected: worked out when it is first looked at.
    :param complete: False where the time budget ended the search early.
    :param timing_ms: milliseconds per stage: segmentation, blobs, alignment, grouping, pose, total.
    """

    size: tuple[int, int]
    detections: tuple[Detection, ...] = ()
    rejected: Sequence[Rejection] = ()
    timing_ms: dict[str, float] = field(default_factory=dict)
    complete: bool = True
    labels: NDArray[np.uint8] | None = field(default=None, repr=False, compare=False)


@dataclass(frozen=True)
class Target:
    """An object to look for: its name for users, its model, its class label, its learned constraints."""

    name: str
    model: ObjectModel
    label: int
    constraints: object | None = None

"""What is known of the scene: where in the image objects can be, and the plane on which they lie."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..errors import ConfigError
from .params import param, validate

_FLAT = ("plane", "facing")
_LIMIT_PX, _LIMIT_M = 1e5, 1e4
_MOST_POINTS = 500  # half a second: each is moved, and the plane fitted anew, which grows by their square


@dataclass(frozen=True)
class PlaneConfig:
    """The plane in which the markers lie, by points of known places: `scene.plane`."""

    image_points: tuple[float, ...] = param(
        (),
        f"x, y of four to {_MOST_POINTS} points in the image, one after the other, at the markers' height; a pixel's "
        "centre has whole numbers; as the image is, the lens' distortion included; empty: no plane is known",
        unit="px",
        low=-_LIMIT_PX,
        high=_LIMIT_PX,
        paths=_FLAT,
    )
    field_points: tuple[float, ...] = param(
        (),
        "x, y of the same points in the field, in the same order; seen from above y is to the left of x",
        unit="m",
        low=-_LIMIT_M,
        high=_LIMIT_M,
        paths=_FLAT,
    )
    frame_id: str = param("field", "the field's frame, in which poses of flat objects are", paths=_FLAT)
    point_noise_px: float = param(
        0.5,
        "standard deviation of the points' pixels; it is part of the poses' covariance",
        unit="px",
        low=0,
        high=100,
        paths=_FLAT,
    )
    scale_tolerance: float = param(
        0.4,
        "no object is told whose scale differs from that of the plane at its place by a larger share, and what looks "
        "so is the less likely the farther beyond: where edges have no class, a marker of 10 px looks a quarter "
        "smaller than it is; where markers have 20 px and more, 0.1 says more",
        low=0.01,
        high=10,
        paths=_FLAT,
    )

    @property
    def is_given(self) -> bool:
        return bool(self.image_points)

    def __post_init__(self) -> None:
        validate(self, "scene.plane.")
        image, place = len(self.image_points), len(self.field_points)
        for name, n in (("image_points", image), ("field_points", place)):
            if n % 2:
                raise ConfigError(f"scene.plane.{name}: {n} numbers are given; x, y of each point make an even number")
        if image != place:
            raise ConfigError(
                f"scene.plane: image_points has {image // 2} points and field_points {place // 2}; each point needs "
                "its place in both (change both at once: ros2 param load, or one set_parameters_atomically)"
            )
        if 0 < image < 8:
            raise ConfigError(f"scene.plane.image_points: {image // 2} points are given; a plane takes four or more")
        if image > 2 * _MOST_POINTS:
            raise ConfigError(
                f"scene.plane.image_points: {image // 2} points are given, more than {_MOST_POINTS}; leave some out in "
                "both lists: a few dozen all over the field tell as much"
            )
        if not self.frame_id.strip("/"):
            raise ConfigError("scene.plane.frame_id: is empty; give the name of the field's frame, such as field")
        if self.frame_id.startswith("/") or self.frame_id.split() != [self.frame_id]:
            raise ConfigError(
                f"scene.plane.frame_id: '{self.frame_id}' is no frame that tf looks up: none has a '/' before it, or "
                "blanks; give it without, such as field"
            )


@dataclass(frozen=True)
class FloorConfig:
    """A horizontal floor on which objects stand upright, of calibrated images: `scene.floor`."""

    camera_height_m: float = param(
        0.0,
        "height of the camera above the floor; 0: nothing is known of a floor",
        unit="m",
        low=0,
        high=_LIMIT_M,
        paths=("space",),
        calibrated=True,
    )
    camera_pitch_deg: float = param(
        0.0,
        "how far the camera looks down; 0: ahead, 90: straight down",
        unit="deg",
        low=-90,
        high=90,
        paths=("space",),
        calibrated=True,
    )
    camera_roll_deg: float = param(
        0.0,
        "how far it is turned clockwise, seen from behind it: the horizon in the image rises to the right",
        unit="deg",
        low=-180,
        high=180,
        paths=("space",),
        calibrated=True,
    )
    object_height_m: float = param(
        0.0,
        "height above the floor of every object's own frame as it stands there, with z up: one number for all objects; "
        "where they are of several kinds, put the origin of each object file on the floor, and leave 0",
        unit="m",
        low=-_LIMIT_M,
        high=_LIMIT_M,
        paths=("space",),
        calibrated=True,
    )
    height_tolerance_m: float = param(
        0.1,
        "objects that are farther above or below that are none; within it fits take their height to be as sure as that "
        "of what is anywhere there",
        unit="m",
        low=0.001,
        high=_LIMIT_M,
        paths=("space",),
        calibrated=True,
    )
    max_tilt_deg: float = param(
        25.0,
        "objects that lean more are none; fits take how upright the others are likewise",
        unit="deg",
        low=1,
        high=180,
        paths=("space",),
        calibrated=True,
    )

    @property
    def is_given(self) -> bool:
        return self.camera_height_m > 0

    def __post_init__(self) -> None:
        validate(self, "scene.floor.")


@dataclass(frozen=True)
class SceneConfig:
    """What is known of the scene: `scene`. All of it is optional."""

    region: tuple[float, ...] = param(
        (),
        "x, y of the corners of a polygon in the image; outside of it nothing is looked for; empty: everywhere",
        unit="px",
        low=-_LIMIT_PX,
        high=_LIMIT_PX,
    )
    plane: PlaneConfig = field(default_factory=PlaneConfig)
    floor: FloorConfig = field(default_factory=FloorConfig)

    def __post_init__(self) -> None:
        validate(self, "scene.")
        n = len(self.region)
        if n and (n % 2 or n < 6):
            raise ConfigError(f"scene.region: {n} numbers are given; x, y of three corners or more are wanted")

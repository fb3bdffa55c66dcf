"""What became of true objects and of detections, and how far off those are that belong together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from ...core.geometry.transforms import Array, Pose
from ...core.model.found import Detection
from ...io.truth.records import TrueObject
from .same_looks import AS_IT_IS, AS_TRUE, FAR_RAD, SameLooks


@dataclass(frozen=True)
class Outcome:
    """What became of a true object.

    :param counted: whether enough of it is in view. :param detection: what lies on it; None: it was missed.
    :param hits: components of the detection but the required one, and whether each lies on the object's own.
    :param missed: components that are well visible and were not found.
    :param right: None where the truth does not speak of components.
    :param image_errors: of the components whose marker's axis was annotated: how far the marker's centre is off
        (pixels), and its direction (radians, 0 to pi; None: it looks the same in any turn): see `image_errors`.
    :param looks: after which turns it looks the same.
    """

    truth: TrueObject
    counted: bool
    detection: Detection | None = None
    hits: tuple[tuple[str, bool], ...] = ()
    missed: frozenset[str] = frozenset()
    right: bool | None = False
    image_errors: tuple[tuple[float, float | None], ...] = ()
    looks: SameLooks = AS_IT_IS

    @property
    def recognised(self) -> bool:
        return self.counted and self.detection is not None

    @property
    def identity(self) -> str | None:
        """Which of several like objects one that was found is, as the truth says it: beside its name, or in it
        (yellow_gr); None: it does not."""
        if self.detection is None or self.truth.identity:
            return self.truth.identity
        name, object_ = self.truth.name or "", self.detection.object
        return name.removeprefix(f"{object_}_") if name.startswith(f"{object_}_") else None

    @property
    def own_name(self) -> bool | None:
        """Whether it is told by its own name, of one that was found and has one; None of others."""
        found, called = self.detection, self.identity
        return None if found is None or found.identity is None or called is None else called == found.identity.name

    @property
    def anothers_name(self) -> bool:
        """Whether it is told by another's name; by none is neither."""
        found = self.detection
        return self.own_name is False and found is not None and bool(found.identity and found.identity.name)

    @property
    def _found_pose(self) -> Pose | None:
        """In the camera's frame, as the truth is; a pose on a field is no mistake, but nothing to compare."""
        return None if self.detection is None or self.detection.frame_id else self.detection.pose

    @property
    def position_error_m(self) -> float | None:
        """Of the object's origin, of what is told in another turn in which it looks the same of the point about which
        it is turned."""
        if self._found_pose is None or self.truth.pose is None:
            return None
        at = self.looks.middle if self.turned_alike else np.zeros(3)
        return float(np.linalg.norm(self._found_pose.apply(at) - self.truth.pose.apply(at)))

    @property
    def position_error(self) -> float | None:
        """Relative to the distance."""
        error, pose = self.position_error_m, self.truth.pose
        return None if error is None or pose is None else error / float(np.linalg.norm(pose.position))

    @property
    def rotation_error_rad(self) -> float | None:
        """From the nearest rotation that looks like the true one."""
        return self._rotation_error_rad(self.looks)

    @property
    def turn_told_rad(self) -> float | None:
        """From the true one itself."""
        return self._rotation_error_rad(AS_IT_IS)

    @property
    def turned_alike(self) -> bool:
        """Whether it is told in another turn in which it looks the same."""
        told, least = self.turn_told_rad, self.rotation_error_rad
        return told is not None and least is not None and told > FAR_RAD and least < told / 2

    def _rotation_error_rad(self, looks: SameLooks) -> float | None:
        if self._found_pose is None or self.truth.pose is None:
            return None
        as_true = [name for name, off in self.joint_errors.items() if off < AS_TRUE]
        return looks.error_rad(self.truth.pose.rotation, self._found_pose.rotation, as_true)

    @property
    def joint_errors(self) -> dict[str, float]:
        """Size of the difference, of the joints that both tell, in the joint's own unit."""
        found = {} if self.detection is None else self.detection.joints
        return {name: abs(found[name] - q) for name, q in self.truth.joints.items() if name in found}


@dataclass(frozen=True)
class FrameOutcome:
    """One object name in one frame: what became of each true object, and the detections that lie on none."""

    outcomes: tuple[Outcome, ...] = ()
    false: tuple[Detection, ...] = ()

    @property
    def all_well(self) -> bool:
        """Whether nothing is missed, false or not where it should be."""
        return not self.false and all(o.detection is not None and o.right is not False for o in self.outcomes)

    def but_in(self, crowds: Sequence[Array]) -> FrameOutcome:
        """The same; what lies where nobody knows what is there is not false.

        :param crowds: outlines (n, 2), pixels.
        """
        outlines = [np.asarray(outline, np.float32) for outline in crowds]
        places = [((d.image.x, d.image.y), d) for d in self.false]
        false = [d for at, d in places if not any(cv2.pointPolygonTest(o, at, False) >= 0 for o in outlines)]
        return replace(self, false=tuple(false))

"""What a truth was hardly meant to say: angles in degrees, lengths in millimetres, a joint the other way round.

Such slips leave every object found and all of its numbers wrong in the same way, which medians over all joints hide.
A slip is told where what was found fits the truth far better once it is undone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...core.geometry.transforms import Array, Pose, wrap_angle
from .outcomes import Outcome

_LEAST = 3  # objects that tell
_TIMES = 10.0  # as far off as once the slip is undone,
_LEAST_OFF = 0.03  # and as far at all, in radians or metres: what is near 0 is so in any unit

_MILLIMETRES = "in millimetres? Lengths of a truth are metres"
_TRANSPOSED = "transposed? They turn the object's axes into the camera's"
_OF_JOINTS: tuple[tuple[Callable[[Array], Array], str], ...] = (
    (np.negative, "with the other sign: does its axis point the other way there?"),
    (np.radians, "in degrees? Angles of a truth are radians"),
    (lambda q: -np.radians(q), "in degrees, and with the other sign? Angles of a truth are radians"),
)
_OF_SLIDES: tuple[tuple[Callable[[Array], Array], str], ...] = (
    (np.negative, "with the other sign: does its axis point the other way there?"),
    (lambda q: q / 1000, _MILLIMETRES),
)


def slips(outcomes: Sequence[tuple[str, Outcome]], sliding: Mapping[str, frozenset[str]]) -> Iterator[str]:
    """A line for each. :param outcomes: object name and outcome. :param sliding: object name -> prismatic joints."""
    for name in dict.fromkeys(name for name, _ in outcomes):
        met = [o for n, o in outcomes if n == name and o.recognised]
        yield from _of_poses(name, met)
        as_true = [o for o in met if not o.turned_alike]  # others may have joints bent the other way
        for joint in dict.fromkeys(j for o in as_true for j in o.joint_errors):
            pairs = [(o.detection.joints, o.truth.joints) for o in as_true if o.detection and joint in o.joint_errors]
            told, true = np.array([(found[joint], known[joint]) for found, known in pairs]).T
            slides = joint in sliding.get(name, ())
            off = np.asarray if slides else wrap_angle
            tried = [(off(told - undo(true)), words) for undo, words in (_OF_SLIDES if slides else _OF_JOINTS)]
            for words in _fitting(off(told - true), tried):
                yield f"the truth's joint '{joint}' of '{name}': {words}"


def _of_poses(name: str, met: Sequence[Outcome]) -> Iterator[str]:
    posed = [(o, o.truth.pose) for o in met if o.position_error is not None and o.truth.pose is not None]
    if not posed:
        return

    def errors(error: str, undo: Callable[[Pose], Pose] = lambda pose: pose) -> Array:
        undone = (replace(o, truth=replace(o.truth, pose=undo(pose))) for o, pose in posed)
        return np.array([getattr(o, error) for o in undone], float)

    metres = errors("position_error_m", lambda pose: Pose(pose.rotation, pose.position / 1000))
    for words in _fitting(errors("position_error_m"), [(metres, _MILLIMETRES)]):
        yield f"the truth's positions of '{name}': {words}"
    turned = errors("rotation_error_rad", lambda pose: Pose(pose.rotation.T, pose.position))
    for words in _fitting(errors("rotation_error_rad"), [(turned, _TRANSPOSED)]):
        yield f"the truth's rotations of '{name}': {words}"


def _fitting(off: Array, undone: Sequence[tuple[Array, str]]) -> Iterator[str]:
    """What is said of the slip that explains errors (n,) best, if it does. :param undone: errors without it, words."""
    best, words = min(((float(np.median(np.abs(d))), said) for d, said in undone), key=lambda one: one[0])
    if len(off) >= _LEAST and float(np.median(np.abs(off))) > max(_TIMES * best, _LEAST_OFF):
        yield words

"""Which of the node's topics stay empty with a set-up, and why."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ...core.constraints.constraint_set import ConstraintSet
from ...core.model.target import Target
from ...core.ways import FACING, PLANE, SPACE, of_way, way_of
from ...io.messages import node_topics as topics
from ...io.messages.node_topics import NodeTopic
from ...io.parameters.parameter_file import Setup

_POSES = (topics.POSES, topics.ROBOTS, topics.POSE)
_UNCALIBRATED = "images come without calibration (camera_info)"


def silent_topics(setup: Setup, calibrated: bool | None) -> Iterator[str]:
    """A line for each group of topics and objects, with what would fill them; one where poses rest on an assumption.

    :param calibrated: whether the images are; None: that is not known.
    """
    if setup.recognizer.profile == "paper":
        yield _empty(_POSES, setup.targets, "profile 'paper' tells no poses in space")
    elif calibrated is False:
        if lone := [t for t in setup.targets if not _on_plane(t, setup)]:
            yield _empty(_POSES, lone, "the images have no calibration (camera_info), and no scene.plane is given")
    else:
        if calibrated is None and (lone := [t for t in setup.targets if not _on_plane(t, setup)]):
            yield _empty(_POSES, lone, where=_UNCALIBRATED)
        spatial = of_way(SPACE, setup.targets, setup.recognizer, calibrated=True)
        if flat := [t for t in setup.targets if t not in spatial and not _on_plane(t, setup)]:
            yield (
                f"{_listed(_POSES)} of {_names(flat)}: poses follow from the size in the image, as if the markers "
                "faced the camera; their tilt is not known, and the covariance says so"
            )
    yield from _joints(setup, calibrated)
    if without := [
        t for t in setup.targets if not (isinstance(t.constraints, ConstraintSet) and t.constraints.classes)
    ]:
        yield _empty((topics.CLASSES,), without, "their constraints have no classes of configurations")
    if not setup.node.publish_tf:
        yield f"{topics.TF.name} stays empty: publish_tf is false"
    elif setup.recognizer.profile == "paper" or calibrated is False:
        yield f"{topics.TF.name} stays empty: no pose in space is told"


def _on_plane(target: Target, setup: Setup) -> bool:
    """Whether an object gets poses on a plane, calibrated or not."""
    way = way_of(target, setup.recognizer, calibrated=False)
    return setup.recognizer.scene.plane.is_given and way in (PLANE, FACING)


def _joints(setup: Setup, calibrated: bool | None) -> Iterator[str]:
    rigid = [t for t in setup.targets if not t.model.joint_names]
    if rigid:
        yield _empty((topics.JOINTS,), rigid, "their object files declare no moving joint")
    spatial = [
        t for t in setup.targets if way_of(t, setup.recognizer, calibrated=calibrated is not False) in (SPACE, FACING)
    ]
    if flat := [t for t in setup.targets if t not in rigid and t not in spatial]:
        yield _empty((topics.JOINTS,), flat, "joints are told of objects that are found as a whole, and they are not")
    elif calibrated is None and (
        moving := [
            t
            for t in spatial
            if t not in rigid and way_of(t, setup.recognizer, calibrated=False) not in (SPACE, FACING)
        ]
    ):
        yield _empty((topics.JOINTS,), moving, where=_UNCALIBRATED)


def _empty(silent: tuple[NodeTopic, ...], targets: Sequence[Target], why: str = "", where: str = "") -> str:
    stay = "stays" if len(silent) == 1 else "stay"
    return f"{_listed(silent)} of {_names(targets)} {stay} empty{f': {why}' if why else f' where {where}'}"


def _listed(silent: tuple[NodeTopic, ...]) -> str:
    return ", ".join(t.of("<object>") for t in silent)


def _names(targets: Sequence[Target]) -> str:
    return ", ".join(t.name for t in targets)

"""Parameters that were set and change nothing, told by name: which way of recognition reads them, and why it is not
taken here."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from ...core.ways import way_of
from .parameter_file import Setup
from .specs import Spec

_WAYS = {
    "plane": "in the image plane",
    "facing": "of flat objects that face the camera",
    "space": "in space",
    "paper": "by profile paper",
}


def unread(
    setup: Setup, calibrated: Collection[bool] = (True, False), tried: Collection[str] | None = None
) -> list[str]:
    """A line for each parameter that is not at its default and is not read by the ways that recognition takes here.

    Of targets that are fitted in space where images are calibrated, and else found in the image plane, it is told
    which of the two reads it.

    :param calibrated: which images there are. :param tried: the parameters that are asked for instead of those that
        are not at their defaults.
    """
    specs = setup.specs
    changed = [spec for spec in specs.values() if (_is_changed(spec, setup) if tried is None else spec.name in tried)]
    return [line for spec in changed for line in _lines(spec, setup, calibrated)]


def ways_taken(setup: Setup) -> tuple[frozenset[str], frozenset[str]]:
    """The ways of recognition that a set-up's targets take in images with calibration, and in images without."""
    calibrated, bare = (
        frozenset(way_of(t, setup.recognizer, calibrated=c) for t in setup.targets) for c in (True, False)
    )
    return calibrated, bare


def _is_changed(spec: Spec, setup: Setup) -> bool:
    value = setup.resolved.get(spec.name, spec.default)
    return bool((tuple(value) if spec.is_list else value) != spec.default)


def _lines(spec: Spec, setup: Setup, there: Collection[bool]) -> Iterator[str]:
    if spec.name.startswith("tracking.") and not setup.tracking.enabled and spec.name != "tracking.enabled":
        yield f"{spec.name} changes nothing here: tracking.enabled is false"
        return
    reads, (calibrated, bare) = set(spec.paths), ways_taken(setup)
    where = " and ".join(_WAYS[way] for way in spec.paths)
    if not reads & (calibrated | bare):
        yield f"{spec.name} changes nothing here: it is read {where} alone, and {_why(spec, setup)}"
    elif not reads & calibrated and True in there:
        yield (
            f"{spec.name} changes nothing where images are calibrated, for all objects are fitted in space then: it is "
            f"read {where} alone"
        )
    elif (spec.calibrated or not reads & bare) and False in there:
        yield (
            f"{spec.name} is read only where images are calibrated"
            if True in there
            else f"{spec.name} changes nothing, for images are not calibrated"
        )


def _why(spec: Spec, setup: Setup) -> str:
    recognizer = setup.recognizer
    if recognizer.profile == "paper" or spec.paths == ("paper",):
        return f"recognizer.profile is {recognizer.profile}"
    if not any(t.model.is_spatial for t in setup.targets):
        return "no object has a place for each of its markers"
    if not recognizer.whole_object:
        return "recognizer.whole_object is false"
    if "plane" in spec.paths:
        return "all objects are found as a whole"
    return "all those with such places are flat" if "space" in spec.paths else "none of those with such places is flat"

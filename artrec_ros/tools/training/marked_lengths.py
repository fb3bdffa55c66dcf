"""An object file's lengths beside those that marked images tell."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...core.base.errors import ConfigError
from ...core.geometry.camera import Camera
from ...core.geometry.transforms import Array
from ...core.learning.lengths import Change
from ...core.learning.marked_views import LEAST_WORST_PX, WORST_SHARE, marks_of
from ...core.learning.size_fit import LEAST_VIEWS, Measured, TooFew, measure
from ...core.learning.view_fit import Far
from ...core.model.objects import ObjectModel
from ...io.learned.annotations import Annotations
from ...simulation.records import keypoint_names

_GLANCE = 24  # marked objects that are enough to see whether there is something to measure
_FEW_FAR, _FAR_PX, _FAR = 5, 5.0, 6.0  # marks that are told: so many at most, so many pixels or times as far as most


def measured_by(annotations: Annotations, model: ObjectModel, camera: Camera | None) -> Measured:
    """What marked images measure.

    :param camera: of the images; None: objects lie flat, straight below whatever camera.
    :raises ConfigError: an object of which images tell no lengths, or too few images.
    """
    if not model.is_spatial:
        lacking = next("/".join(key) for key, m in model.markers.items() if m.T_component_marker is None)
        raise ConfigError(
            f"--marks: marker {lacking} of '{model.name}' has no pose: only what says where its markers lie can be "
            "measured (docs/object_file.md); a rough guess will do"
        )
    if len(model.markers) < 2:
        raise ConfigError(f"--marks: '{model.name}' has one marker; how markers lie to each other is measured")
    if camera is None and not model.is_flat:
        raise ConfigError(
            f"--marks: '{model.name}' is not flat, so its lengths show in images of a calibrated camera alone: "
            "--camera-info"
        )
    own = annotations.of(_categories_of(model, annotations))
    own.examples(model)  # names a keypoint that is none of the object's
    marks = [marks_of(model, o.points, o.place) for o in own.objects]
    print(f"Measuring '{model.name}' in {len(marks)} marked objects ...", file=sys.stderr, flush=True)
    measured = measure(model, marks, camera)
    if isinstance(measured, TooFew):
        raise ConfigError(f"--marks: {_too_few(measured, len(marks), model.name)}")
    return measured


def _too_few(found: TooFew, marked: int, name: str) -> str:
    """:param marked: how many objects are."""
    line = f"{marked} marked objects, of which {found.showing} show two markers or more of '{name}'"
    if found.looked_at:
        line += f"; of {found.looked_at} looked at {found.near} lie about as its file has them"
    line += f"; {LEAST_VIEWS} such are wanted, a dozen are better"
    if found.off_px:
        off = np.array(found.off_px)
        line += (
            f". In the others ends lie {np.median(off):.0f} px off (median; {off.min():.0f} to {off.max():.0f}), more "
            f"than {LEAST_WORST_PX:g} px and {WORST_SHARE:.0%} of the object's size there: is it marked as the file "
            "says, tail and head, or are its parts placed otherwise?"
        )
    return line


def _categories_of(model: ObjectModel, annotations: Annotations) -> list[str]:
    """Those of which all keypoints are the object's; none where there are none."""
    known = set(keypoint_names(model))
    return [name for name, keypoints in annotations.categories.items() if known.issuperset(keypoints)]


def hint(annotations: Annotations, model: ObjectModel, camera: Camera | None, path: Path) -> Iterator[str]:
    """What `artrec train` says where marked images fit an object file clearly better with other lengths.

    :param path: the object file.
    """
    if not model.is_spatial or (camera is None and not model.is_flat):
        return
    print("Comparing the object file's lengths with the marks ...", file=sys.stderr, flush=True)
    measured = measure(model, [marks_of(model, o.points) for o in annotations.objects], camera, _GLANCE)
    if isinstance(measured, Measured) and measured.helps:
        yield (
            f"Marked ends lie {measured.before_px:.2f} px (median) from where {path} has them, and "
            f"{measured.after_px:.2f} px with lengths that the marks themselves measure: "
            "artrec model --marks writes these."
        )


def lines(measured: Measured) -> Iterator[str]:
    """What was measured, for people to read."""
    model = measured.model
    first = model.required.markers[0].name
    yield (
        f"{measured.views} marked objects: an axis' ends lie {measured.before_px:.2f} px (median) from where the "
        f"object file has them, and {measured.after_px:.2f} px with lengths that other marked objects measured."
    )
    if not measured.helps:
        yield "The object file holds as it is: nothing is measured better, and it is copied."
    else:
        yield f"All sizes are beside {model.required.name}/{first}'s, which stays; so do limits of joints."
        yield from _table(measured.changes)
    for place in measured.left_out[:_FEW_FAR]:
        yield (
            f"{place}: its marks do not fit '{model.name}' in any pose, and it was left out: tail and head, left and "
            "right swapped, or the file far off?"
        )
    for far in _worth_a_look(measured):
        yield f"{far.place}: {far.component}/{far.marker} lies {far.off_px:.0f} px off: tail and head, left and right?"


def _table(changes: tuple[Change, ...]) -> Iterator[str]:
    width = max([len(f"{c.component}/{c.marker}") for c in changes], default=6)
    yield f"  {'marker':{width}}  size      moved, mm               turned    its component's joint moved, mm"
    for c in changes:
        name, turned = f"{c.component}/{c.marker}", f"{math.degrees(c.turn):5.1f} deg"
        joint = _mm(c.joint_shift) if c.joint_shift.any() else ""
        yield f"  {name:{width}}  x {c.size:.3f}   {_mm(c.shift)}   {turned}   {joint}".rstrip()


def _mm(shift: Array) -> str:
    return " ".join(f"{1e3 * v + 0.0:6.1f}" for v in shift)


def _worth_a_look(measured: Measured) -> tuple[Far, ...]:
    least = max(_FAR_PX, _FAR * measured.after_px)
    return tuple(far for far in measured.far[:_FEW_FAR] if far.off_px > least)

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
from ...core.learning.fixed_distances import fixed_distances
from ...core.learning.joint_limits import LimitChange
from ...core.learning.lengths import Change
from ...core.learning.marked_views import LEAST_WORST_PX, WORST_SHARE
from ...core.learning.size_fit import LEAST_VIEWS, Kept, Measured, TooFew
from ...core.learning.view_fit import Far
from ...core.model.objects import ObjectModel
from ...io.learned.annotations import Annotations
from .disc_radii import measure_but_discs
from .varying_marks import categories_of, uneven

_GLANCE = 24  # marked objects that are enough to see whether there is something to measure
_WORTH_TELLING = 0.03  # of a marker's size
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
    own = annotations.of(categories_of(model, annotations))
    own.examples(model)  # names a keypoint that is none of the object's
    print(f"Measuring '{model.name}' in {len(own.objects)} marked objects ...", file=sys.stderr, flush=True)
    measured = measure_but_discs(own, model, camera)
    if isinstance(measured, TooFew):
        raise ConfigError(f"--marks: {_too_few(measured, len(own.objects), model.name)}")
    return measured


def _too_few(found: TooFew, marked: int, name: str) -> str:
    """:param marked: how many objects are."""
    line = f"{marked} marked objects, of which {found.showing} show two markers or more of '{name}'"
    if found.looked_at:
        line += f"; of {found.looked_at} looked at {found.near} lie about as its file has them"
    line += f"; {LEAST_VIEWS} such are wanted, a dozen are better"
    untold = found.looked_at - found.near - len(found.off_px)
    if untold:
        line += (
            f". In {untold} too little is marked to tell where it is: an axis is two points, a disc one, and four or "
            "more are wanted"
        )
    if found.off_px:
        off = np.array(found.off_px)
        line += (
            f". In the others ends lie {np.median(off):.0f} px off (median; {off.min():.0f} to {off.max():.0f}), more "
            f"than {LEAST_WORST_PX:g} px and {WORST_SHARE:.0%} of the object's size there: is it marked as the file "
            "says, tail and head, or are its parts placed otherwise?"
        )
    return line


def hint(annotations: Annotations, model: ObjectModel, camera: Camera | None, path: Path) -> Iterator[str]:
    """What `artrec train` says where marked images fit an object file clearly better with other lengths.

    :param path: the object file.
    """
    if not model.is_spatial or (camera is None and not model.is_flat):
        return
    if camera is None:
        yield from uneven(annotations, model)
    print("Comparing the object file's lengths with the marks ...", file=sys.stderr, flush=True)
    measured = measure_but_discs(annotations, model, camera, _GLANCE)
    if isinstance(measured, Measured) and measured.helps:
        yield (
            f"Marked ends lie {measured.before_px:.2f} px (median) from where {path} has them, and "
            f"{measured.after_px:.2f} px with lengths that the marks themselves measure: "
            "artrec model --marks writes these, and limits of joints that go with them."
        )


def lines(measured: Measured, metric: bool) -> Iterator[str]:
    """What was measured, for people to read.

    :param metric: lengths are metres; else they may be anything, and shifts are told beside the object's size.
    """
    model = measured.model
    first = model.required.markers[0].name
    left = measured.showing - measured.views - len(measured.left_out)
    drawn = f" of {measured.showing}, evenly drawn" if left > 0 else ""
    yield (
        f"{measured.views} marked objects{drawn}: an axis' ends lie {measured.before_px:.2f} px (median) from where "
        f"the object file has them, and {measured.after_px:.2f} px with lengths that other marked objects measured."
    )
    if not measured.helps:
        if _tells_nothing(model, metric):
            yield "Pose and joints take up all that is marked: no lengths are measured, and the file is copied."
        else:
            yield "The object file holds as it is: nothing is measured better, and it is copied."
        yield from map(_too_narrow, measured.outside)
    else:
        if not metric and model.required.markers[0].disc_radius is not None and fixed_distances(model):
            yield "All lengths are at the scale that distances tell which no joint changes, the median of these."
        else:
            yield f"All sizes are beside {model.required.name}/{first}'s, which stays."
        yield from _table(measured, None if metric else measured.extent_m)
        yield from _sizes(measured)
        yield from _limits(measured.limits)
        yield from map(_stays, measured.kept)
    for place in measured.left_out[:_FEW_FAR]:
        yield (
            f"{place}: its marks do not fit '{model.name}' in any pose within its joints' limits, and it was left out: "
            "tail and head, left and right swapped, limits far too narrow, or the file far off?"
        )
    for far in _worth_a_look(measured):
        yield f"{far.place}: {far.component}/{far.marker} lies {far.off_px:.0f} px off: tail and head, left and right?"


def _tells_nothing(model: ObjectModel, metric: bool) -> bool:
    """Whether marks fit whatever lengths an object has: an axis has two ends that count, a disc its middle."""
    known = sum(4 if marker.disc_radius is None else 2 for marker in model.markers.values())
    return known <= (6 if metric else 4) + len(model.joint_components)


def _table(measured: Measured, extent_m: float | None) -> Iterator[str]:
    """:param extent_m: what shifts are shares of; None: they are told in millimetres."""
    changes = measured.changes
    unit, factor = ("mm", 1e3) if extent_m is None else ("% of object", 100 / extent_m)
    width = max([len(f"{c.component}/{c.marker}") for c in changes], default=6)
    yield f"  {'marker':{width}}  size      {f'moved, {unit}':22}  turned    its component's joint moved, {unit}"
    for c in changes:
        name, turned = f"{c.component}/{c.marker}", f"{math.degrees(c.turn):5.1f} deg"
        joint = _row(factor * c.joint_shift) if c.joint_shift.any() else ""
        size = "stays  " if _is_disc(measured.model, c) else f"x {c.size:.3f}"
        yield f"  {name:{width}}  {size}   {_row(factor * c.shift)}   {turned}   {joint}".rstrip()


def _is_disc(model: ObjectModel, change: Change) -> bool:
    marker = model.markers.get((change.component, change.marker))
    return marker is not None and marker.disc_radius is not None


def _sizes(measured: Measured) -> Iterator[str]:
    """What becomes of sizes that marks have otherwise than the object file, by more than is worth telling."""
    for c in measured.changes:
        name, more = f"{c.component}/{c.marker}", c.size - 1
        if abs(more) > _WORTH_TELLING and _is_disc(measured.model, c):
            yield (
                f"{name}: its radius stays, though marked ends lie {c.size:.2f} times as far apart: colours tell it, "
                "and artrec learn-colours says where it is too small"
            )
        elif more < -_WORTH_TELLING:
            yield (
                f"{name} becomes {-more:.0%} smaller, as it is marked: if its colour goes on beyond that (artrec "
                "learn-colours says so), enlarge it again"
            )
        elif more > _WORTH_TELLING:
            yield f"{name} becomes {more:.0%} larger, as it is marked"


def _row(shift: Array) -> str:
    return " ".join(f"{v + 0.0:6.1f}" for v in shift)


def _limits(changes: tuple[LimitChange, ...]) -> Iterator[str]:
    """What became of joints whose marked values moved towards their limits."""
    if not changes:
        yield "Limits of joints stay: they hold all that is marked."
        return
    yield "So that limits hold all that is marked, where joints have other values now:"
    for c in changes:
        turned = f"{math.degrees(c.zero):.1f} deg" if c.kind == "revolute" else f"{c.zero:.4g} along its axis"
        zero = f"its zero moves by {turned}, " if c.zero else ""
        limits = f"limits {_span(c.old)} stay" if c.new == c.old else f"limits {_span(c.old)} become {_span(c.new)}"
        yield f"  {c.name}: {zero}{limits}{_shown_by(c)}"
    yield "Limits of all other joints stay."


def _stays(kept: Kept) -> str:
    reason = "with limits that hold what is marked it would turn by more than a whole turn"
    if kept.apart is not None:
        reason = f"one half of the marked objects puts it {kept.apart:.0%} of the object from where the other half does"
    return f"Joint {kept.name} stays where the object file has it, for marks do not determine it: {reason}."


def _too_narrow(change: LimitChange) -> str:
    return (
        f"warning: joint {change.name}: limits {_span(change.old)} hold less than what is marked; "
        f"{_span(change.new)} would hold it{_shown_by(change)}"
    )


def _span(limits: tuple[float, float]) -> str:
    return f"{limits[0]:.3f}..{limits[1]:.3f}"


def _shown_by(change: LimitChange) -> str:
    places = ", ".join(dict.fromkeys(filter(None, change.shown_by)))
    return f" (for {places})" if places else ""


def _worth_a_look(measured: Measured) -> tuple[Far, ...]:
    least = max(_FAR_PX, _FAR * measured.after_px)
    return tuple(far for far in measured.far[:_FEW_FAR] if far.off_px > least)

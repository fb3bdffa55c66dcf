"""What marks of flat objects say that no lengths explain: distances and sizes that differ from picture to picture."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.learning.disc_sizes import uneven_discs
from ...core.learning.marked_views import marks_of
from ...core.learning.varying_distances import Varying, varying_distances
from ...core.model.objects import ObjectModel
from ...io.learned.annotations import Annotations
from ...simulation.records import keypoint_names

_FEW_FAR = 5  # distances that are told
_MOST = 0.9  # of the pictures: the largest ones may be slips


def uneven(own: Annotations, model: ObjectModel) -> Iterator[str]:
    """A line for each such disc, and the radius that most of it lies in.

    :param own: annotations of a flat object alone, straight from above.
    """
    for u in uneven_discs(model, [marks_of(model, o.points, o.place) for o in own.objects]):
        least, most, larger = int(u.times.argmin()), int(u.times.argmax()), float(np.quantile(u.times, _MOST))
        yield (
            f"{'/'.join(u.marker)} is marked {u.times[least]:.2f} to {u.times[most]:.2f} times as large beside "
            f"{'/'.join(u.first)} as the object file has it (least in {u.places[least]}, most in {u.places[most]}), in "
            f"{u.off} of {len(u.times)} pictures farther off than sizes are searched: a mark that is wrong, or it "
            "tilts, or comes nearer to the camera. An object is searched with all markers at one scale, and no "
            "parameter lets sizes differ. Discs that are larger than the file has them are lost sooner than smaller "
            f"ones: with radius {max(larger, 1.0) * u.radius_m:.3g} nine in ten are no larger"
        )


def varying(annotations: Annotations, model: ObjectModel) -> Iterator[str]:
    """A line for each two markers of a flat object whose distance no joint changes and marks do, and for each disc
    whose size they change.

    :param annotations: of images straight from above.
    """
    own = annotations.of(categories_of(model, annotations))
    found = varying_distances(model, [marks_of(model, o.points, o.place) for o in own.objects])
    for v in found[:_FEW_FAR]:
        yield (
            f"warning: {'/'.join(v.first)} and {'/'.join(v.second)}: no joint changes their distance, but marks have "
            f"it {v.least:.2f} to {v.most:.2f} times what it mostly is, off in {v.off} of {v.images} images, most in "
            f"{v.place}: a mark that is wrong, or {_why_varying(model, v)}"
        )
    if len(found) > _FEW_FAR:
        yield f"warning: so have {len(found) - _FEW_FAR} more distances"
    yield from uneven(own, model)


def _why_varying(model: ObjectModel, found: Varying) -> str:
    """What the object may do that its file does not: a component has one joint."""
    order = [c.name for c in model.components]
    joint = model.component(max(found.first[0], found.second[0], key=order.index)).joint  # parents come first
    if joint is None or joint.kind == "fixed":
        return "a joint that slides and is not declared"
    return "a limb that leaves the plane of the image, whose one joint is in use (docs/limbs.md says what to do)"


def categories_of(model: ObjectModel, annotations: Annotations) -> list[str]:
    """Those of which all keypoints are the object's; none where there are none."""
    known = set(keypoint_names(model))
    return [name for name, keypoints in annotations.categories.items() if known.issuperset(keypoints)]

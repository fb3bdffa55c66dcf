"""Lengths that marked images measure, but for radii of discs: these stay as the object file has them.

Nobody marks them well, colours mostly look larger than what is marked, and objects are found by what colours show.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ...core.geometry.camera import Camera
from ...core.learning.marked_views import marks_of
from ...core.learning.size_fit import MOST_VIEWS, Measured, TooFew, measure
from ...core.model.marker import Marker
from ...core.model.objects import ObjectModel
from ...io.learned.annotations import Annotations
from ...io.learned.marked_scales import marked_discs


def measure_but_discs(
    own: Annotations, model: ObjectModel, camera: Camera | None, most: int = MOST_VIEWS
) -> Measured | TooFew:
    """As of `measure`. What is told of a disc's size is what marks have.

    Beneath, discs are as large as they are marked: as large as their colours look, they would tell a wrong scale.

    :param own: annotations of the object alone.
    """
    times = {} if camera is not None else marked_discs(model, own.examples(model))
    marks = [marks_of(model, o.points, o.place) for o in own.objects]
    found = measure(_with_discs(model, times), marks, camera, most)
    if isinstance(found, TooFew):
        return found
    radii = {key: marker.disc_radius or 0.0 for key, marker in model.markers.items()}
    changes = tuple(replace(c, size=c.size * times.get(radii[c.component, c.marker], 1.0)) for c in found.changes)
    return replace(found, model=_with_radii_of(model, found.model), changes=changes)


def _with_discs(model: ObjectModel, times: Mapping[float, float]) -> ObjectModel:
    """An object with larger or smaller discs. :param times: radius -> how much larger."""

    def sized(marker: Marker) -> Marker:
        radius = marker.disc_radius or 0.0
        n = times.get(radius, 1.0)
        if n == 1.0:
            return marker
        outline, tail, head = (n * points for points in (marker.outline, marker.tail, marker.head))
        return replace(marker, outline=outline, tail=tail, head=head, disc_radius=n * radius)

    parts = (replace(part, markers=tuple(map(sized, part.markers))) for part in model.components)
    return replace(model, components=tuple(parts))


def _with_radii_of(given: ObjectModel, found: ObjectModel) -> ObjectModel:
    """An object with discs as large as another one's, which is the same but for lengths."""
    parts = []
    for part in found.components:
        own = ((given.component(part.name).marker(m.name), m) for m in part.markers)
        markers = [m if g.disc_radius is None else replace(g, T_component_marker=m.T_component_marker) for g, m in own]
        parts.append(replace(part, markers=tuple(markers)))
    return replace(found, components=tuple(parts))

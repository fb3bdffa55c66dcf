"""Markers from an SVG drawing: each filled shape is a marker, each named group a component. Needs svgelements."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import cv2
import numpy as np

from ...core.base.errors import ConfigError
from ...core.geometry.polygons import signed_area
from ...core.geometry.transforms import Array
from ...core.model.marker import Marker
from ..base.yaml_files import is_finite, nearest, read_text
from .marker_shapes import LooseMarker, marker_of, safe_name

_NAMESPACE = "http://www.w3.org/2000/svg"
_PPI = 96.0  # CSS: user units to the inch; a drawing with a physical width is scaled to it
_METRES = 0.0254 / _PPI
_CURVE_STEPS = 48
_PHYSICAL = re.compile(r"\s*[\d.eE+-]+\s*(mm|cm|in|pt|pc|q)\s*", re.IGNORECASE)
_GROUP_MODE = "{http://www.inkscape.org/namespaces/inkscape}groupmode"
_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
_USUAL_GROUP = re.compile(r"g[\d-]+")
_USUAL_LAYER = re.compile(
    r"(layer|ebene|calque|capa|camada|livello|laag|lager|lag|vrstva|warstwa|слой|レイヤー|图层)\W*\d*", re.IGNORECASE
)
_AXIS = ".axis"
_SPECK = 1e-3  # share of a shape's area below which another part of it is none
_ROUND = 0.01  # radii of a circle that was stretched by more than this share are those of an ellipse


def svg_markers(
    path: Path, width_m: float | None = None, told: Callable[[str], None] = lambda line: None
) -> list[LooseMarker]:
    """The filled shapes of a drawing, in its order, copies (`use`) too; strokes and text are passed over.

    A shape is named by its label (Inkscape's) or id, its component by those of the group or layer that holds it, else
    by the shape itself. Names that Inkscape gives by itself (g33, Layer 1) count only where there is no other. A line
    named NAME.axis is the axis of the shape NAME, from tail to head.

    :param width_m: width of the whole drawing; needed where the drawing does not tell it in mm, cm, in or pt.
    :param told: called with a line on shapes with a name of their own that are passed over.
    :raises ConfigError: no svgelements, no SVG, no size, no filled shape, one with a hole or of several parts.
    """
    elements = _import()
    scale = _scale(path, width_m)
    try:
        drawing = elements.SVG.parse(str(path), reify=True, ppi=_PPI)
    except Exception as error:  # svgelements raises whatever odd attributes lead to
        raise ConfigError(f"{path}: cannot be read as a drawing: {type(error).__name__}: {error}") from None
    if not isinstance(drawing, elements.SVG):
        raise ConfigError(f'{path}: its root must be <svg xmlns="{_NAMESPACE}" ...>; write that namespace there')
    shapes = list(_shapes(elements, drawing, ""))
    axes = {(g, n.removesuffix(_AXIS)): _points(elements, s, n, path)[0] for g, n, s in shapes if n.endswith(_AXIS)}
    named = {n for _, n, s in shapes if not n.endswith(_AXIS) and _is_filled(s)}
    for _, name in axes:
        if name not in named:
            raise ConfigError(f"{path}: the line '{name}{_AXIS}' is of no filled shape{nearest(name, sorted(named))}")
    if bare := sorted({n for _, n, s in shapes if not n.endswith(_AXIS) and not _is_filled(s) and _name(s)}):
        told(f"hidden or without a fill, and so no markers: {', '.join(bare)}")
    markers = []
    for group, name, shape in shapes:
        if name.endswith(_AXIS) or not _is_filled(shape):
            continue
        outline = _only_outline(_points(elements, shape, name, path), shape, f"{path}: shape '{name}'")
        if len(outline) < 3 or _area(outline) == 0:
            continue
        radius = _radius(elements, shape)
        # names need not be unique: a line in the shape's own group goes before one elsewhere
        axis = axes.get((group, name), next((axes[g, n] for g, n in axes if n == name), None))
        markers.append(_marker(path, group, name, outline, axis, radius, scale))
    if not markers:
        raise ConfigError(f"{path}: no filled shape; a marker is a path, rectangle, circle or polygon with a fill")
    return markers


def _import() -> Any:
    try:
        import svgelements
    except ImportError:
        raise ConfigError("SVG drawings need svgelements: pip install 'artrec_ros[model]'") from None
    return svgelements


def _scale(path: Path, width_m: float | None) -> float:
    """Metres to one of svgelements' units."""
    try:
        root = ElementTree.fromstring(read_text(path).encode())
    except ElementTree.ParseError as error:
        raise ConfigError(f"{path}: is no valid SVG (XML): {error}") from None
    if not root.tag.endswith("svg"):
        raise ConfigError(f"{path}: is no SVG: its root is '{root.tag}'")
    width = root.get("width", "")
    if width_m is None and not _PHYSICAL.fullmatch(width):
        raise ConfigError(f"{path}: its width '{width}' has no unit; draw in mm, or give --width in metres")
    whole = _viewbox_width(root, path) if not width or width.endswith("%") else None
    shown = float(_import().Length(width or "100%").value(ppi=_PPI, relative_length=whole))
    if not (is_finite(shown) and shown > 0):
        raise ConfigError(f"{path}: its width '{width}' is none; write one such as 200mm, or none beside a viewBox")
    return _METRES if width_m is None else width_m / shown


def _viewbox_width(root: ElementTree.Element, path: Path) -> float:
    try:
        return float(re.split(r"[\s,]+", root.get("viewBox", "").strip())[2])
    except (IndexError, ValueError):
        raise ConfigError(f"{path}: has neither a width nor a viewBox: its size is not known") from None


def _shapes(elements: Any, group: Any, name: str) -> Iterator[tuple[str, str, Any]]:
    """(name of the group, own name, shape) in drawing order."""
    for number, element in enumerate(group):
        own = _name(element)
        if isinstance(element, elements.Group):
            yield from _shapes(elements, element, _part(element, own, name))
        elif isinstance(element, elements.Use):
            while len(element) == 1 and isinstance(element[0], elements.Group):
                element = element[0]  # the copy goes by its own name
            copied = list(_shapes(elements, element, own or name))
            yield from [(name, own or copied[0][1], copied[0][2])] if len(copied) == 1 else copied
        elif isinstance(element, elements.Shape):
            yield name, own or f"{name or 'shape'}_{number + 1}", element


def _part(group: Any, own: str, enclosing: str) -> str:
    """The component that a group or layer stands for, inside another one."""
    attributes = _own(group)
    label = attributes.get(_LABEL)
    if attributes.get(_GROUP_MODE) == "layer":
        given = label is not None and not _USUAL_LAYER.fullmatch(label)
    else:
        given = label is not None or not (enclosing and _USUAL_GROUP.fullmatch(attributes.get("id") or ""))
    return (own or enclosing) if given else enclosing


def _name(element: Any) -> str:
    name = _own(element).get(_LABEL) or _own(element).get("id") or ""
    stem, axis = name.removesuffix(_AXIS), name.endswith(_AXIS)
    return safe_name(stem) + (_AXIS if axis else "") if stem else ""


def _own(element: Any) -> dict[str, str]:
    """An element's attributes without those that it inherits."""
    return element.values.get("attributes") or {}


def _is_filled(shape: Any) -> bool:
    hidden = shape.values.get("display") == "none" or shape.values.get("visibility") == "hidden"
    return not hidden and shape.fill is not None and shape.fill.value is not None


def _points(elements: Any, shape: Any, name: str, path: Path) -> list[Array]:
    """The outline of each part, (n, 2) in drawing units, y down; curves in straight pieces."""
    outlines = []
    for part in abs(elements.Path(shape)).as_subpaths():
        points: list[Any] = []
        for segment in elements.Path(part):
            if isinstance(segment, (elements.Move, elements.Line, elements.Close)):
                steps = [1.0]
            else:
                steps = list(np.arange(1, _CURVE_STEPS + 1) / _CURVE_STEPS)
            points += [segment.point(t) for t in steps if segment.end is not None]
        outline = np.array([[p.x, p.y] for p in points], float).reshape(-1, 2)
        if not np.isfinite(outline).all():
            raise ConfigError(f"{path}: shape '{name}' holds coordinates that are not finite")
        outlines.append(_without_repeats(outline))
    return outlines or [np.zeros((0, 2))]


def _only_outline(outlines: list[Array], shape: Any, place: str) -> Array:
    """The outline of a shape. :raises ConfigError: there is a hole in it, or it has several."""
    largest = max(outlines, key=_area)
    for other in outlines:
        if other is largest or _area(other) <= _SPECK * _area(largest):
            continue
        inside = cv2.pointPolygonTest(largest.astype(np.float32), tuple(map(float, other[0])), False) >= 0
        same_sense = signed_area(largest) * signed_area(other) > 0
        if inside and same_sense and shape.values.get("fill-rule") != "evenodd":
            continue  # it is filled all the same
        if inside:
            raise ConfigError(
                f"{place} has a hole; a marker is one outline without holes: fill it, or draw the parts around it as "
                "markers of their own"
            )
        raise ConfigError(f"{place} has several parts; a marker is one outline: break it apart (Inkscape: Path menu)")
    return largest


def _without_repeats(outline: Array) -> Array:
    if len(outline) < 3:
        return outline
    size = np.ptp(outline, axis=0).max()
    step = np.linalg.norm(outline - np.roll(outline, 1, axis=0), axis=1)
    return outline[step > 1e-6 * size]


def _area(outline: Array) -> float:
    return abs(signed_area(outline))


def _radius(elements: Any, shape: Any) -> float | None:
    """In drawing units, of a circle that is still one."""
    if not isinstance(shape, (elements.Circle, elements.Ellipse)):
        return None
    rx, ry = float(shape.implicit_rx), float(shape.implicit_ry)
    return rx if abs(rx - ry) <= _ROUND * max(rx, ry) else None


def _marker(
    path: Path, group: str, name: str, outline: Array, axis: Array | None, radius: float | None, scale: float
) -> LooseMarker:
    if axis is not None and len(axis) != 2:
        raise ConfigError(f"{path}: '{name}{_AXIS}' must be one straight line from tail to head")
    centre = (outline.min(axis=0) + outline.max(axis=0)) / 2
    to_marker = scale * np.array([1, -1])
    ends = None if axis is None else (axis - centre) * to_marker
    shape: Marker = marker_of(
        name, (outline - centre) * to_marker, f"{path}: shape '{name}'", ends, radius and radius * scale
    )
    return LooseMarker(group or name, shape)

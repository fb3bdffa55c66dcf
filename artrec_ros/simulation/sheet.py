"""A picture to check an object file by: its markers with axes and sizes, and the object from all sides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..core.geometry.camera import Camera
from ..core.geometry.projection import project
from ..core.geometry.transforms import Array, Pose
from ..core.model.marker import Marker
from ..core.model.target import Target
from .config import SensorConfig
from .extent import joints_at
from .render import Renderer, Rendering, to_pixel
from .scene import PlacedObject, Scene
from .sensor import colour_image, palette
from .simulator import pinhole_camera
from .surfaces import component_poses, object_surfaces

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]

_CELL_PX, _CAPTION_PX = 300, 42
_COLUMNS = 4
_VIEW_DEG = 14.0  # seen from afar, so that the sides look like a drawing
_PAPER: Colour = (250, 250, 250)
_INK: Colour = (40, 40, 40)
_FAINT: Colour = (150, 150, 150)
_AXES: tuple[Colour, ...] = ((40, 40, 230), (40, 180, 40), (230, 120, 40))  # x red, y green, z blue
_SIDES = {  # where the camera stands, in the object's frame
    "front (from +x)": (1.0, 0.0, 0.0),
    "left (from +y)": (0.0, 1.0, 0.0),
    "rear (from -x)": (-1.0, 0.0, 0.0),
    "right (from -y)": (0.0, -1.0, 0.0),
    "top (from +z)": (1e-3, 0.0, 1.0),
    "front right, above": (1.0, -0.9, 0.6),
    "rear left, above": (-1.0, 0.9, 0.6),
}
_LEAST_NAMED = 1500  # sample points of a marker that show, for its name to be drawn
_NAME_PX = 12  # between lines of names
_AROUND = ((-1, 0), (1, 0), (0, -1), (0, 1))
_FONT = cv2.FONT_HERSHEY_SIMPLEX


@dataclass(frozen=True)
class MarkerCell:
    """A marker of the sheet: `names` of the components and markers that have this shape, `notes` below them, its
    size in metres, and what its class is called."""

    marker: Marker
    label: int
    names: str
    size_m: tuple[float, float]
    notes: str = ""
    class_name: str = ""


def model_sheet(target: Target, markers: Sequence[MarkerCell]) -> Picture:
    """(H, W, 3) BGR. The object is shown where its markers have places; its joints in the middle and at their ends."""
    cells = [_marker_cell(m) for m in markers]
    if target.model.is_spatial:
        cells += _object_cells(target)
    blank = np.full_like(cells[0], _PAPER)
    rows = [cells[i : i + _COLUMNS] for i in range(0, len(cells), _COLUMNS)]
    padded = [row + [blank] * (min(len(cells), _COLUMNS) - len(row)) for row in rows]
    return np.vstack([np.hstack(row) for row in padded])


def object_picture(target: Target, joints: Mapping[str, float], azimuth_deg: float, elevation_deg: float) -> Picture:
    """(H, W, 3) BGR the object with its joints at these values, always at one scale, with its frame and names.

    :param azimuth_deg: where the camera stands: 0 on +x, 90 on +y. :param elevation_deg: how far above, below 90.
    """
    azimuth, elevation = np.radians([azimuth_deg, elevation_deg])
    across = float(np.cos(elevation))
    direction = (across * float(np.cos(azimuth)), across * float(np.sin(azimuth)), float(np.sin(elevation)))
    return _view(target)[0].cell("", direction, joints, True)[_CAPTION_PX:]


def _view(target: Target) -> tuple[_View, dict[str, list[dict[str, float]]]]:
    """What draws the object, and by joint the configurations at its two ends, the others in the middle."""
    model = target.model
    middle = joints_at(model, 0.0)
    surfaces = object_surfaces(model, target.label, middle)
    corners = np.concatenate([s.reach for s in surfaces])
    centre = (corners.min(axis=0) + corners.max(axis=0)) / 2
    ends = {name: [joints_at(model, 0.0) | {name: joints_at(model, e)[name]} for e in (-1, 1)] for name in middle}
    everything = [corners] + [s.reach for q in sum(ends.values(), []) for s in object_surfaces(model, 1, q)]
    radius = float(np.linalg.norm(np.concatenate(everything) - centre, axis=1).max())
    return _View(target, centre, radius), ends


def _object_cells(target: Target) -> list[Picture]:
    model = target.model
    middle = joints_at(model, 0.0)
    view, ends = _view(target)
    cells = [view.cell(side, direction, middle, True) for side, direction in _SIDES.items()]
    for component, (name, pair) in zip(model.joint_components, ends.items(), strict=True):
        across, unit = view.across(component.name), component.joint.unit if component.joint else ""
        cells += [view.cell(f"{name} at {q[name]:.3g} {unit}", across, q, False) for q in pair]
    return cells


class _View:
    """Draws one object from all around, always at the same scale."""

    def __init__(self, target: Target, centre: Array, radius: float) -> None:
        self._target, self._centre, self._radius = target, centre, radius
        self._camera: Camera = pinhole_camera((_CELL_PX, _CELL_PX), _VIEW_DEG)
        self._renderer = Renderer(self._camera)
        self._far = 1.05 * radius / np.tan(np.radians(_VIEW_DEG / 2))

    def across(self, component: str) -> tuple[float, float, float]:
        """A direction from which a joint's motion is seen well: along a turning axis, across a sliding one."""
        joint = self._target.model.component(component).joint
        assert joint is not None  # it is one of the moving components
        pose = component_poses(self._target.model, joints_at(self._target.model, 0.0))[component]
        axis = pose.rotation @ joint.axis
        if joint.kind == "prismatic":
            axis = np.cross(axis, (0.0, 0.0, 1.0) if abs(axis[2]) < 0.7 else (1.0, 0.0, 0.0))
        axis = axis if axis @ (0.2, -1.0, 0.1) > 0 else -axis  # rather from the right than from the left
        x, y, z = (axis + (0.25, -0.1, 0.2)).tolist()
        return x, y, z

    def cell(
        self, caption: str, direction: tuple[float, float, float], joints: Mapping[str, float], named: bool
    ) -> Picture:
        T = _looking(np.array(direction), self._centre, self._far)
        placed = PlacedObject(self._target, T, dict(joints))
        rendering = self._renderer.render(Scene((placed,), (), None))
        image = colour_image(rendering, SensorConfig().scaled(0), np.random.default_rng(0))
        shown = cv2.resize(rendering.index, (_CELL_PX, _CELL_PX), interpolation=cv2.INTER_NEAREST)
        image[shown < 0] = _PAPER
        image[_edges(shown)] = _INK
        self._draw_frame(image, T)
        if named:
            self._draw_names(image, rendering)
        return _captioned(image, caption, "")

    def _draw_frame(self, image: Picture, T: Pose) -> None:
        ends = project(self._camera, T.apply(np.vstack([np.zeros(3), 0.45 * self._radius * np.eye(3)])))
        for end, colour in zip(ends[1:], _AXES, strict=True):
            if np.linalg.norm(end - ends[0]) > 3:
                _arrow(image, ends[0], end, colour)

    def _draw_names(self, image: Picture, rendering: Rendering) -> None:
        """Each marker's name on what shows of it, below others where it would cover them."""
        names = []
        for number, surface in enumerate(rendering.surfaces):
            rows, columns = np.nonzero(rendering.index == number)
            if surface.owner is None or len(rows) < _LEAST_NAMED:
                continue
            x, y = to_pixel(columns.mean()), to_pixel(rows.mean())
            names.append((int(y), int(x), surface.owner[1]))
        taken: list[tuple[int, int, int]] = []
        for middle, centre, name in sorted(names):
            width = cv2.getTextSize(name, _FONT, 0.34, 1)[0][0]
            left, base = max(2, min(centre - width // 2, _CELL_PX - width - 2)), middle + 4
            while any(abs(base - b) < _NAME_PX and a - 2 < left + width and left < z + 2 for a, z, b in taken):
                base += 1
            taken.append((left, left + width, base))
            _text(image, name, (left, base), (255, 255, 255), 0.34, _INK)


def _edges(shown: NDArray[np.int16]) -> NDArray[np.bool_]:
    """(H, W) where one surface ends, by the numbers of those that show."""
    out = np.zeros(shown.shape, bool)
    out[1:] |= shown[1:] != shown[:-1]
    out[:, 1:] |= shown[:, 1:] != shown[:, :-1]
    return out


def _looking(direction: Array, centre: Array, far: float) -> Pose:
    """T_camera_object of a camera that stands off the centre in that direction and looks back, z up."""
    z = -direction / np.linalg.norm(direction)
    x = np.cross(z, (0.0, 0.0, 1.0))
    x = x / np.linalg.norm(x)
    R = np.stack([x, np.cross(z, x), z])  # rows: the camera's axes in the object's frame
    return Pose(R, -R @ centre + np.array([0.0, 0.0, far]))


def _marker_cell(cell: MarkerCell) -> Picture:
    """The marker as a camera that faces it sees it, with its axis, its origin and its size."""
    image = np.full((_CELL_PX, _CELL_PX, 3), _PAPER, np.uint8)
    m = cell.marker
    low, high = m.outline.min(axis=0), m.outline.max(axis=0)
    zoom = 0.68 * _CELL_PX / float(max(high - low))
    middle = (low + high) / 2

    def place(points: Array) -> Array:
        return np.asarray((np.atleast_2d(points) - middle) * (1, -1) * zoom + _CELL_PX / 2)

    polygon = np.round(place(m.outline) * 16).astype(np.int32)
    colour = tuple(int(v) for v in palette()[cell.label])
    cv2.fillPoly(image, [polygon], colour, cv2.LINE_AA, 4)
    cv2.polylines(image, [polygon], True, _INK, 1, cv2.LINE_AA, 4)
    tail, head = place(np.stack([m.tail, m.head]))
    _arrow(image, tail, head, (255, 255, 255), 3)
    _arrow(image, tail, head, _INK, 1)
    origin = place(np.zeros(2))[0].astype(int)
    cv2.drawMarker(image, (int(origin[0]), int(origin[1])), _FAINT, cv2.MARKER_CROSS, 12, 1)
    long, short = 1e3 * np.array(cell.size_m)
    _text(image, f"{long:.0f} x {short:.0f} mm, class {cell.class_name or cell.label}", (8, _CELL_PX - 8), _INK, 0.4)
    return _captioned(image, cell.names, cell.notes)


def _captioned(image: Picture, caption: str, notes: str) -> Picture:
    cell = np.full((_CELL_PX + _CAPTION_PX, _CELL_PX, 3), _PAPER, np.uint8)
    cell[_CAPTION_PX:] = image
    _text(cell, _fitting(caption, 0.43), (8, 17), _INK, 0.43)
    _text(cell, _fitting(notes, 0.36), (8, 34), (90, 90, 90), 0.36)
    cell[:1], cell[:, :1] = 215, 215
    return cell


def _fitting(text: str, size: float) -> str:
    while text and cv2.getTextSize(text, _FONT, size, 1)[0][0] > _CELL_PX - 14:
        text = text[:-4] + "..." if not text.endswith("...") else text[:-4].rstrip(".") + "..."
    return text


def _text(
    image: Picture, text: str, corner: tuple[int, int], colour: Colour, size: float, halo: Colour | None = None
) -> None:
    for dx, dy in _AROUND if halo is not None else ():  # a thicker stroke would make OpenCV 5's letters wider, too
        cv2.putText(image, text, (corner[0] + dx, corner[1] + dy), _FONT, size, halo, 1, cv2.LINE_AA)
    cv2.putText(image, text, corner, _FONT, size, colour, 1, cv2.LINE_AA)


def _arrow(image: Picture, start: Array, end: Array, colour: Colour, thickness: int = 2) -> None:
    length = float(np.linalg.norm(end - start))
    ends = [(int(round(x)), int(round(y))) for x, y in (start, end)]
    cv2.arrowedLine(image, ends[0], ends[1], colour, thickness, cv2.LINE_AA, 0, min(0.4, 9.0 / max(length, 1.0)))

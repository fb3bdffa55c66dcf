"""An object's markers at true scale as a PDF to be printed: crop marks, and a ruler that tells whether the printer
kept the scale. Needs matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from ..core.base.errors import ConfigError
from ..core.geometry.transforms import Array
from ..core.model.marker import Marker
from ..core.model.objects import ObjectModel
from ..io.base.whole_files import save_file
from ..simulation.sensor import palette
from .options.outputs import OF_PAGES

PAPERS = {"A4": (210.0, 297.0), "A3": (297.0, 420.0), "letter": (215.9, 279.4)}  # mm
_MM_PER_INCH = 25.4
_MARGIN_MM = 10.0  # more than printers leave blank
_RULER_MM, _RULER_ROOM_MM = 100.0, 18.0
_GAP_MM, _CAPTION_MM = 12.0, 4.0
_CROP_MM, _CROP_OFF_MM = 3.5, 1.5
_GREY, _INK = "#888888", "#222222"


@dataclass(frozen=True)
class Item:
    """A marker to be printed once. :param outline: (n, 2) mm, y up, least corner at 0, 0. :param axis: (2, 2) mm."""

    name: str
    outline: Array
    axis: Array
    colour: str

    @property
    def size(self) -> Array:
        """(2,) mm."""
        return np.asarray(self.outline.max(axis=0))

    def turned(self) -> Item:
        """A quarter turn to the left."""
        height = self.size[1]
        outline, axis = (np.stack([height - p[:, 1], p[:, 0]], axis=1) for p in (self.outline, self.axis))
        return replace(self, outline=outline, axis=axis)


@dataclass(frozen=True)
class Placed:
    """:param corner: (2,) mm from the page's lower left."""

    item: Item
    corner: Array


def items_of(model: ObjectModel, label: int) -> list[Item]:
    """Each marker of each component, in each class that it may have. :param label: the object's own class."""
    items = []
    for component in model.components:
        numbers = enumerate(component.classes.items(), start=label + 1)
        told = [(f" {name}", n if number is None else number) for n, (name, number) in numbers]
        for class_name, number in told or [("", component.labels(label)[0])]:
            for marker in component.markers:
                items.append(_item(f"{component.name}/{marker.name}{class_name}", marker, number))
    return items


def _item(name: str, marker: Marker, label: int) -> Item:
    low = marker.outline.min(axis=0)
    b, g, r = (int(v) for v in palette()[label])
    axis = np.stack([marker.tail, marker.head])
    return Item(name, 1e3 * (marker.outline - low), 1e3 * (axis - low), f"#{r:02x}{g:02x}{b:02x}")


def pages_of(items: Sequence[Item], paper: str) -> list[list[Placed]]:
    """The items in rows from the top, the highest first. :raises ConfigError: one is larger than the paper."""
    width, height = PAPERS[paper]
    room = np.array([width - 2 * _MARGIN_MM, height - 2 * _MARGIN_MM - _RULER_ROOM_MM])
    pages: list[list[Placed]] = []
    x = y = row = 0.0
    extra = np.array([_GAP_MM, _GAP_MM + _CAPTION_MM])
    _check_sizes(items, room - extra, paper)
    fitting = [i if (i.size + extra <= room).all() else i.turned() for i in items]
    for item in sorted(fitting, key=lambda i: -float(i.size[1])):
        size = item.size + extra
        if x + size[0] > room[0]:
            x, y, row = 0.0, y + row, 0.0
        if not pages or y + size[1] > room[1]:
            pages.append([])
            x, y, row = 0.0, 0.0, 0.0
        corner = np.array([_MARGIN_MM + x + _GAP_MM / 2, height - _MARGIN_MM - y - _GAP_MM / 2 - item.size[1]])
        pages[-1].append(Placed(item, corner))
        x, row = x + size[0], max(row, float(size[1]))
    return pages


def _check_sizes(items: Sequence[Item], most: Array, paper: str) -> None:
    """:param most: (2,) mm that a page holds. :raises ConfigError: one is larger, also when turned."""
    for item in items:
        if (item.size > most).any() and (item.size[::-1] > most).any():
            raise ConfigError(
                f"marker '{item.name}' of {item.size[0]:.1f} x {item.size[1]:.1f} mm does not fit on {paper}, which "
                f"holds {most[0]:g} x {most[1]:g} mm, either way round; --paper knows {', '.join(PAPERS)}"
            )


def print_pages(path: Path, model: ObjectModel, label: int, paper: str = "A4") -> int:
    """Writes the PDF and returns its number of pages.

    :raises ConfigError: a marker is larger than the paper, or the file cannot be written.
    """
    pages = pages_of(items_of(model, label), paper)
    file, about = BytesIO(), {"Creator": OF_PAGES}
    with mpl.rc_context({"pdf.fonttype": 42, "pdf.compression": 0}), PdfPages(file, metadata=about) as pdf:
        for number, page in enumerate(pages, start=1):
            pdf.savefig(_figure(page, paper, f"{model.name}, page {number} of {len(pages)}"))
    save_file(path, file.getvalue())
    return len(pages)


def _figure(page: Sequence[Placed], paper: str, title: str) -> Figure:
    width, height = PAPERS[paper]
    figure = Figure((width / _MM_PER_INCH, height / _MM_PER_INCH))
    FigureCanvasPdf(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0, width)
    axes.set_ylim(0, height)
    axes.axis("off")
    for placed in page:
        _draw(axes, placed)
    _draw_ruler(axes, title)
    return figure


def _draw(axes: mpl.axes.Axes, placed: Placed) -> None:
    item, corner = placed.item, placed.corner
    axes.add_patch(Polygon(item.outline + corner, closed=True, facecolor=item.colour, edgecolor="none"))
    low, high = corner, corner + item.size
    for x, out_x in ((low[0], -1), (high[0], 1)):
        for y, out_y in ((low[1], -1), (high[1], 1)):
            near, far = _CROP_OFF_MM, _CROP_OFF_MM + _CROP_MM
            axes.plot([x, x], [y + out_y * near, y + out_y * far], color=_GREY, lw=0.3)
            axes.plot([x + out_x * near, x + out_x * far], [y, y], color=_GREY, lw=0.3)
    tail, head = item.axis + corner
    told = f"{item.name}  {item.size[0]:.1f} x {item.size[1]:.1f} mm  axis {_direction(head - tail)}"
    axes.text(low[0], low[1] - _CROP_OFF_MM - _CROP_MM - 0.5, told, fontsize=5.5, va="top", color=_GREY)


def _direction(axis: Array) -> str:
    """As one looks at the page: which way the axis points."""
    degrees = float(np.degrees(np.arctan2(axis[1], axis[0])))
    names = {0: "to the right", 90: "up", 180: "to the left", -180: "to the left", -90: "down"}
    return names.get(round(degrees), f"{degrees:.0f} deg from the right, up")


def _draw_ruler(axes: mpl.axes.Axes, title: str) -> None:
    x, y = _MARGIN_MM, _MARGIN_MM + 6
    axes.plot([x, x + _RULER_MM], [y, y], color=_INK, lw=0.4)
    for mm in range(int(_RULER_MM) + 1):
        length = 4.0 if mm % 10 == 0 else 2.8 if mm % 5 == 0 else 1.6
        axes.plot([x + mm, x + mm], [y, y + length], color=_INK, lw=0.25)
        if mm % 10 == 0:
            axes.text(x + mm, y + length + 0.6, str(mm), fontsize=5, ha="center", color=_INK)
    told = (
        "This ruler is 100 mm long. If it is not on paper, print again at 100 % (actual size), not fitted to the page."
    )
    axes.text(x, y - 1.2, told, fontsize=6, va="top", color=_INK)
    axes.text(x, y - 4.2, title, fontsize=6, va="top", color=_GREY)

"""What the pages are built from: a picture to be zoomed and drawn on, work in a thread, errors as notifications."""

from __future__ import annotations

import asyncio
import base64
import functools
import math
import time
import weakref
from collections.abc import Callable, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.base.errors import ArtrecError, one_line
from ...core.geometry.transforms import Array
from ...core.warm_up import compiling

try:
    from nicegui import binding, run, ui
except ImportError as error:
    raise ArtrecError(f"artrec studio: {error}; pip install artrec_ros[studio]") from error

binding.MAX_PROPAGATION_TIME = math.inf  # else NiceGUI logs that a busy machine is busy
Point = tuple[float, float]
_STILL_PX = 1.5  # of the image: a shorter way between press and release is a click
_SLOW_S = 0.3  # work that takes longer says how long it takes

HEAD = """
<style>
.zoombox { overflow: auto; border: 1px solid #8884; border-radius: 4px; background: #8881; max-height: 78vh; }
.zoombox > div { width: 100%; position: relative; }
.zoombox img { image-rendering: pixelated; cursor: crosshair; user-select: none; }
.zoombox .rubber { position: absolute; inset: 0; width: 100%; height: 100%; pointer-events: none; }
.confusion td, .confusion th { padding: 2px 8px; text-align: right; font-variant-numeric: tabular-nums; }
.told td { padding: 0 10px 0 0; vertical-align: top; }
.mono { font-family: ui-monospace, monospace; white-space: pre-wrap; font-size: 12px; }
</style>
<script>
(() => {
  let drawing = null;
  document.addEventListener('wheel', e => {
    const box = e.target.closest && e.target.closest('.zoombox');
    if (!box) return;
    e.preventDefault();
    const inner = box.firstElementChild, was = inner.getBoundingClientRect();
    const x = (e.clientX - was.left) / was.width, y = (e.clientY - was.top) / was.height;
    const width = Math.min(12000, Math.max(box.clientWidth, was.width * (e.deltaY < 0 ? 1.25 : 0.8)));
    inner.style.width = width + 'px';
    const now = inner.getBoundingClientRect();
    box.scrollLeft += now.left + x * now.width - e.clientX;
    box.scrollTop += now.top + y * now.height - e.clientY;
  }, {passive: false});
  document.addEventListener('mousedown', e => {
    const box = e.target.closest && e.target.closest('.zoombox[data-rubber]');
    if (!box || e.button) return;
    const inner = box.firstElementChild, kind = box.dataset.rubber;
    const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    svg.setAttribute('class', 'rubber');
    const shape = document.createElementNS('http://www.w3.org/2000/svg', kind == 'line' ? 'line' : 'rect');
    for (const [k, v] of Object.entries({stroke: '#ff0', fill: 'none', 'stroke-width': 2})) shape.setAttribute(k, v);
    svg.appendChild(shape);
    inner.appendChild(svg);
    drawing = {inner, svg, shape, kind, x: e.clientX, y: e.clientY};
    document.body.style.userSelect = 'none';
  }, true);
  document.addEventListener('mousemove', e => {
    if (!drawing) return;
    const r = drawing.inner.getBoundingClientRect(), s = drawing.shape;
    const [x1, y1, x2, y2] = [drawing.x - r.left, drawing.y - r.top, e.clientX - r.left, e.clientY - r.top];
    const told = drawing.kind == 'line' ? {x1, y1, x2, y2} :
      {x: Math.min(x1, x2), y: Math.min(y1, y2), width: Math.abs(x2 - x1), height: Math.abs(y2 - y1)};
    for (const [k, v] of Object.entries(told)) s.setAttribute(k, v);
  });
  document.addEventListener('click', () => {  // keys are the page's, not those of the button or tab pressed last
    const held = document.activeElement;
    if (held && held != document.body && !['INPUT', 'TEXTAREA', 'SELECT'].includes(held.tagName)) held.blur();
  });
  document.addEventListener('mouseup', e => {
    if (!drawing || e.button) return;
    const image = drawing.inner.querySelector('img'), r = image.getBoundingClientRect();
    drawing.svg.remove();
    drawing = null;
    document.body.style.userSelect = '';
    if (e.target == image) return;  // what ends beside the picture ends at its border
    const [x, y] = [[e.clientX, r.left, r.right], [e.clientY, r.top, r.bottom]].map(
      ([v, low, high]) => Math.min(Math.max(v, low), high - 0.01));
    image.dispatchEvent(new MouseEvent('mouseup', {clientX: x, clientY: y}));
  }, true);
})();
</script>
"""


def data_url(picture: NDArray[np.uint8], lossy: bool = False) -> str:
    """A BGR picture as the browser takes it; as PNG, or JPEG where it may lose something."""
    kind, how = ("jpeg", [cv2.IMWRITE_JPEG_QUALITY, 80]) if lossy else ("png", [cv2.IMWRITE_PNG_COMPRESSION, 1])
    _, data = cv2.imencode(f".{kind}", picture, how)
    return f"data:image/{kind};base64," + base64.b64encode(data.tobytes()).decode()


class Viewer:
    """A picture that the wheel zooms. What is drawn with the mouse is told in pixels, whose centres are integers."""

    def __init__(
        self,
        on_click: Callable[[Point], Any] | None = None,
        on_drag: Callable[[Point, Point], Any] | None = None,
        rubber: str = "",
    ) -> None:
        """:param rubber: what is shown while the mouse is dragged: 'line' or 'box'."""
        self._on_click, self._on_drag = on_click, on_drag
        self._pressed: Point | None = None
        with ui.element("div").classes("zoombox w-full") as self.box:
            if rubber:
                self.box.props(f"data-rubber={rubber}")
            with ui.element("div"):
                self._image = ui.interactive_image(
                    "", events=["mousedown", "mouseup"], on_mouse=self._on_mouse, sanitize=False
                )

    def mark(self, name: str) -> Viewer:
        """A name by which tests find it."""
        self.box.props(f"data-name={name}")
        return self

    def show(self, picture: NDArray[np.uint8], lossy: bool = False) -> None:
        """:param lossy: as JPEG, a tenth of the bytes: of what is looked at for a moment."""
        self._image.set_source(data_url(picture, lossy))

    def draw(self, shapes: Sequence[str]) -> None:
        """SVG over the picture, in its pixels; a pixel's centre is drawn where it is."""
        self._image.content = f'<g transform="translate(.5 .5)">{"".join(shapes)}</g>' if shapes else ""

    def _on_mouse(self, event: Any) -> Any:
        place = (event.image_x - 0.5, event.image_y - 0.5)
        if event.button != 0:
            return None
        if event.type == "mousedown":
            self._pressed = place
            return None
        start, self._pressed = self._pressed, None
        if start is None:
            return None
        if np.hypot(place[0] - start[0], place[1] - start[1]) < _STILL_PX:
            return self._on_click(place) if self._on_click else None
        return self._on_drag(start, place) if self._on_drag else None


def polygon(outline: Array, colour: str, title: str = "", fill: float = 0.0) -> str:
    points = " ".join(f"{x:.2f},{y:.2f}" for x, y in outline)
    tip = f"<title>{title}</title>" if title else ""
    return (
        f'<polygon points="{points}" fill="{colour}" fill-opacity="{fill}" stroke="{colour}" stroke-width="2" '
        f'vector-effect="non-scaling-stroke">{tip}</polygon>'
    )


def arrow(tail: Point, head: Point, colour: str, width: float = 2.5, dashed: bool = False) -> str:
    """An axis from tail (a ring) to head (a dot)."""
    (x1, y1), (x2, y2) = tail, head
    size = max(0.6, 0.06 * float(np.hypot(x2 - x1, y2 - y1)))
    dash = 'stroke-dasharray="5 4"' if dashed else ""
    common = f'stroke="{colour}" stroke-width="{width}" vector-effect="non-scaling-stroke"'
    return (
        f'<line x1="{x1:.2f}" y1="{y1:.2f}" x2="{x2:.2f}" y2="{y2:.2f}" {common} {dash}/>'
        f'<circle cx="{x1:.2f}" cy="{y1:.2f}" r="{size:.2f}" fill="none" {common}/>'
        f'<circle cx="{x2:.2f}" cy="{y2:.2f}" r="{size:.2f}" fill="{colour}" {common}/>'
    )


def text(place: Point, words: str, colour: str, size: float) -> str:
    return (
        f'<text x="{place[0]:.1f}" y="{place[1]:.1f}" fill="{colour}" font-size="{size:.1f}" font-family="sans-serif" '
        f'stroke="#000" stroke-width="{size / 6:.2f}" paint-order="stroke">{words}</text>'
    )


def css(bgr: Sequence[int]) -> str:
    b, g, r = (int(v) for v in bgr)
    return f"#{r:02x}{g:02x}{b:02x}"


_complaints: weakref.WeakKeyDictionary[Any, Any] = weakref.WeakKeyDictionary()  # of each open page the last one


def complain(error: Exception) -> None:
    """An error as one line that stays until it is closed, or another one comes."""
    page = ui.context.client
    if page in _complaints:
        _complaints[page].dismiss()
    _complaints[page] = ui.notification(
        one_line(error), type="negative", timeout=None, multi_line=True, actions=[{"label": "close", "color": "white"}]
    )


def guarded(handler: Callable[..., Any]) -> Callable[..., Any]:
    """A handler, whose errors are told on the page."""

    @functools.wraps(handler)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return handler(*args, **kwargs)
        except Exception as error:
            return complain(error)

    return call


class Busy:
    """Work in a thread, one after the other, with a line in the page's header that says what, and for how long."""

    def __init__(self, compiled: Callable[[], float | None]) -> None:
        """:param compiled: the share of the code that is, while something waits for the rest; None: nothing does."""
        self._compiled = compiled
        self._what, self._since, self._share = "", 0.0, 0.0
        self._one, self._waiting = asyncio.Lock(), 0
        with ui.row().classes("items-center no-wrap gap-2"):
            self._spinner = ui.spinner(size="1.3em", color="white")
            self._label = ui.label().classes("text-sm").props("data-name=busy")
        self._spinner.set_visibility(False)
        ui.timer(0.2, self._tell)

    def told(self, share: float) -> None:
        """How much of the work is done; may be called from the thread."""
        self._share = share

    @property
    def at_work(self) -> bool:
        return bool(self._what)

    async def work(self, what: str, job: Callable[..., Any], *args: Any) -> Any:
        """What the job returns, once what is at work is done; None where it failed, which the page then says.

        :raises CancelledError: the window was closed meanwhile: the job is done, and there is nobody to be told.
        """
        self._waiting += 1
        self._label.props("data-busy=yes")
        try:
            async with self._one:
                return await self._do(what, job, *args)
        finally:
            self._waiting -= 1
            if not self._waiting:
                self._label.props(remove="data-busy")

    async def _do(self, what: str, job: Callable[..., Any], *args: Any) -> Any:
        self._what, self._since, self._share = what, time.monotonic(), 0.0
        self._tell()
        try:
            done = await run.io_bound(job, *args)
        except Exception as error:
            self._end_if_closed()
            complain(error)
            return None
        else:
            self._end_if_closed()
            return done
        finally:
            self._what = ""
            if not self._label.is_deleted:
                self._tell()

    def _end_if_closed(self) -> None:
        if self._label.is_deleted:
            raise asyncio.CancelledError

    def _tell(self) -> None:
        seconds, compiled, told = time.monotonic() - self._since, self._compiled(), list[str]()
        if self.at_work and seconds > _SLOW_S:
            told += [f"{self._what}{f' {self._share:.0%}' if self._share else ''} … {seconds:.0f} s"]
        if compiled is not None:  # for this window, another one, or what is learned meanwhile
            told += [f"getting ready, {compiled:.0%}: {compiling()}"]
        self._spinner.set_visibility(bool(told))
        self._label.set_text("; ".join(told))

"""Tab Colours: patches are clicked on; beside the picture stands what the learned colours make of it."""

from __future__ import annotations

import html
from pathlib import Path

import numpy as np

from ...core.base.config import ImageConfig
from ...core.drawing import object_colour
from ...core.learning.colour_learning import Learned
from ..colour_report import report
from ..studio_state.colour_marks import ColourMarks, Patch, Preview, box_between, patch_around
from ..studio_state.session import ClassPictures
from .board import Board
from .kit import Point, Viewer, css, data_url, guarded, polygon, ui

_OTHER_FRAMES = 6  # class images below
_THUMB_PX = 200
_BACKGROUND_COLOUR = "#ffffff"
_SETTLE_S = 0.4  # after the last click, until is learned


class ColoursPage:
    """One page's part. What is marked is kept at once; `Save colours` writes what was learned."""

    def __init__(self, board: Board, marks: ColourMarks) -> None:
        self._board, self._session = board, board.session
        self._marks, self._added = marks, list[str]()  # names of backgrounds that are not marked yet
        self._came = list[str]()  # all names that were here
        self._classes_of = _own(board.session.setup.image)
        self._stale = bool(self._marks.patches)
        self._build()
        self._show_others()
        board.follow("Colours", self._show)
        ui.timer(_SETTLE_S, self._learn_if_stale)

    def _build(self) -> None:
        with ui.row().classes("w-full items-center gap-3"):
            self._name = ui.toggle(self._shown_names(), value=next(iter(self._marks.names))).props(
                "data-name=class no-caps"
            )
            self._other = ui.input(placeholder="other background").props("dense").classes("w-36")
            self._other.on("keydown.enter", self._add_name)
            ui.button("Undo", on_click=guarded(self._undo)).props("flat dense data-name=undo")
            self._save = ui.button("Save colours", on_click=self._keep).props("data-name=save-colours")
            ui.label(
                "Click a patch of the chosen class: what is of one colour with it is taken. Drag a box of what is "
                "chosen. A click on a patch of the same class takes it away. The wheel zooms; keys 1 to 9 choose."
            ).classes("text-xs opacity-70")
        self._needs = ui.label().classes("text-sm text-orange").props("data-name=needs")
        self._needs.style("min-height: 1.25rem")  # its line: else the picture jumps when there is something to say
        with ui.row().classes("w-full no-wrap"):
            with ui.column().classes("w-1/2"):
                self._picture = Viewer(guarded(self._click), guarded(self._drag), "box").mark("colours-picture")
            with ui.column().classes("w-1/2"):
                self._classes = Viewer().mark("colours-classes")
        with ui.row().classes("w-full"):
            self._others = ui.row().classes("gap-1")
        self._confusion = ui.html("", sanitize=False).props("data-name=confusion")
        self._report = ui.label().classes("mono").props("data-name=colour-report")

    @property
    def _names(self) -> list[str]:
        """What can be chosen: in the order in which it came, so that keys stay what they are."""
        known = [*self._marks.names, *self._added]
        self._came += [name for name in dict.fromkeys(known) if name not in self._came]
        return [name for name in self._came if name in known]

    def _shown_names(self) -> dict[str, str]:
        return {name: f"{i} {name}" for i, name in enumerate(self._names, start=1)}

    def key(self, name: str) -> None:
        """A digit chooses a class."""
        if name.isdecimal() and 1 <= int(name) <= len(self._names):
            self._name.set_value(self._names[int(name) - 1])

    def _add_name(self) -> None:
        name = str(self._other.value or "").strip()
        if name.isidentifier():
            self._added += [] if name in self._names else [name]
            self._name.set_options(self._shown_names(), value=name)
            self._other.set_value("")
        else:
            ui.notify("a name has letters, digits and _", type="warning")

    def _click(self, place: Point) -> None:
        marked = self._marks.at(self._board.number, *place)
        if marked is not None and marked.name == self._name.value:
            self._marks.remove(marked)
        else:
            image = self._session.stills.image(self._board.number)
            self._marks.add(self._board.number, str(self._name.value), patch_around(image, *place))
        self._changed()

    def _drag(self, start: Point, end: Point) -> None:
        image = self._session.stills.image(self._board.number)
        low, high = np.zeros(2), np.array(image.shape[1::-1]) - 1.0
        corners = [tuple(np.clip(p, low, high)) for p in (start, end)]
        self._marks.add(self._board.number, str(self._name.value), box_between(corners[0], corners[1]))
        self._changed()

    def _undo(self) -> None:
        if self._marks.patches:
            self._marks.remove(self._marks.patches[-1])
            self._changed()

    def _changed(self) -> None:
        self._stale = True
        self._draw_patches()

    async def _learn_if_stale(self) -> None:
        if not (self._stale and self._marks.patches) or self._board.busy.at_work or self._board.shown != "Colours":
            return
        self._stale = False
        preview: Preview | None = await self._board.busy.work("learning colours", self._marks.preview)
        if preview is None:
            return
        told = ", ".join(f"{name} ({count} pixels)" for name, count in preview.lacking.items())
        self._needs.set_text(f"To be marked yet: {told}" if told else "")
        if preview.learned is not None:
            self._take(preview.learned)

    def _take(self, learned: Learned) -> None:
        self._classes_of = ClassPictures(learned.image)
        self._show_classes()
        self._show_others()
        self._confusion.set_content(_matrix(learned))
        self._report.set_text("\n".join(report(learned)))

    async def _keep(self) -> None:
        saved: tuple[Learned, Path] | None = await self._board.busy.work("learning colours", self._learned_and_kept)
        if saved is not None:
            self._take(saved[0])
            ui.notify(f"wrote {saved[1]} and {self._session.parameters}", type="positive")

    def _learned_and_kept(self) -> tuple[Learned, Path]:
        """One piece of work: it is written though the window be closed meanwhile."""
        learned = self._marks.learn()
        return learned, self._marks.keep(learned)

    def _show(self) -> None:
        guarded(self._show_frame)()

    def _show_frame(self) -> None:
        image = self._session.picture(self._board.number)
        self._picture.show(image)
        self._draw_patches()
        self._show_classes()

    def _draw_patches(self) -> None:
        shapes = [polygon(p.outline, self._colour(p), p.name, 0.15) for p in self._marks.of(self._board.number)]
        self._picture.draw(shapes)

    def _colour(self, patch: Patch) -> str:
        names = list(self._marks.labels)
        return css(object_colour(names, patch.name)) if patch.name in names else _BACKGROUND_COLOUR

    def _show_classes(self) -> None:
        if self._classes_of is not None:
            self._classes.show(self._classes_of.of(self._session.stills.image(self._board.number)))

    def _show_others(self) -> None:
        """Class images of frames all over the source."""
        if self._classes_of is None:
            return
        self._others.clear()
        with self._others:
            for number in self._session.stills.spread(_OTHER_FRAMES):
                thumb = ui.image(data_url(self._classes_of.of(self._session.stills.image(number))))
                thumb.style(f"width:{_THUMB_PX}px;image-rendering:pixelated;cursor:pointer")
                thumb.tooltip(self._session.stills.name(number)).on("click", lambda _, n=number: self._board.go(n))


def _own(image: ImageConfig) -> ClassPictures | None:
    """By the parameters as they are; None where these have no colours yet."""
    known = image.kind != "colour" or any(c.rgb or c.hue for c in image.classes.values())
    return ClassPictures(image) if known else None


def _matrix(learned: Learned) -> str:
    """What was marked (rows) and what its pixels are taken for (columns)."""
    columns = [*learned.image.classes, "unknown"]
    heads = "".join(f"<th>{html.escape(c)}</th>" for c in columns)
    rows = []
    for name, shares in learned.confusion.items():
        own = name if name in learned.image.classes else "unknown"
        cells = "".join(_cell(shares.get(c, 0.0), c == own) for c in columns)
        rows.append(f"<tr><th>{html.escape(name)}</th>{cells}</tr>")
    return f'<table class="confusion"><tr><th>marked as \\ seen as</th>{heads}</tr>{"".join(rows)}</table>'


def _cell(share: float, right: bool) -> str:
    colour = "60,160,60" if right else "220,60,40"
    shown = f"{share:.0%}" if share >= 0.005 else ""
    return f'<td style="background:rgba({colour},{0.75 * share if right else min(1.0, 3 * share):.2f})">{shown}</td>'

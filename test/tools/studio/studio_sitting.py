"""Sittings of `artrec studio` without a browser, over simulated pictures."""

from __future__ import annotations

from pathlib import Path

from studio_pictures import Pictures

from artrec_ros.io.sources.opening import SourceOptions
from artrec_ros.tools.studio_state.colour_marks import BACKGROUND, ColourMarks, box_between, patch_around
from artrec_ros.tools.studio_state.session import Session, load_setup
from artrec_ros.tools.studio_state.stills import open_stills


def begun(pictures: Pictures, folder: Path) -> Session:
    stills = open_stills(pictures.source, SourceOptions(), 100, folder / "frames", print)
    given = (pictures.parameters,)
    return Session(stills, folder, given, load_setup(given, folder))


def mark_colours(pictures: Pictures, session: Session, frames: tuple[int, ...] = (0, 1)) -> ColourMarks:
    marks = ColourMarks(session)
    for number in frames:
        image = session.stills.image(number)
        for name in ("team", "accent"):
            for place in pictures.middles(number, name):
                marks.add(number, name, patch_around(image, *place))
        for corner in ((0, 0), (200, 150)):
            marks.add(number, BACKGROUND, box_between(corner, (corner[0] + 40, corner[1] + 40)))
    return marks


def again(session: Session, tmp_path: Path, pictures: Pictures) -> Session:
    """Another sitting, begun with the colours of this one."""
    folder = tmp_path / "studio"
    folder.mkdir()
    (folder / "params.yaml").write_text(session.parameters.read_text().replace("../../", f"{pictures.folder.parent}/"))
    return begun(pictures, folder)

"""Pages of markers: at true scale, nothing off the paper, nothing on another marker."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.tools.main import main
from artrec_ros.tools.printing import PAPERS, items_of, pages_of, print_pages

OBJECTS = Path(__file__).resolve().parents[2] / "config" / "objects"
ALL = sorted(p.stem for p in OBJECTS.glob("*.yaml"))
_POINTS_PER_MM = 72 / 25.4


def corners(box: tuple[np.ndarray, np.ndarray]) -> list[float]:
    return [round(float(v), 1) for v in box[1] - box[0]]


def filled_boxes(pdf: bytes) -> list[tuple[np.ndarray, np.ndarray]]:
    """Lower left and upper right of each filled polygon of an uncompressed PDF, mm."""
    found = []
    for path in re.findall(rb"((?:[-\d.]+ [-\d.]+ [ml]\s+)+)h\s+f", pdf):
        points = np.array([[float(v) for v in pair] for pair in re.findall(rb"([-\d.]+) ([-\d.]+) [ml]", path)])
        found.append((points.min(axis=0) / _POINTS_PER_MM, points.max(axis=0) / _POINTS_PER_MM))
    return found


def test_what_is_printed_has_its_size(tmp_path: Path) -> None:
    model = load_object(OBJECTS / "mirosot.yaml")
    print_pages(tmp_path / "page.pdf", model, 1)
    sizes = [corners(box) for box in filled_boxes((tmp_path / "page.pdf").read_bytes())]
    assert sizes.count([53.0, 106.0]) == 1, "the team's triangle"
    assert sizes.count([53.0, 53.0]) == 6, "each small one in each of its three classes"


def test_pages_that_cannot_be_written_leave_earlier_ones(tmp_path: Path) -> None:
    (tmp_path / "page.pdf.part").mkdir()  # nothing can be written beside it
    (tmp_path / "page.pdf").write_text("as it was before")
    with pytest.raises(ConfigError, match=r"page\.pdf: cannot be written: "):
        print_pages(tmp_path / "page.pdf", load_object(OBJECTS / "mirosot.yaml"), 1)
    assert (tmp_path / "page.pdf").read_text() == "as it was before"


@pytest.mark.parametrize("paper", PAPERS)
@pytest.mark.parametrize("name", ALL)
def test_nothing_lies_on_another_or_off_the_page(name: str, paper: str) -> None:
    items = items_of(load_object(OBJECTS / f"{name}.yaml"), 2)
    room = np.array(PAPERS[paper]) - (20 + 12, 20 + 18 + 16)
    if any((i.size > room).any() and (i.turned().size > room).any() for i in items):
        with pytest.raises(ConfigError, match=f"does not fit on {paper}"):
            pages_of(items, paper)
        return
    pages = pages_of(items, paper)
    assert sorted(p.item.name for page in pages for p in page) == sorted(i.name for i in items)
    for page in pages:
        for n, placed in enumerate(page):
            low, high = placed.corner, placed.corner + placed.item.size
            assert (low >= (10, 23)).all() and (high <= np.array(PAPERS[paper]) - 10).all()
            for other in page[:n]:
                apart = (low >= other.corner + other.item.size) | (high <= other.corner)
                assert apart.any(), (placed.item.name, other.item.name)


def test_a_quarter_turn_keeps_shape_and_axis() -> None:
    (item,) = [i for i in items_of(load_object(OBJECTS / "mirosot.yaml"), 1) if i.name == "team/team"]
    turned = item.turned()
    np.testing.assert_allclose(turned.size, item.size[::-1])
    np.testing.assert_allclose(turned.turned().turned().turned().outline, item.outline, atol=1e-9)
    (x, y), (u, v) = np.diff(item.axis, axis=0)[0], np.diff(turned.axis, axis=0)[0]
    np.testing.assert_allclose((u, v), (-y, x), atol=1e-9)


def test_the_command_writes_pages(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "new" / "page.pdf"
    assert main(["model", str(OBJECTS / "vss.yaml"), "--print", str(page), "--paper", "letter"]) == 0
    assert page.read_bytes().startswith(b"%PDF") and f"Wrote {page}: 1 of letter" in capsys.readouterr().out
    assert main(["model", str(OBJECTS / "vss.yaml"), "--print", "page.png"]) == 1
    assert "--print: 'page.png' must end in .pdf" in capsys.readouterr().err


def test_the_longest_marker_of_the_tutorial_fits_on_a4(tmp_path: Path) -> None:
    text = "format: artrec_object/1\nname: mast\nmarkers: {post: {rectangle: {width: 0.036, height: 0.24}}}\n"
    (tmp_path / "mast.yaml").write_text(text + "components: {base: {required: true, markers: {post: {}}}}\n")
    assert print_pages(tmp_path / "page.pdf", load_object(tmp_path / "mast.yaml"), 1) == 1


def test_a_marker_that_is_too_large_is_named(tmp_path: Path) -> None:
    text = "format: artrec_object/1\nname: wall\nmarkers: {sheet: {rectangle: {width: 0.5, height: 0.4}}}\n"
    (tmp_path / "wall.yaml").write_text(text + "components: {base: {required: true, markers: {sheet: {}}}}\n")
    with pytest.raises(ConfigError, match=r"of 500.0 x 400.0 mm does not fit on A4, which holds 178 x 243 mm"):
        print_pages(tmp_path / "page.pdf", load_object(tmp_path / "wall.yaml"), 1)

"""The report page: one file without links to others, and, in a real browser, a gallery that can be filtered."""

from __future__ import annotations

import base64
import html.parser
import json
import re
from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from artrec_ros.core.model.frame_result import Rejection
from artrec_ros.tools.evaluate import evaluate
from artrec_ros.tools.evaluation import gallery
from artrec_ros.tools.evaluation.breakdown import component_counts
from artrec_ros.tools.evaluation.failures import failed_frames
from artrec_ros.tools.evaluation.gallery import cards
from artrec_ros.tools.main import main

from .browser import BROWSER, DRIVER, Browser
from .makers import SUMMARY, found_thing, record, true_thing, write_run, write_truth

page = pytest.importorskip("artrec_ros.tools.evaluation.page", reason="the extra `report` is not installed")
ODD = 'votes < 3 & "odd" <script>alert(1)</script>'
FRAMES = {t: [true_thing(0.05 * t - 0.2, z=1 + 0.3 * t)] for t in range(1, 6)}


def first_run(folder):
    """Of five frames: one found, one without its arm, two missed, one found with a false one beside."""
    truth = {t: (0.05 * t - 0.2, 1 + 0.3 * t) for t in FRAMES}
    records = [
        record(1, found_thing(*truth[1])),
        record(2, found_thing(*truth[2], arm=False)),
        record(3, rejected=(Rejection("thing", ODD, 0.3, 79.5 + 200 * truth[3][0] / truth[3][1], 59.5),)),
        record(4),
        record(5, found_thing(*truth[5]), found_thing(-0.9, z=3, score=0.65)),
    ]
    return write_run(folder, records, pictures=True)


def second_run(folder):
    """All found but the fourth."""
    records = [record(t, *([found_thing(0.05 * t - 0.2, 1 + 0.3 * t)] if t != 4 else []), ms=8) for t in FRAMES]
    return write_run(folder, records, pictures=True, score=0.7)


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """The page of one run, and that of two."""
    folder = tmp_path_factory.mktemp("pages")
    truth, a, b = write_truth(folder / "t.jsonl", FRAMES), first_run(folder / "first"), second_run(folder / "second")
    assert main(["evaluate", str(a), "--truth", str(truth)]) == 0
    assert main(["evaluate", str(a), str(b), "--truth", str(truth), "-o", str(folder / "out")]) == 0
    return a / "report.html", folder / "out/comparison.html"


class Checker(html.parser.HTMLParser):
    """Collects what a page refers to, its ids, and whether elements are closed in order."""

    EMPTY = {"meta", "img", "input", "br", "link"}

    def __init__(self) -> None:
        super().__init__()
        self.open, self.ids, self.references = [], [], []

    def handle_starttag(self, tag, attributes):
        if tag not in self.EMPTY:
            self.open.append(tag)
        for name, value in attributes:
            if name == "id":
                self.ids.append(value)
            if name in ("src", "href", "xlink:href"):
                self.references.append(value)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in self.EMPTY:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.mark.parametrize("number", [0, 1])
def test_the_page_is_whole_in_itself(pages, number):
    text = pages[number].read_text(encoding="utf-8")
    checker = Checker()
    checker.feed(text)
    assert checker.open == [] and len(checker.ids) == len(set(checker.ids))
    inner = {r for r in checker.references if r.startswith("#")}
    assert all(r.startswith(("#", "data:image/")) for r in checker.references)
    assert {r[1:] for r in inner} <= set(checker.ids)
    assert {r[1:] for r in re.findall(r"url\((#[^)]*)\)", text)} <= set(checker.ids)
    assert len(text) < 700_000


def test_each_figure_of_the_table_says_what_it_is(pages):
    for file in pages:
        rows = [r for r in re.findall(r"<tr>.*?</tr>", file.read_text(), re.DOTALL) if 'class="meaning' in r]
        assert any("objects in view, of them found" in r and "30 px or more in area" in r for r in rows)
        assert any("component precision" in r and "those of false detections are not judged" in r for r in rows)


def test_what_results_say_is_text_and_never_markup(pages):
    text = pages[0].read_text(encoding="utf-8")
    assert "<script>alert" not in text and "&lt;script&gt;alert" in text


def test_the_same_results_give_the_same_page(pages, tmp_path):
    before = pages[0].read_bytes()
    folder = pages[0].parent
    assert main(["evaluate", str(folder), "--truth", str(folder.parent / "t.jsonl")]) == 0
    assert pages[0].read_bytes() == before


def test_very_many_failed_frames_are_listed_in_metrics_and_a_part_on_the_page(tmp_path, monkeypatch):
    monkeypatch.setattr(gallery, "MOST_CARDS", 2)
    monkeypatch.setattr(page, "MOST_CARDS", 2)
    run = write_run(tmp_path / "r", [record(t) for t in (1, 2, 3)])
    two = [true_thing(), true_thing(0.2)]
    truth = write_truth(tmp_path / "t.jsonl", {1: two, 2: two[:1], 3: two})
    ((result,), _) = evaluate([run], truth)
    text = page.render([result])
    assert re.findall(r'<tr class="row".* data-frame="(\d)"', text) == ["1", "3"] and "Left out here: 1 failed" in text
    listed = result.to_dict()["failed_frames"]
    assert [len(f["failures"]) for f in listed] == [2, 1, 2] and listed[1]["failures"][0]["kind"] == "missed"


def test_without_overlays_the_gallery_says_so(tmp_path):
    folder = write_run(tmp_path / "r", [record(1)])
    assert main(["evaluate", str(folder), "--truth", str(write_truth(tmp_path / "t.jsonl", {1: [true_thing()]}))]) == 0
    text = (folder / "report.html").read_text()
    assert "1 failed frames without a picture" in text and "--images all" in text and "data:image" not in text
    assert '<article class="card"' not in text


@pytest.mark.parametrize("objects", [[], [true_thing()]])
def test_nothing_to_show(tmp_path, objects):
    """No object at all, and a run without a failure: figures without value, no gallery."""
    found = [found_thing() for _ in objects]
    folder = write_run(tmp_path / "r", [record(1, *found)])
    assert main(["evaluate", str(folder), "--truth", str(write_truth(tmp_path / "t.jsonl", {1: objects}))]) == 0
    assert "None: every object in view was found" in (folder / "report.html").read_text()


def test_frames_without_an_overlay_take_no_picture_from_others(tmp_path):
    """The frames in which most failed have no result at all, as where a replay was interrupted."""
    truth = {t: [true_thing(), true_thing(0.3)] if t > 2 else [true_thing()] for t in range(1, 6)}
    run = write_run(tmp_path / "r", [record(1), record(2)], pictures=True)
    ((result,), _) = evaluate([run], write_truth(tmp_path / "t.jsonl", truth))
    found = cards([result.evaluation], [failed_frames(result.evaluation)], 2)
    assert [(c.failed.frame.key, bool(c.picture)) for c in found] == [
        (1, True), (2, True), (3, False), (4, False), (5, False),
    ]  # fmt: skip


def test_components_and_names_are_told_apart(tmp_path):
    """Of four objects: one found, its arm elsewhere; one without its arm; one taken for a thing of another name."""
    truth = {t: [true_thing()] for t in (1, 2, 3, 4)}
    astray = found_thing()
    astray = replace(astray, components=(astray.components[0], replace(astray.components[1], x=10.0)))
    other = replace(found_thing(), object="bling")
    records = [record(1, astray), record(2, found_thing(arm=False)), record(3, other), record(4, found_thing(-0.9))]
    run = write_run(tmp_path / "r", records)
    summary = {"looked_for": {n: {"label": k, "required": "base"} for k, n in enumerate(("thing", "bling"), 2)}}
    (run / "summary.json").write_text(json.dumps(SUMMARY | summary))
    ((result,), _) = evaluate([run], write_truth(tmp_path / "t.jsonl", truth))
    content = result.to_dict()
    rows = {(c["object"], c["component"]): [c[k] for k in ("found", "wrong", "missed")] for c in content["components"]}
    assert rows == {("thing", "base"): [2, 1, 2], ("thing", "arm"): [0, 1, 1], ("bling", "base"): [0, 1, 0]}
    assert content["confusion"] == {"thing": {"thing": 2, "bling": 1, "nothing": 1}, "bling": {},
                                    "nothing": {"thing": 1}}  # fmt: skip
    text = page.render([result])
    assert "found as bling" in text and "by component" in text


@pytest.mark.parametrize("seen", [("tip", "arm", "base"), ("base", "arm", "tip")])
def test_components_come_in_one_order_whatever_was_found_first(seen):
    outcome = SimpleNamespace(
        counted=True,
        recognised=True,
        hits=[(name, True) for name in seen if name != "base"],
        missed=[],
        joint_errors={},
    )
    evaluation = SimpleNamespace(
        names=["thing"],
        outcomes=lambda _: [(None, outcome)],
        false=lambda _: [],
        run=SimpleNamespace(objects={"thing": SimpleNamespace(required="base")}, models={}),
        sliding={},
    )
    assert [row.component for row in component_counts(evaluation)] == ["base", "arm", "tip"]


def test_a_joint_with_a_name_of_its_own_is_its_components():
    joints = {"joint_components": [SimpleNamespace(name="arm")], "joint_names": ["lift"]}
    hit = SimpleNamespace(counted=True, recognised=True, hits=[("arm", True)], missed=[], joint_errors={"lift": 0.01})
    evaluation = SimpleNamespace(
        names=["thing"],
        outcomes=lambda _: [(None, hit)] * 3,
        false=lambda _: [],
        run=SimpleNamespace(
            objects={"thing": SimpleNamespace(required="base")}, models={"thing": SimpleNamespace(**joints)}
        ),
        sliding={"thing": frozenset({"lift"})},
    )
    arm = component_counts(evaluation)[1]
    assert (arm.component, arm.slides, arm.joint_error.value) == ("arm", True, 10.0), "millimetres"


def test_a_joint_that_is_wrong_on_its_own_marker_shows_at_its_component(tmp_path):
    """Four of forty arms are turned by half a radian where they lie on their markers all the same."""
    truth = {t: [true_thing()] for t in range(1, 41)}
    records = [record(t, found_thing(joints={"arm": 0.1 + 0.5 * (t % 10 == 0)})) for t in truth]
    run = write_run(tmp_path / "r", records)
    ((result,), _) = evaluate([run], write_truth(tmp_path / "t.jsonl", truth))
    (base, arm) = result.to_dict()["components"]
    assert base["joint_error"]["value"] is None and arm["precision"]["value"] == 1.0
    assert arm["joint_error"]["value"] == pytest.approx(np.degrees(0.5), abs=1e-3) and not arm["slides"]
    assert "<td>28.6 deg</td>" in page.render([result])


def test_pictures_mark_the_place_of_the_failure(tmp_path):
    truth = write_truth(tmp_path / "t.jsonl", {1: [true_thing(0.1)], 2: [true_thing()]})
    run = write_run(tmp_path / "r", [record(1), replace(record(2), size=None)], pictures=True)
    ((result,), _) = evaluate([run], truth)
    failed = failed_frames(result.evaluation)
    found = cards([result.evaluation], [failed], 1)
    assert [bool(c.picture) for c in found] == [True, False]
    data = np.frombuffer(base64.b64decode(found[0].picture.partition(",")[2]), np.uint8)
    picture = cv2.imdecode(data, cv2.IMREAD_COLOR).astype(int)
    red = (picture[..., 2] > 170) & (picture[..., 0] < 130)
    rows, columns = np.nonzero(red)
    assert columns.mean() == pytest.approx((79.5 + 20 + 0.5) * 4, abs=6) and rows.mean() == pytest.approx(240, abs=6)


# of every element with a text of its own: contrast by WCAG 2, and the text; plots, pictures and tags apart
_CONTRASTS = """
const rgb = c => c.match(/[\\d.]+/g).map(Number);
const light = c => rgb(c).slice(0, 3).map(v => v / 255).map(v => v <= .03928 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4)
  .reduce((sum, v, i) => sum + v * [.2126, .7152, .0722][i], 0);
const ground = e => { for (; e; e = e.parentElement) { const c = getComputedStyle(e).backgroundColor;
  if (rgb(c)[3] !== 0) { return c; } } return 'rgb(255, 255, 255)'; };
return [...document.querySelectorAll('body *')]
  .filter(e => e.offsetParent && !e.closest('svg, script, option, button:disabled'))
  .filter(e => [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim()))
  .map(e => { const pair = [light(getComputedStyle(e).color), light(ground(e))].sort((a, b) => b - a);
    return [(pair[0] + .05) / (pair[1] + .05), e.textContent.slice(0, 40)]; });
"""
browsing = pytest.mark.skipif(not (BROWSER and DRIVER), reason="no chromium with its driver on this machine")


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with Browser(tmp_path_factory.mktemp("profile"), (1280, 900)) as browser:
        yield browser


@browsing
class TestInABrowser:
    @staticmethod
    def shown(browser) -> list[str]:
        """The frames of the cards that are displayed."""
        script = "return [...document.querySelectorAll('.card')].filter(c => c.offsetParent).map(c => c.dataset.frame)"
        return browser.run(script)

    @staticmethod
    def choose(browser, **values) -> None:
        for name, value in values.items():
            browser.run(
                "const e = document.getElementById(arguments[0]); "
                "if (e.type === 'checkbox') { e.checked = arguments[1]; } else { e.value = arguments[1]; } "
                "e.dispatchEvent(new Event('input', {bubbles: true}));", name, value,
            )  # fmt: skip

    def test_the_gallery_is_filtered_by_kind_and_by_text(self, browser, pages):
        browser.open(pages[0])
        assert self.shown(browser) == ["2", "3", "4", "5"]
        self.choose(browser, kind="missed")
        assert self.shown(browser) == ["3", "4"]
        assert browser.run("return document.getElementById('count').textContent") == "2 of 4 failed frames"
        self.choose(browser, text="VOTES < 3")
        assert self.shown(browser) == ["3"]
        self.choose(browser, kind="", text="")
        self.choose(browser, kind="false")
        assert self.shown(browser) == ["5"]

    def test_a_picture_opens_at_its_own_size_and_keys_go_on(self, browser, pages):
        browser.resize(1280, 900)
        browser.open(pages[0])
        place, is_open = "return document.getElementById('place').textContent", "return viewer.open"
        large = "const i = document.getElementById('large'); return [i.getBoundingClientRect().width, i.naturalWidth]"
        press = "document.activeElement.dispatchEvent(new KeyboardEvent('keydown', {key: arguments[0], bubbles: true}))"
        assert not browser.run(is_open)
        browser.run("document.querySelector('.card button').click()")
        browser.run("return document.getElementById('large').decode()")
        assert browser.run(is_open) and browser.run(large) == [640, 640], "as wide as the replay drew it"
        assert "frame 1, 2 (1 of 4)" in browser.run(place)
        browser.run(press, "ArrowRight")
        assert "frame 2, 3 (2 of 4)" in browser.run(place)
        browser.run(press, "ArrowLeft")
        browser.run(press, "ArrowLeft")
        assert "frame 1, 2 (1 of 4)" in browser.run(place)
        browser.run("document.getElementById('shut').click()")
        assert not browser.run(is_open)

    def test_a_long_gallery_is_paged(self, browser, tmp_path):
        frames = {t: [true_thing()] for t in range(1, 41)}
        run = write_run(tmp_path / "r", [record(t) for t in frames], pictures=True)
        assert main(["evaluate", str(run), "--truth", str(write_truth(tmp_path / "t.jsonl", frames))]) == 0
        browser.resize(1280, 900)
        browser.open(run / "report.html")
        assert self.shown(browser) == [str(t) for t in range(1, 25)]
        assert browser.run("return document.documentElement.scrollHeight") < 9000
        browser.run("document.getElementById('later').click()")
        assert self.shown(browser) == [str(t) for t in range(25, 41)]
        assert browser.run("return document.getElementById('page').textContent") == "25 to 40 of 40 pictures"

    @pytest.mark.parametrize("number", [0, 1])
    def test_what_a_screen_reader_needs_is_there(self, browser, pages, number):
        browser.open(pages[number])
        assert browser.run("return document.querySelectorAll('main').length") == 1
        assert browser.run("return [...document.querySelectorAll('th')].every(h => h.scope && h.textContent.trim())")
        names = browser.run(
            "return [...document.querySelectorAll('button')].map(b => b.getAttribute('aria-label') || b.textContent)"
        )
        assert all(names) and len(names) == len(set(names))
        regions = browser.run("return [...document.querySelectorAll('[role=region]')].map(r => r.ariaLabel)")
        assert all(regions) and len(regions) == len(set(regions))

    @pytest.mark.parametrize("scheme", ["light", "dark"])
    def test_text_stands_out_in_light_and_dark(self, browser, pages, scheme):
        browser.prefer(scheme)
        browser.open(pages[1])
        contrasts = browser.run(_CONTRASTS)
        browser.prefer("light")
        assert len(contrasts) > 50 and min(c for c, _ in contrasts) >= 4.5, sorted(contrasts)[:3]

    def test_runs_are_filtered_in_a_comparison(self, browser, pages):
        browser.open(pages[1])
        assert self.shown(browser) == ["2", "3", "4", "4", "5"]
        self.choose(browser, run="1")
        assert self.shown(browser) == ["4"]
        self.choose(browser, run="", alone=True)
        assert self.shown(browser) == ["2", "3", "5"]
        rows = browser.run("return [...document.querySelectorAll('#differing tbody tr')].map(r => r.innerText)")
        assert rows[0].split() == ["recognizer.min_probability", "0.6", "0.7"]
        assert "better" in browser.run("return document.getElementById('changes-1').textContent")

    @pytest.mark.parametrize("number", [0, 1])
    @pytest.mark.parametrize("width", [1280, 380])
    def test_it_fits_wide_and_narrow_windows_without_complaint(self, browser, pages, number, width):
        browser.resize(width, 900)
        browser.open(pages[number])
        assert browser.run("return document.documentElement.scrollWidth") <= width
        plots = browser.run(
            "document.querySelectorAll('details').forEach(d => { d.open = true; }); "
            "return [...document.querySelectorAll('.panels svg')].map(s => s.getBoundingClientRect().width)"
        )
        assert len(plots) > 10 and min(plots) >= min(300, 0.8 * width)
        assert browser.complaints() == []
        picture = cv2.imdecode(np.frombuffer(browser.screenshot(), np.uint8), cv2.IMREAD_COLOR)
        assert picture.shape[1] == width and picture.std() > 5

    def test_nothing_is_fetched_from_elsewhere(self, browser, pages):
        browser.open(pages[1])
        fetched = browser.run("return performance.getEntriesByType('resource').map(e => e.name)")
        assert all(name.startswith("data:") for name in fetched)

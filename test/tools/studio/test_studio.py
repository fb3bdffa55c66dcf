"""`artrec studio` in a real browser: from a folder of pictures alone to scored poses, each action counted."""

from __future__ import annotations

import asyncio
import json
import re
import socket
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import pytest
from studio_person import BROWSER, Person, studio
from studio_pictures import SIZE, Pictures

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.learned.annotations import load_coco
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.io.results.results import read_results
from artrec_ros.tools.main import main

try:
    from playwright.sync_api import sync_playwright
except ImportError:
    sync_playwright = None
try:
    import nicegui
except ImportError:
    nicegui = None

needs_page = pytest.mark.skipif(nicegui is None, reason="NiceGUI is not installed (extra studio)")
in_browser = pytest.mark.skipif(
    nicegui is None or sync_playwright is None or BROWSER is None,
    reason="no chromium, or no Playwright or NiceGUI in this environment",
)
ASKED: set[str] = set()  # hosts of what the page loaded
TAUGHT, DRAWN = (0, 1), (4, 5)  # frames whose colours are clicked on; frames whose objects are drawn by hand


@pytest.fixture(scope="module")
def person(pictures: Pictures) -> Iterator[Person]:
    """Somebody before the page, who has yet done nothing."""
    assert sync_playwright is not None and BROWSER is not None
    arguments = [str(pictures.source), "--params-file", str(pictures.parameters), "-o", "made"]
    with sync_playwright() as playwright, studio(arguments, pictures.folder) as port:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1500, "height": 1100})
        page.on("request", lambda request: ASKED.add(request.url.split("/")[2] if "//" in request.url else ""))
        me = Person(page, SIZE[0])
        me.open(port)
        yield me
        browser.close()


@in_browser
def test_from_pictures_alone_to_scored_poses(pictures: Pictures, person: Person) -> None:
    made = pictures.folder / "made"
    teach_colours(pictures, person)
    setup = load_parameters(made / "params.yaml")
    assert all(c.rgb for c in setup.image.classes.values())
    draw_examples(pictures, person)
    person.tab("examples")
    person.key("Home")
    person.frame("02.png")
    person.key("p")
    person.settle()
    person.sees("count", "3 proposed")
    person.key("a", 3)
    person.sees("count", "3 marked, 0 of them by hand")
    person.sees("learned", "robot is found as a whole here, from its file's geometry: constraints change nothing")
    person.press_button("rank")
    person.sees("queue", "03.png")
    assert "02.png" not in person.text("queue"), "what is marked waits no more"
    person.press_button("train")
    person.sees("trained", "robot: 1 pairs, the first constraints")
    score(person)
    assert person.complaint() == ""
    assert person.did.total() < 120, person.did
    marked = load_coco([made / "annotations.json"]).objects
    assert len(marked) == 9 and sum(o.by_machine for o in marked) == 3
    replay_agrees(pictures, made)


def teach_colours(pictures: Pictures, person: Person) -> None:
    for number in TAUGHT:
        person.frame(f"{number:02d}.png")
        for key, name in (("1", "team"), ("2", "accent")):
            person.key(key)
            for place in pictures.middles(number, name):
                person.click("colours-picture", place)
        person.key("3")
        person.drag("colours-picture", (2, 2), (50, 40))
        person.drag("colours-picture", (260, 190), (310, 230))
    person.press_button("save-colours")
    assert person.complaint() == ""


def draw_examples(pictures: Pictures, person: Person) -> None:
    person.tab("examples")
    for number in DRAWN:
        person.frame(f"{number:02d}.png")
        for robot in pictures.axes(number):
            person.drag("examples-picture", *robot["team"])
        person.sees("count", "3 marked, 3 of them by hand")


def score(person: Person) -> None:
    person.tab("parameters")
    person.press_button("score")
    told = person.text("scores")
    counted = re.search(r"2 frames, 6 objects in view, (\d) found, (\d) false", told)
    assert counted and int(counted[1]) >= 5 and int(counted[2]) == 0, told


def replay_agrees(pictures: Pictures, made: Path) -> None:
    """What was made is what the commands read, and gives them the same."""
    result = pictures.folder / "result"
    arguments = [str(pictures.source), "--params-file", str(made / "params.yaml"), "--no-video", "--images", "none"]
    assert main(["replay", *arguments, "-o", str(result)]) == 0
    found = [len(record.detections) for record in read_results(result / "detections.jsonl")]
    assert sum(found) >= 16
    assert main(["evaluate", str(result), "--truth", str(made / "annotations.json"), "--no-page"]) == 0


@in_browser
def test_a_parameter_is_tried_beside_the_old_one_and_kept(pictures: Pictures, person: Person) -> None:
    person.tab("parameters")
    before = person.text("caption-before")
    person.type("field-recognizer.min_probability", "1")
    person.sees("changed", "min_probability: 1")
    assert person.text("caption-before").split(" found")[0] == before.split(" found")[0]
    person.sees("reasons-after", "below 1:")
    assert "below 1:" not in person.text("reasons-before")
    slider = person.page.locator("[data-name='slider-recognizer.min_probability']").first
    assert slider.get_attribute("aria-valuenow") == "1", "the slider follows what is typed"
    person.type("field-recognizer.min_probability", "7")
    assert "min_probability" in person.complaint() and "min_probability: 1" in person.text("changed")
    person.press_button("save-parameters")
    kept = load_parameters(pictures.folder / "made/params.yaml")
    assert kept.recognizer.min_probability == 1


@in_browser
def test_pages_at_true_scale_are_written(pictures: Pictures, person: Person) -> None:
    person.tab("object")
    person.press_button("print")
    assert (pictures.folder / "made/robot_A4.pdf").read_bytes().startswith(b"%PDF")


@in_browser
def test_each_mark_is_learned_from_while_the_page_goes_on(pictures: Pictures, person: Person) -> None:
    before = person.complaint()
    person.tab("parameters")
    person.press_button("field-recognizer.whole_object")
    person.sees("changed", "whole_object: False")
    person.press_button("save-parameters")
    person.tab("examples")
    person.frame("03.png")
    person.press_button("rank")
    person.drag("examples-picture", *pictures.axes(3)[0]["team"])
    person.key("Home")
    assert "00.png" in person.text("frame"), "learning is no reason to wait"
    person.sees("learned", "proposals in the 2 frames that wait first, ")
    assert "(9 -> 10 examples); " in person.text("learned"), "from the constraints that were trained by button"
    assert "03.png" not in person.text("queue")
    person.press_button("learn-constraints")
    told = person.text("learned")
    person.frame("03.png")
    person.drag("examples-picture", *pictures.axes(3)[1]["team"])
    person.sees("count", "2 marked")
    person.page.wait_for_timeout(2500)
    assert person.text("learned") == told, "switched off"
    assert person.complaint() == before


@in_browser
def test_a_drag_ends_at_the_border_and_keys_of_the_browser_are_its_own(pictures: Pictures, person: Person) -> None:
    made = pictures.folder / "made"
    person.tab("examples")
    person.key("Home")
    marked = (made / "annotations.json").read_bytes()
    person.key("Control+x")
    person.page.wait_for_timeout(300)
    assert (made / "annotations.json").read_bytes() == marked
    person.tab("colours")
    before = len(json.loads((made / "regions.json").read_text())["annotations"])
    person.key("3")
    person.drag("colours-picture", (280, 200), (335, 230))  # of 320 x 240
    person.until(lambda: len(json.loads((made / "regions.json").read_text())["annotations"]) == before + 1)
    buttons, field = person.page.locator("[data-name=class] button"), person.page.get_by_placeholder("other background")
    for number, name in ((4, "wall"), (5, "table")):
        field.fill(name)
        field.press("Enter")
        person.until(lambda shown=f"{number} {name}": shown in {t.strip() for t in buttons.all_inner_texts()})
        person.until(lambda: field.input_value() == "")
    assert "4 wall" in {text.strip() for text in buttons.all_inner_texts()}


@in_browser
def test_nothing_is_loaded_from_elsewhere(person: Person) -> None:
    assert {host.partition(":")[0] for host in ASKED} <= {"127.0.0.1", ""} and len(ASKED) >= 1


@needs_page
def test_a_port_in_use_is_told_in_one_line(pictures: Pictures, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = str(other.getsockname()[1])
        arguments = [str(pictures.source), "--params-file", str(pictures.parameters), "--port", port, "--no-open"]
        assert main(["studio", *arguments, "-o", str(pictures.folder / "other")]) == 1
    assert f"--port {port}: cannot be used on 127.0.0.1" in capsys.readouterr().err


def test_without_nicegui_it_says_what_to_install(
    pictures: Pictures, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [n for n in sys.modules if n.startswith("artrec_ros.tools.studio_pages")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "nicegui", None)
    assert main(["studio", str(pictures.source), "--params-file", str(pictures.parameters)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "nicegui" in line and "pip install artrec_ros[studio]" in line


@pytest.mark.parametrize(("option", "value"), [("--port", "0"), ("--port", "http"), ("--frames", "0"), ("--keep", "0")])
def test_options_that_make_no_sense_are_wrong_usage(
    option: str, value: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["studio", "pictures", "--params-file", "robots.yaml", option, value]) == 2
    assert option in capsys.readouterr().err


@needs_page
def test_warnings_and_the_compiler_have_a_line_on_each_page() -> None:
    from nicegui import Client, core
    from nicegui.page import page

    from artrec_ros.tools.studio_pages.board import Board
    from artrec_ros.tools.studio_pages.kit import Busy

    session = SimpleNamespace(compiled=0.42, warnings=["/there: full", "camera_info is another camera's"])

    async def look() -> list[str]:
        core.loop = asyncio.get_running_loop()
        with Client(page("/"), request=None) as window:
            busy = Busy(lambda: session.compiled)
            Board(session, busy).warnings()  # type: ignore[arg-type]
            busy._tell()
            return [e.text for e in window.elements.values() if hasattr(e, "text")]

    with ThreadPoolExecutor(1) as aside:  # this thread's loop is the browser's
        told = aside.submit(asyncio.run, look()).result()
    assert any(re.match(r"getting ready, 42%: compiling, ", line) for line in told), told
    assert "warning: /there: full; warning: camera_info is another camera's" in told


@needs_page
@pytest.mark.parametrize("job", ["ends", "fails"])
def test_work_whose_window_is_closed_meanwhile_ends_quietly(job: str) -> None:
    """What it would say has no page to be said on: NiceGUI raised, and the terminal showed where."""
    from nicegui import Client, core
    from nicegui.page import page

    from artrec_ros.tools.studio_pages.kit import Busy

    closed, done = threading.Event(), list[str]()

    def work() -> None:
        assert closed.wait(60)
        done.append(job)
        if job == "fails":
            raise ConfigError("it cannot be written")

    async def press() -> None:
        core.loop = asyncio.get_running_loop()
        window = Client(page("/"), request=None)
        with window:
            pressed = asyncio.create_task(Busy(lambda: None).work("learning", work))
            await asyncio.sleep(0.1)
            window.delete()
            closed.set()
            with pytest.raises(asyncio.CancelledError):
                await pressed

    with ThreadPoolExecutor(1) as aside:  # this thread's loop is the browser's
        aside.submit(asyncio.run, press()).result()
    assert done == [job]

"""`artrec studio` on a live topic and beside a node that runs, in a real browser."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")
import toy
from peer import STARTED, NodeProcess, Peer, ros
from rcl_interfaces.srv import GetParameters
from sensor_msgs.msg import Image
from studio_person import BROWSER, Person, studio

from artrec_ros.io.images.cameras import load_camera
from artrec_ros.io.images.decoding import read_image
from artrec_ros.io.parameters.parameter_file import Setup, load_parameters

sync_api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
pytest.importorskip("nicegui", reason="NiceGUI is not installed (extra studio)")
pytestmark = pytest.mark.skipif(BROWSER is None, reason="no chromium here")

TOPIC = "/camera/image_raw"
PERIOD_S = 0.1


@contextmanager
def filming(setup: Setup) -> Iterator[None]:
    """A toy that moves to and fro before a calibrated camera, ten times a second."""
    over = threading.Event()
    with Peer("image_raw", namespace="camera") as peer:

        def film() -> None:
            number = 0
            while not over.wait(PERIOD_S):
                number += 1
                peer._infos.publish(toy.camera_info())
                picture = toy.draw(setup.targets[0].model, 0.05 * np.sin(number / 10), 0.02, 0.6)
                height, width = picture.shape
                peer.send(Image(height=height, width=width, encoding="mono8", step=width, data=picture.tobytes()))

        thread = threading.Thread(target=film)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("live")


@pytest.fixture(scope="module")
def person(ros_environment: None, compiled: None, parameter_file: Path, setup: Setup, folder: Path) -> Iterator[Person]:
    arguments = ["--topic", TOPIC, "--params-file", str(parameter_file), "-o", "made", "--keep", "20"]
    with filming(setup), sync_api.sync_playwright() as playwright, studio(arguments, folder) as port:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        me = Person(browser.new_page(viewport={"width": 1500, "height": 1000}), toy.SIZE[0])
        me.open(port, "live")
        yield me
        browser.close()


def picture_of(person: Person) -> str:
    return str(person.page.locator("[data-name=live-picture] img").first.get_attribute("src"))


def test_images_come_are_held_and_taken(person: Person, folder: Path) -> None:
    person.sees("live-state", "calibrated")
    assert re.match(rf"{TOPIC}: \d+ Hz, calibrated", person.text("live-state"))
    first = picture_of(person)
    person.until(lambda: picture_of(person) != first)
    person.key("f")
    person.page.wait_for_timeout(1000)
    held = picture_of(person)
    person.page.wait_for_timeout(1000)
    assert picture_of(person) == held, "frozen"
    bar = person.page.locator("[data-name=back]").first.bounding_box()
    person.page.mouse.click(bar["x"] + 0.4 * bar["width"], bar["y"] + bar["height"] / 2)
    person.until(lambda: picture_of(person) != held)
    earlier = picture_of(person)
    assert person.text("frame").startswith("1/1 "), "one was taken to begin with"
    person.press_button("take")
    person.sees("frame", "2/2 ")
    person.press_button("take")
    person.page.wait_for_timeout(500)
    assert person.text("frame").startswith("2/2 ") and picture_of(person) == earlier, "it is taken already"
    person.press_button("freeze")
    person.until(lambda: picture_of(person) != earlier)
    person.key("t")
    person.sees("frame", "3/3 ")
    files = sorted((folder / "made/frames").glob("*.png"))
    assert len(files) == 3 and all(re.fullmatch(r"17000\d{14}", f.stem) for f in files)
    assert read_image(files[1]).shape == toy.SIZE[::-1] and set(np.unique(read_image(files[1]))) == {0, toy.LABEL}
    assert load_camera(folder / "made/frames/camera.yaml").sees_as(toy.CAMERA)


def test_what_was_taken_is_marked_as_any_frame(person: Person) -> None:
    person.tab("examples")
    person.key("End")
    person.key("p")
    person.settle()
    person.sees("count", "1 proposed")
    person.key("a")
    person.sees("count", "1 marked, 0 of them by hand")
    person.tab("live")
    person.key("t")
    person.sees("frame", "4/4 ")
    person.tab("examples")
    person.key("Home")
    person.sees("frame", "1/4 ")
    assert person.complaint() == ""


@contextmanager
def running(parameter_file: Path, folder: Path) -> Iterator[None]:
    """A node under another name, that has published its transforms since the start."""
    arguments = ros(parameter_file, "-r", "__node:=finder", "-p", "publish_tf:=true")
    with NodeProcess(*arguments, log=folder / "node.log") as node:
        node.wait_for_output(STARTED)
        yield


def value_of(name: str) -> Any:
    with Peer("asker") as peer:
        client = peer.node.create_client(GetParameters, "/finder/get_parameters")
        assert peer.spin_until(client.service_is_ready)
        answer = client.call_async(GetParameters.Request(names=[name]))
        assert peer.spin_until(answer.done)
        return answer.result().values[0].double_value


def test_parameters_are_set_on_a_node_that_runs(person: Person, parameter_file: Path, folder: Path) -> None:
    person.tab("parameters")
    person.press_button("find-nodes")
    person.sees("node-told", "no recogniser node answers")
    with running(parameter_file, folder):
        for _ in range(20):
            person.press_button("find-nodes")
            if "differ" in person.text("node-told"):
                break
        person.sees("node-differences", "publish_tf")
        assert re.search(r"publish_tf\s+False\s+True\s+needs a restart", person.text("node-differences"))
        person.type("field-recognizer.min_probability", "0.62")
        person.sees("changed", "0.62")
        person.press_button("find-nodes")
        person.sees("node-differences", "recognizer.min_probability")
        saved = load_parameters(parameter_file).recognizer.min_probability
        assert re.search(rf"min_probability\s+0.62\s+{saved}\s+can be set", person.text("node-differences"))
        person.press_button("set-on-node")
        person.sees("node-told", "1 of 1 set")
        assert "min_probability" not in person.text("node-differences")
        assert value_of("recognizer.min_probability") == 0.62
        person.press_button("experts")
        person.type("find", "coarse_keep")
        person.type("field-expert.alignment.coarse_keep", "7")
        person.press_button("set-on-node")
        person.sees("node-told", "0 of 1 set; 1 refused")
        told = person.text("node-differences")
        assert "refused: expert.alignment.coarse_keep: can be changed only where it was given at the start" in told
    person.press_button("set-on-node")
    assert "node /finder does not answer" in person.complaint()

"""Makes docs/images/studio_*.jpg: somebody teaches robots from above to `artrec studio`, and is photographed.

    python docs/images/studio.py [FOLDER]

Pictures are those of benchmarks/overhead.py, files those of docs/overhead.md. Needs the extra studio, Playwright and
chromium. What was clicked is counted at the end.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "test" / "tools" / "studio"), str(ROOT / "benchmarks")]
from annotate_mirosot import TEAMS  # noqa: E402  (lies beside the measurements)
from overhead import Robot, Room, write_pictures  # noqa: E402  (lies beside the measurements)
from studio_live import OWN, TOPIC, filming, running  # noqa: E402  (lies beside this file)
from studio_person import BROWSER, Person, studio  # noqa: E402  (lies beside the tests)

IMAGES = Path(__file__).resolve().parent
WINDOW, WIDTH, QUALITY = (1500, 1060), 1100, 86
IMAGE_SIZE, BOX = (640, 480), (100, 70)  # pixels; of background that is marked
STRICT = 0.99  # min_probability that turns some down: something to see
SIZE_PX, BLUR_PX, SEED = 26.0, 1.2, 8  # of the robots' squares, of the lens
IDENTITIES = ["gr", "gv", "rg", "rv", "vg", "vr"]  # by their keys, 1 to 6
LETTERS = {"g": "green", "r": "red", "v": "violet"}


def save_files(folder: Path) -> None:
    """robot.yaml and robots.yaml, as docs/overhead.md begins with them."""
    page = (ROOT / "docs/overhead.md").read_text(encoding="utf-8")
    for name, text in re.findall(r"<!-- file: ([^,]+?) -->\n```yaml\n(.*?)```", page, re.DOTALL):
        (folder / name).write_text(text, encoding="utf-8")


def photograph(page: Page, name: str, height: int = WINDOW[1]) -> None:
    """:param height: how much of the window is shown, from its top, pixels."""
    page.mouse.move(5, WINDOW[1] - 5)  # no tooltip
    page.wait_for_timeout(1500)
    page.wait_for_function("!document.querySelector('.q-notification')", timeout=60_000)
    clip = {"x": 0, "y": 0, "width": WINDOW[0], "height": height}
    picture = cv2.imdecode(np.frombuffer(page.screenshot(clip=clip), np.uint8), cv2.IMREAD_COLOR)
    small = cv2.resize(picture, (WIDTH, round(height * WIDTH / WINDOW[0])), interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(IMAGES / f"studio_{name}.jpg"), small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


class Robots:
    """Where to click: what a person sees in the pictures."""

    def __init__(self, room: Room, scenes: list[list[Robot]]) -> None:
        self._half_px, self._scenes = room.half_px, scenes

    def axis(self, robot: Robot) -> tuple[np.ndarray, np.ndarray]:
        """Tail and head of the team's triangle."""
        angle, middle = np.radians(robot.deg), np.array([robot.x, robot.y])
        return middle, middle + self._half_px * np.array([np.cos(angle), np.sin(angle)])

    def patches(self, number: int) -> dict[str, list[np.ndarray]]:
        """Class -> a pixel in each of its patches of a frame."""
        found: dict[str, list[np.ndarray]] = {}
        for robot in self._scenes[number]:
            tail, head = self.axis(robot)
            ahead, left = (head - tail) / 3, np.array([head[1] - tail[1], tail[0] - head[0]]) / 3
            found.setdefault(TEAMS[robot.team], []).append(tail + ahead)
            found.setdefault(LETTERS[robot.pair[0]], []).append(tail - ahead + left)
            found.setdefault(LETTERS[robot.pair[1]], []).append(tail - ahead - left)
        return found

    def bare_corners(self, number: int, count: int) -> list[np.ndarray]:
        """Upper left corners of boxes without robots."""
        middles = np.array([(r.x, r.y) for r in self._scenes[number]])
        found = []
        for x in range(5, IMAGE_SIZE[0] - BOX[0], BOX[0] + 10):
            for y in range(5, IMAGE_SIZE[1] - BOX[1], BOX[1] + 10):
                gaps = np.abs(middles - (x + BOX[0] / 2, y + BOX[1] / 2)) - np.array(BOX) / 2
                if (gaps.max(axis=1) > self._half_px + 3).all():
                    found.append(np.array([x, y], float))
        return found[:: max(1, len(found) // count)][:count]

    def of(self, number: int, team: str) -> list[Robot]:
        return [r for r in self._scenes[number] if TEAMS[r.team] == team]


def colours(me: Person, robots: Robots) -> None:
    for number in (0, 2):
        me.frame(f"{number:04d}.png")
        for name, found in robots.patches(number).items():
            me.option("class", name)
            for place in found[:3]:
                me.click("colours-picture", place)
        me.option("class", "background")
        for corner in robots.bare_corners(number, 4):
            me.drag("colours-picture", corner, corner + BOX)
    me.press_button("save-colours")
    photograph(me.page, "colours")


def examples(me: Person, robots: Robots) -> None:
    me.tab("examples")
    me.key("Home")
    me.frame("0003.png")
    for team in TEAMS.values():
        for robot in robots.of(3, team):
            me.drag("examples-picture", *robots.axis(robot))
            me.key(str(IDENTITIES.index(robot.pair) + 1))
        me.key("o")
    me.press_button("rank")
    me.press_button("learn-colours")
    me.frame("0004.png")
    me.key("p")
    me.settle()
    me.key("a", 4)
    me.sees("learned", "proposals in the")
    photograph(me.page, "examples", 860)
    me.key("A")
    me.page.wait_for_timeout(2000)
    me.until(lambda: not me.text("learning"))


def parameters(me: Person) -> None:
    me.tab("parameters")
    me.key("Home")
    me.frame("0000.png")
    me.type("field-recognizer.min_probability", str(STRICT))
    me.press_button("score")
    photograph(me.page, "parameters")
    me.press_button("reset")


def failures(me: Person, folder: Path) -> None:
    (folder / "strict.yaml").write_text(f"/**: {{ros__parameters: {{recognizer: {{min_probability: {STRICT}}}}}}}\n")
    files = ["--params-file", "studio/params.yaml", "--params-file", "strict.yaml", "--no-video", "-o", "result"]
    for words in (["replay", "pictures", *files], ["evaluate", "result", "--truth", "coco.json", "--no-page"]):
        subprocess.run([sys.executable, "-m", "artrec_ros.tools.main", *words], cwd=folder, check=True)
    me.tab("failures")
    me.type("results", "result")
    me.press_button("show-failures")
    photograph(me.page, "failures", 640)


def live(browser: Browser, folder: Path) -> None:
    """On a live topic, beside a node with the parameters that were made."""
    arguments = ["--topic", TOPIC, "--params-file", "studio/params.yaml", "-o", "live"]
    with filming(folder / "pictures"), running(folder / "studio/params.yaml"), studio(arguments, folder) as port:
        me = Person(browser.new_page(viewport={"width": WINDOW[0], "height": WINDOW[1]}), IMAGE_SIZE[0])
        me.open(port, "live")
        me.page.wait_for_timeout(3000)
        me.key("f")
        me.press_button("take")
        photograph(me.page, "live", 860)
        me.tab("parameters")
        me.type("field-recognizer.min_probability", "0.8")
        for _ in range(20):
            me.press_button("find-nodes")
            if "differ" in me.text("node-told"):
                break
        me.page.locator("[data-name=node-differences]").scroll_into_view_if_needed()
        photograph(me.page, "node")
        print(dict(me.did), me.complaint())


def main() -> None:
    os.environ.update(OWN)
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())
    rng = np.random.default_rng(SEED)
    room = Room.random(SIZE_PX, BLUR_PX, rng)
    robots = Robots(room, write_pictures(folder, room, rng, 8))
    save_files(folder)
    with studio(["pictures", "--params-file", "robots.yaml"], folder) as port, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": WINDOW[0], "height": WINDOW[1]})
        me = Person(page, IMAGE_SIZE[0])
        me.open(port)
        colours(me, robots)
        examples(me, robots)
        parameters(me)
        me.tab("object")
        me.frame("0003.png")
        me.settle()
        photograph(page, "object")
        failures(me, folder)
        print(dict(me.did), me.complaint())
        live(browser, folder)
        browser.close()


if __name__ == "__main__":
    main()

"""Makes docs/images/demo.jpg and report.jpg from what scripts/demo leaves. Needs chromium and chromium-driver.

scripts/demo [FOLDER] && .venv/bin/python docs/images/demo.py [FOLDER]
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from artrec_ros.tools.replaying.names import overlay_name

IMAGES = Path(__file__).resolve().parent
ROOT = IMAGES.parents[1]
sys.path.insert(0, str(ROOT / "test" / "tools" / "evaluation"))
from browser import Browser  # noqa: E402  (lies beside the tests)

FRAMES = (1, 10, 29, 36)  # of the demo's bag, in rows of two
PICTURE, QUALITY = (560, 420), 88
PAGE, WIDTH = (1240, 1500), 900  # the browser's window, in pixels; the picture is shrunk to this width
GROUP = "By range"  # of the report, alone open, is where the picture begins
SHOW = """
for (const group of document.querySelectorAll('details.group')) {
    group.open = group.innerText.startsWith(arguments[0]);
    if (group.open) group.scrollIntoView();
}
"""


def artrec(*words: object) -> None:
    subprocess.run([sys.executable, "-m", "artrec_ros.tools.main", *map(str, words)], check=True)


def demo_picture(replay: Path) -> NDArray:
    """Four of the overlays."""
    pictures = []
    for number in FRAMES:
        (path,) = (replay / "frames").glob(f"{overlay_name(number, 'topic', 0)[:6]}_*.png")
        pictures.append(cv2.resize(cv2.imread(str(path)), PICTURE, interpolation=cv2.INTER_AREA))
    return np.vstack([np.hstack(pictures[:2]), np.hstack(pictures[2:])])


def comparison(demo: Path) -> Path:
    """The report of two replays: the demo's excavator, and the same without places in space."""
    for name, parameters in (("in_plane", without_space(demo)), ("in_space", demo / "config" / "excavator.yaml")):
        bag, output = demo / "test" / "bag", ["-o", demo / name, "--overwrite", "--no-video"]
        artrec("replay", bag, "--params-file", parameters, *output)
    runs = demo / "in_plane", demo / "in_space"
    artrec("evaluate", *runs, "--truth", demo / "test" / "truth.jsonl", "-o", demo / "comparison")
    return demo / "comparison" / "comparison.html"


def without_space(demo: Path) -> Path:
    """The demo's parameters with an object file that tells shapes alone: it is then found in the image plane."""
    model = yaml.safe_load((demo / "config" / "objects" / "excavator.yaml").read_text(encoding="utf-8"))
    for component in model["components"].values():
        component.pop("joint", None), component.pop("body", None)
        for use in component["markers"].values():
            use.pop("pose", None)
    (demo / "config" / "objects" / "flat.yaml").write_text(yaml.safe_dump(model, sort_keys=False), encoding="utf-8")
    text = (demo / "config" / "excavator.yaml").read_text(encoding="utf-8")
    flat = demo / "config" / "flat.yaml"
    flat.write_text(text.replace("objects/excavator.yaml", "objects/flat.yaml"), encoding="utf-8")
    return flat


def page_picture(page: Path) -> NDArray:
    """The page from the group's heading on, as a browser shows it."""
    with tempfile.TemporaryDirectory() as profile, Browser(Path(profile), PAGE) as browser:
        browser.prefer("light")
        browser.open(page)
        browser.run(SHOW, GROUP)
        picture = cv2.imdecode(np.frombuffer(browser.screenshot(), np.uint8), cv2.IMREAD_COLOR)
    return cv2.resize(picture, None, fx=WIDTH / PAGE[0], fy=WIDTH / PAGE[0], interpolation=cv2.INTER_AREA)


def main() -> None:
    demo = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "demo_output")
    made = {"demo.jpg": demo_picture(demo / "replay"), "report.jpg": page_picture(comparison(demo))}
    for name, picture in made.items():
        cv2.imwrite(str(IMAGES / name), picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


if __name__ == "__main__":
    main()

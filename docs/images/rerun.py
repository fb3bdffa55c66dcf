"""Makes docs/images/rerun.jpg: the film's frames in the Rerun viewer. Needs the extra rerun, chromium, chromium-driver.

python docs/images/film.py FOLDER && python docs/images/rerun.py FOLDER
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np
import rerun_cli
from film import PARAMETERS, TOPIC, artrec

IMAGES = Path(__file__).resolve().parent
sys.path.insert(0, str(IMAGES.parents[1] / "test" / "tools" / "evaluation"))
from browser import SOFTWARE_GL, Browser  # noqa: E402  (lies beside the tests)

WINDOW, WIDTH, QUALITY = (1400, 860), 1000, 85
SECONDS, LOADING_S = 1.0, 45
PAGES, MESSAGES = 9591, 9577  # ports


def main() -> None:
    folder = Path(sys.argv[1])
    recording = folder / "film.rrd"
    few = ["--playback-duration", SECONDS, "--images", "none", "--no-video", "--overwrite"]
    bag, output = folder / "scenes" / "bag", folder / "recorded"
    artrec("replay", bag, "--params-file", PARAMETERS, *TOPIC, *few, "-o", output, "--rerun", recording)
    program = Path(rerun_cli.__file__).parent / "rerun"  # itself, that it can be ended
    ports = ["--web-viewer", "--web-viewer-port", str(PAGES), "--port", str(MESSAGES), "--bind", "127.0.0.1"]
    viewer = subprocess.Popen([program, str(recording), *ports])
    try:
        time.sleep(5)
        with tempfile.TemporaryDirectory() as profile, Browser(Path(profile), WINDOW, SOFTWARE_GL) as browser:
            source = f"rerun%2Bhttp://127.0.0.1:{MESSAGES}/proxy"
            browser.run(f"window.location = 'http://127.0.0.1:{PAGES}/?url={source}&renderer=webgl'")
            time.sleep(LOADING_S)
            picture = cv2.imdecode(np.frombuffer(browser.screenshot(), np.uint8), cv2.IMREAD_COLOR)
    finally:
        viewer.terminate()
    small = cv2.resize(picture, None, fx=WIDTH / WINDOW[0], fy=WIDTH / WINDOW[0], interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(IMAGES / "rerun.jpg"), small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


if __name__ == "__main__":
    main()

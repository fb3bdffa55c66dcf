"""Makes docs/images/film.webp: robots of both teams walk about, as `artrec replay` finds them, frame by frame.

python docs/images/film.py [FOLDER]      # FOLDER keeps what is in between; some minutes

The frames are those of `artrec simulate --motion`, with blur and sensor noise, in steady light: by default it is drawn
anew for each frame, which flickers. Colours are found as config/aibo_colour.yaml says. Every second frame is shown.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

IMAGES = Path(__file__).resolve().parent
PARAMETERS = IMAGES.parents[1] / "config" / "aibo_colour.yaml"
FRAMES, EVERY, HZ = 180, 2, 15
SEED, ROBOTS = 1, 3
SIZE, ROWS, QUALITY = (640, 480), (60, 440), 60  # of the picture those rows are shown, where the robots are
MOST_BYTES = 3_000_000
TOPIC = ("--topic", "/camera/image_color/compressed")


def artrec(*words: object) -> None:
    subprocess.run([sys.executable, "-m", "artrec_ros.tools.main", *map(str, words)], check=True)


def make(folder: Path) -> list[Path]:
    """The overlays, in order."""
    scenes, found = folder / "scenes", folder / "found"
    if not scenes.exists():
        motion = ["--motion", "--speed", 0.2, "--reach", 0.2, "--turn", 0.9, "--swing-hz", 0.9]
        scene = ["--objects", ROBOTS, ROBOTS, "--size", 0.28, 0.42, "--elevation-deg", 14, 20, "--light", 0]
        camera = ["--image-size", *SIZE, "--seed", SEED, "--frames", FRAMES]
        artrec("simulate", "--params-file", PARAMETERS, "--colour", *motion, *scene, *camera, "-o", scenes)
    artrec("replay", scenes / "bag", "--params-file", PARAMETERS, *TOPIC, "--no-video", "-o", found)
    return sorted((found / "frames").glob("*.png"))


def main() -> None:
    with tempfile.TemporaryDirectory() as aside:
        pictures = make(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(aside))[::EVERY]
        box = (0, ROWS[0], SIZE[0], ROWS[1])
        shown = [Image.open(path).convert("RGB").crop(box) for path in pictures]
    film = IMAGES / "film.webp"
    options = {"save_all": True, "duration": 1000 // HZ, "loop": 0, "quality": QUALITY, "method": 6}
    shown[0].save(film, append_images=shown[1:], **options)
    print(f"{film}: {len(shown)} frames, {film.stat().st_size / 1e6:.1f} MB")
    if film.stat().st_size > MOST_BYTES:
        sys.exit(f"{film}: more than {MOST_BYTES / 1e6:g} MB; lower QUALITY or SIZE")


if __name__ == "__main__":
    main()

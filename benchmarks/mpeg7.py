"""Rotation and scale of single rigid markers: silhouettes of the MPEG-7 shape set, turned and scaled.

    python benchmarks/mpeg7.py MPEG7_DIR

Each NAME-1.png is made a marker (1 m = 100 px of it) and looked for in every other image of its name. Rotation is
taken modulo the shape's own symmetry, as found from its outline. What is not recognised has infinite errors.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from artrec_ros.core.alignment.shapes import Shape
from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.objects.outlines import silhouette_outline

ROTATIONS_DEG = {2: 9.0, 3: 36.0, 4: 45.0, 5: 90.0, 6: 150.0}  # counter-clockwise as one looks at it
SCALES = {2: 2.0, 3: 0.3, 4: 0.25, 5: 0.2, 6: 0.1}
ROTATION_BAR_DEG, SCALE_BAR = 0.5, 0.01
SYMMETRY_SHARE = 0.01  # of the shape's radius: a turn that moves the outline by less is a symmetry
LABEL, PX_PER_M = 1, 100.0


@dataclass(frozen=True)
class Row:
    """One image's truth and errors. :param scale_error: relative, signed."""

    name: str
    rotation_deg: float
    scale: float
    rotation_error_deg: float
    scale_error: float

    @property
    def right(self) -> bool:
        return abs(self.rotation_error_deg) <= ROTATION_BAR_DEG and abs(self.scale_error) <= SCALE_BAR


def labels_of(path: Path) -> np.ndarray:
    grey = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    assert grey is not None, path
    return np.where(grey > 127, LABEL, 0).astype(np.uint8)


def marker_of(path: Path) -> Marker:
    """The silhouette, measured by its area: its blurred outline is a little narrower at pointed ends."""
    outline = silhouette_outline(path, 1.0)
    x, y = outline.T
    area = abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2
    contours = cv2.findContours(labels_of(path), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    chain = max(contours, key=cv2.contourArea)
    area_px = cv2.contourArea(chain) + len(chain) / 2 + 1  # Pick's theorem: pixels enclosed
    outline = outline * math.sqrt(area_px / area) / PX_PER_M
    return Marker("silhouette", outline, np.array([-0.5, 0.0]), np.array([0.5, 0.0]))


def measure(recognizer: Recognizer, order: int, path: Path, rotation_deg: float, scale: float) -> Row:
    """:param order: of the shape's symmetry; 0: any angle."""
    found = recognizer.recognize(labels_of(path)).detections
    if not found:
        return Row(path.stem, rotation_deg, scale, math.inf, math.inf)
    image = max(found, key=lambda d: d.score).image
    period = 360.0 / order if order else 1e-9
    # theta runs clockwise as one looks at it: y is down
    rotation_error = math.remainder(math.degrees(image.theta) + rotation_deg, period)
    return Row(path.stem, rotation_deg, scale, rotation_error, image.scale / (PX_PER_M * scale) - 1)


def measure_all(folder: Path) -> list[Row]:
    """Rows of every image but NAME-1 itself."""
    rows: list[Row] = []
    for path in sorted((folder / "scale").glob("*-1.png")):
        marker = marker_of(path)
        shape = Shape.from_marker(marker)
        order = shape.symmetry.order(1.0, SYMMETRY_SHARE * shape.rms_radius_m)
        model = ObjectModel("shape", (Component("shape", (marker,), required=True),))
        recognizer = Recognizer([Target("shape", model, LABEL)], RecognizerConfig(), Segmenter(ImageConfig()))
        name = path.stem.removesuffix("-1")
        for n, angle in ROTATIONS_DEG.items():
            rows.append(measure(recognizer, order, folder / "rotation" / f"{name}-{n}.png", angle, 1.0))
        for n, scale in SCALES.items():
            rows.append(measure(recognizer, order, folder / "scale" / f"{name}-{n}.png", 0.0, scale))
    return rows


def report(title: str, rows: list[Row]) -> None:
    right = sum(r.right for r in rows)
    turn, scale = (
        np.median([abs(e) for e in errors])
        for errors in ([r.rotation_error_deg for r in rows], [r.scale_error for r in rows])
    )
    print(
        f"{title}: {right} of {len(rows)} right ({100 * right / len(rows):.1f} %), "
        f"median error {turn:.3f} deg and {100 * scale:.2f} %"
    )
    for r in rows:
        if not r.right:
            turned = f"{r.name} turned {r.rotation_deg:g} deg"
            print(f"  {turned}: off by {r.rotation_error_deg:.2f} deg, {100 * r.scale_error:.2f} %")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    rows = measure_all(parser.parse_args().folder)
    report("scale 0.25 and above", [r for r in rows if r.scale >= 0.25])
    for scale in sorted({r.scale for r in rows}, reverse=True):
        report(f"scale {scale:g}", [r for r in rows if r.scale == scale])


if __name__ == "__main__":
    main()

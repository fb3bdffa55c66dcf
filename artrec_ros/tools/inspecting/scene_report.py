"""What is known of the scene, for `artrec inspect`: in figures, and drawn over an image."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np

from ...core.base.errors import ImageError
from ...core.canvas import Canvas, Colour, Picture
from ...core.drawing import class_picture, enlargement
from ...core.geometry.camera import Camera
from ...core.geometry.field_plane import FieldPlane
from ...core.geometry.scene import Scene
from ...core.geometry.transforms import Array
from ...core.image.blobs import centres, find_blobs
from ...core.image.segmentation import Segmenter
from ...io.images.decoding import Image
from ...io.images.writing import save_drawing
from ...io.inventory.contents import BagContent, Item, Sample
from ...io.parameters.parameter_file import Setup

_REGION: Colour = (60, 220, 255)
_GRID: Colour = (235, 235, 235)
_AXES: tuple[Colour, ...] = ((70, 70, 255), (70, 230, 70))  # x red, y green
_LINES = 12  # of the grid, about so many in each direction
_STEPS = 60  # points of a line
_ON_GRID = 20  # points of an image in each direction at which the scale is told


def scene_lines(items: Sequence[Item]) -> Iterator[str]:
    """What each parameter file's region and plane leave, of the images beside it where there are some."""
    samples = samples_of(items)
    for path, setup in _setups(items):
        for sample in samples or (None,):
            camera = camera_of(items, sample)
            scene = Scene.of(setup.recognizer.scene, camera)
            where = f"{path}: scene" + (f" in {sample.name}" if sample is not None and len(samples) > 1 else "")
            size = None if sample is None else sample.size
            yield from (f"{where}: {line}" for line in (*_region(scene, size), *_plane(scene, size), *_floor(scene)))
            if sample is not None and scene.region is not None:
                yield f"{where}: {_left(setup, scene, sample.images)}"


def draw_scene(items: Sequence[Item], output: Path) -> str:
    """Draw the first parameter file's region and plane over the first image. What came of it, a line."""
    setups, samples = _setups(items), [s for s in samples_of(items) if s.images]
    if not setups or not samples:
        return f"{output}: not drawn: it takes a parameter file with scene.region or scene.plane, and images"
    image, camera = samples[0].images[0], camera_of(items, samples[0])
    picture = _scene_picture(image, Scene.of(setups[0][1].recognizer.scene, camera))
    save_drawing(output, picture)
    return f"{output}: the scene of {setups[0][0]} over an image of {samples[0].name}"


def _scene_picture(image: Image, scene: Scene) -> Picture:
    """What lies outside of the region darkened; the field's grid with its metres, and its axes at the origin."""
    zoom = enlargement(image)
    base = class_picture(image) if image.ndim == 2 else image
    picture = np.ascontiguousarray(cv2.resize(base, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_NEAREST), np.uint8)
    if scene.region is not None:
        outside = np.ones(picture.shape[:2], np.uint8)
        cv2.fillPoly(outside, [np.rint((scene.region + 0.5) * zoom - 0.5).astype(np.int32)], 0)
        picture[outside > 0] //= 3
    canvas = Canvas(picture, zoom)
    if scene.plane is not None:
        _draw_grid(canvas, scene.plane, (image.shape[1], image.shape[0]))
    if scene.region is not None:
        canvas.polygon(scene.region, _REGION, 2)
    return canvas.picture


def _setups(items: Sequence[Item]) -> list[tuple[Path, Setup]]:
    found = [(i.path, i.content) for i in items if isinstance(i.content, Setup)]
    return [(path, setup) for path, setup in found if Scene.of(setup.recognizer.scene)]


def samples_of(items: Sequence[Item]) -> list[Sample]:
    bags = [s for i in items if isinstance(i.content, BagContent) for s in i.content.samples]
    return bags + [i.content for i in items if isinstance(i.content, Sample)]


def camera_of(items: Sequence[Item], sample: Sample | None) -> Camera | None:
    """The calibration beside a sample, else one that was named."""
    named = next((i.content for i in items if isinstance(i.content, Camera)), None)
    return named if sample is None or sample.camera is None else sample.camera


def _lattice(size: tuple[int, int]) -> Array:
    """(n, 2) pixels all over an image."""
    u, v = np.meshgrid(*(np.linspace(0, s - 1, _ON_GRID) for s in size))
    return np.column_stack([u.ravel(), v.ravel()])


def _region(scene: Scene, size: tuple[int, int] | None) -> Iterator[str]:
    if scene.region is None:
        return
    share = "" if size is None else f", {scene.inside(_lattice(size)).mean():.0%} of the image"
    yield f"region of {len(scene.region)} corners{share}"


def _plane(scene: Scene, size: tuple[int, int] | None) -> Iterator[str]:
    plane = scene.plane
    if plane is None:
        return
    n, at = len(plane.errors_px), np.reshape(plane.config.image_points, (-1, 2))
    if size is not None:
        at = _lattice(size)
        at = at[np.flatnonzero(scene.inside(at))]
    scales = plane.scales(at)
    seen = scales[scales > 0]
    line = f"plane by {n} points, frame '{plane.frame_id}'"
    if len(seen):
        line += f", {seen.min():.4g} to {seen.max():.4g} px/m, a pixel is {1e3 / np.median(seen):.3g} mm"
    if len(seen) < len(scales):
        line += f"; {1 - len(seen) / len(scales):.0%} of the image lie behind its horizon"
    yield line
    if n > 4:
        yield f"the points lie {np.sqrt(np.mean(plane.errors_px**2)):.2g} px from where the others have them"


def _floor(scene: Scene) -> Iterator[str]:
    if scene.floor is None:
        return
    c = scene.floor.config
    low, high = c.object_height_m - c.height_tolerance_m, c.object_height_m + c.height_tolerance_m
    yield (
        f"floor {c.camera_height_m:g} m below the camera, which looks down by {c.camera_pitch_deg:g} deg; objects' "
        f"frames {low:.3g} to {high:.3g} m above it, leaning by {c.max_tilt_deg:g} deg at most; in calibrated images"
    )


def _left(setup: Setup, scene: Scene, images: Sequence[Image]) -> str:
    wanted = {label for t in setup.targets for label in t.labels}
    segmenter, inside, count = Segmenter(setup.image), 0, 0
    for image in images:
        try:
            blobs = find_blobs(segmenter.labels(image), wanted, setup.recognizer, segmenter.blank)
        except ImageError as error:
            return f"blobs were not counted: {error}"
        inside, count = inside + int(scene.inside(centres(blobs)).sum()), count + len(blobs)
    return f"{inside} of {count} blobs of the objects' classes lie in the region, in {len(images)} images looked at"


def _draw_grid(canvas: Canvas, plane: FieldPlane, size: tuple[int, int]) -> None:
    there = plane.places(_lattice(size))
    given = np.reshape(plane.config.field_points, (-1, 2))
    reach = 2 * np.ptp(given, axis=0).max()  # a horizon is far away
    there = np.concatenate([given, there[(np.abs(there - given.mean(axis=0)) < reach).all(axis=1)]])
    low, high = there.min(axis=0), there.max(axis=0)
    step = _round_step(float((high - low).max()) / _LINES)
    for axis in (0, 1):
        for value in np.arange(np.ceil(low[axis] / step), np.floor(high[axis] / step) + 1) * step + 0.0:  # no -0
            points = np.full((_STEPS, 2), value)
            points[:, 1 - axis] = np.linspace(low[1 - axis], high[1 - axis], _STEPS)
            _draw_line(canvas, plane.pixels(points), f"{'xy'[axis]} {value:.4g}", size)
    for end, colour in zip(np.eye(2) * step, _AXES, strict=True):
        tail, head = plane.pixels(np.stack([np.zeros(2), end]))
        if np.isfinite([*tail, *head]).all():
            canvas.arrow(tail, head, colour, 2)


def _draw_line(canvas: Canvas, pixels: Array, text: str, size: tuple[int, int]) -> None:
    shown = np.logical_and.reduce((pixels >= 0) & (pixels <= np.array(size) - 1), axis=1)  # not of NaN
    for a, b, yes in zip(pixels, pixels[1:], shown[:-1] & shown[1:], strict=False):
        if yes:
            canvas.line(a, b, _GRID)
    if shown.any():
        at = (pixels[np.flatnonzero(shown)[0]] + 0.5) * canvas.zoom
        canvas.text(text, (int(at[0]) + 3, int(at[1]) - 3), _GRID, 0.3)


def _round_step(step: float) -> float:
    """The next of 1, 2, 5, 10, ... and their tenths."""
    power = 10.0 ** np.floor(np.log10(step))
    return float(next(m * power for m in (1, 2, 5, 10) if m * power >= step * (1 - 1e-9)))

"""Regions that somebody marked in images: COCO files whose annotations have polygons (`segmentation`) or a `bbox`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.base.errors import ConfigError, ImageError
from ...core.geometry.transforms import Array
from ..base.yaml_files import Value
from .annotations import annotated_image
from .coco import coco_entry, coco_image, read_coco

_SUBPIXEL_BITS = 8
_TOUCHED_PX = 2  # so far beyond the image outlines are drawn, for what they touch in it
_Regions = list[tuple[str, Array]]


@dataclass(frozen=True)
class MarkedImage:
    """An image and its regions: category and outline (n, 2) in pixels; where several overlap, the last one goes before.

    :param rest: category of what lies outside all regions; None: nobody has marked it.
    :param around_px: what is farther than this from every region is not marked at all.
    :param ignored: outlines of what is not marked, whatever lies there; regions go before.
    :param size: width and height, where its file tells them.
    :param exact: those regions that end where markers do, as axes tell. :param markers: the marker of each of these.
    """

    path: Path
    regions: tuple[tuple[str, Array], ...]
    rest: str | None = None
    around_px: float = math.inf
    ignored: tuple[Array, ...] = ()
    size: tuple[int, int] | None = None
    exact: tuple[tuple[str, Array], ...] = ()
    markers: tuple[str, ...] = ()

    def smaller_before(self) -> MarkedImage:
        """The same where a region that lies inside another goes before."""
        return replace(self, regions=tuple(larger_first(self.regions)))

    def read(self, numbers: dict[str, int], unmarked: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """The image (H, W, 3) BGR, and (H, W) each category's number, `unmarked` elsewhere."""
        try:
            image = annotated_image(self.path, self.size)
        except ImageError as error:
            raise ConfigError(f"{self.path}: {error}") from None
        if image.ndim != 3:
            raise ConfigError(f"{self.path}: a colour image is wanted; this one has one channel")
        labels = np.full(image.shape[:2], unmarked if self.rest is None else numbers[self.rest], np.uint8)
        if math.isfinite(self.around_px):
            marked = np.ones(labels.shape, np.uint8)
            for _, outline in self.regions:
                _fill(marked, outline, 0)
            labels[cv2.distanceTransform(marked, cv2.DIST_L2, 5) > self.around_px] = unmarked
        for outline in self.ignored:
            _fill(labels, outline, unmarked)
        for category, outline in self.regions:
            _fill(labels, outline, numbers[category])
        return image, labels

    def parts(self, category: str, own: NDArray[np.bool_]) -> Iterator[tuple[str, NDArray[np.bool_]]]:
        """A category's pixels (H, W) by the marker that shows them; '': those that are drawn."""
        drawn, seen = own.copy(), dict[str, NDArray[np.uint8]]()
        for (name, outline), marker in zip(self.exact, self.markers, strict=True):
            if name == category:
                _fill(seen.setdefault(marker, np.zeros(own.shape, np.uint8)), outline, 1)
        for marker, mask in seen.items():
            drawn &= mask == 0
            yield marker, own & (mask > 0)
        yield "", drawn


def covered(outline: Array, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """(H, W) the pixels of an image of a shape whose middles lie in an outline (n, 2), or on it."""
    mask = np.zeros(shape[:2], np.uint8)
    _fill(mask, outline, 1)
    return mask > 0


def _fill(labels: NDArray[np.uint8], outline: Array, number: int) -> None:
    """Number the pixels whose middles lie in an outline (n, 2), or on it."""
    size, w = np.array(labels.shape[::-1]), _TOUCHED_PX
    low = np.clip(np.floor(outline.min(axis=0)), 0, size).astype(int)
    high = np.clip(np.ceil(outline.max(axis=0)) + 1, low, size).astype(int)
    window, corners = labels[low[1] : high[1], low[0] : high[0]], np.asarray(outline, np.float64) - low + w
    mask = np.zeros(np.add(window.shape, 2 * w), np.uint8)
    fine = [np.rint(corners * (1 << _SUBPIXEL_BITS)).astype(np.int32)]
    cv2.fillPoly(mask, fine, 1, shift=_SUBPIXEL_BITS)
    # it paints all pixels that the outline touches: of small patches a fourth too many
    touched = cv2.polylines(np.zeros_like(mask), fine, isClosed=True, color=1, shift=_SUBPIXEL_BITS)
    for y, x in np.argwhere(mask & cv2.dilate(touched, np.ones((3, 3), np.uint8))).tolist():
        mask[y, x] = cv2.pointPolygonTest(corners.astype(np.float32), (x, y), measureDist=False) >= 0
    window[mask[w:-w, w:-w] > 0] = number


def larger_first(regions: Iterable[tuple[str, Array]]) -> list[tuple[str, Array]]:
    """Regions in an order in which one that lies inside another goes before."""
    return sorted(regions, key=lambda region: -_area(region))


def parted(regions: Iterable[tuple[str, Array]], markers: Iterable[tuple[str, Array]]) -> tuple[_Regions, _Regions]:
    """Regions that are larger than all markers, and the others: markers lie over the former, and on any body."""
    most = max(_area(marker) for marker in markers)
    both: tuple[_Regions, _Regions] = [], []
    for region in regions:
        both[_area(region) <= most].append(region)
    return both


def _area(region: tuple[str, Array]) -> float:
    return float(cv2.contourArea(np.asarray(region[1], np.float32)))


def load_regions(paths: Iterable[str | Path], images_folder: Path | None = None) -> list[MarkedImage]:
    """The images of COCO files that have regions, in the file's order. :param images_folder: see `drawn_regions`."""
    marked = []
    for path in map(Path, paths):
        regions, sizes = _regions_of(path, images_folder or path.parent, keypoints=True)
        marked += [MarkedImage(image, tuple(own), size=sizes[image]) for image, own in regions.items() if own]
    return marked


def drawn_regions(paths: Iterable[str | Path], images_folder: Path | None) -> dict[Path, list[tuple[str, Array]]]:
    """Image -> category and outline of what is drawn there of categories without keypoints; crowds are passed over.

    :param images_folder: where the images lie; without it, beside each file.
    """
    found: dict[Path, list[tuple[str, Array]]] = {}
    for path in map(Path, paths):
        for image, own in _regions_of(path, images_folder or path.parent, keypoints=False)[0].items():
            found.setdefault(image, []).extend(own)
    return found


def _regions_of(
    path: Path, folder: Path, *, keypoints: bool
) -> tuple[dict[Path, list[tuple[str, Array]]], dict[Path, tuple[int, int] | None]]:
    """Each image's regions, and its size where the file tells it.

    :param keypoints: of objects with keypoints, too; else of no others, nor of crowds.
    """
    top = read_coco(path)
    categories = {coco_entry(v, "id").integer(): v for v in top["categories"].items()}
    images = dict(coco_image(v, folder) for v in top["images"].items())
    regions: dict[Path, list[tuple[str, Array]]] = {image: [] for image, _ in images.values()}
    for annotation in top["annotations"].items():
        category, image = coco_entry(annotation, "category_id"), coco_entry(annotation, "image_id")
        if category.integer() not in categories:
            raise category.error(f"there is no category {category.raw}")
        if image.integer() not in images:
            raise image.error(f"there is no image {image.raw}")
        entry = categories[category.raw]
        if keypoints or _is_drawn(annotation, entry):
            name = coco_entry(entry, "name").text()
            regions[images[image.raw][0]] += [(name, outline) for outline in outlines_of(annotation)]
    return regions, dict(images.values())


def _is_drawn(annotation: Value, category: Value) -> bool:
    """Whether it is a box or a polygon of a category without keypoints, and no crowd."""
    if category.raw.get("keypoints") or annotation.raw.get("iscrowd") in (1, True):
        return False
    box = annotation.raw.get("bbox")
    has_box = isinstance(box, list) and len(box) == 4 and all(isinstance(v, (int, float)) for v in box)
    return bool(annotation.raw.get("segmentation")) or (has_box and box[2] > 0 and box[3] > 0)


def outlines_of(annotation: Value) -> Iterator[Array]:
    """An annotation's polygons, else its box, each (n, 2) pixels."""
    entries = annotation.entries()
    if isinstance(entries.get("segmentation", annotation).raw, list) and entries["segmentation"].raw:
        for polygon in entries["segmentation"].items():
            numbers = [v.number() for v in polygon.items()]
            if len(numbers) < 6 or len(numbers) % 2:
                raise polygon.error("must be x, y of three or more corners")
            yield np.reshape(numbers, (-1, 2))
    elif "bbox" in entries:
        x, y, width, height = entries["bbox"].vector(4)
        yield np.array([[x, y], [x + width - 1, y], [x + width - 1, y + height - 1], [x, y + height - 1]])
    elif "segmentation" in entries and isinstance(entries["segmentation"].raw, dict):
        raise entries["segmentation"].error("is a run-length mask, which is not read; give polygons, or a box (bbox)")
    else:
        raise annotation.error("has neither a polygon (segmentation) nor a box (bbox)")

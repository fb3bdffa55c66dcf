"""Recognition in the image plane: rigid alignment of contours, then grouping by learned constraints."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .alignment.contour_map import ContourMap
from .alignment.matching import Matches, find_matches
from .alignment.shapes import Shape
from .base.config import AlignmentConfig, RecognizerConfig
from .base.deferred import Deferred
from .geometry.range_limits import narrowed, scale_limits
from .geometry.scene import Scene
from .grouping.candidates import Roles, ShapeOf, candidates_of
from .grouping.group_search import GroupSearch
from .grouping.paper import align_literally, group_literally
from .grouping.solution import solve
from .image.blobs import Blob, centres
from .image.image_frame import ImageFrame
from .model.found import Detection
from .model.frame_result import Rejection
from .model.target import Target
from .turned_down import unmatched
from .verdict.report import detections_of, rejections_of


class FlatStage:
    """Finds targets by similarities of the image plane: the paper's two phases, in either profile."""

    def __init__(self, targets: tuple[Target, ...], config: RecognizerConfig, blank: tuple[int, ...]) -> None:
        """:param blank: ignored rectangles x,y,width,height,..."""
        self._targets = targets
        self._config = config
        self._blank = blank
        self._shapes, shape_of = _distinct_shapes(targets, config.alignment)
        self._roles = [Roles.of(t, own) for t, own in zip(targets, shape_of, strict=True)]
        self._wanted = {
            (shape, label) for r in self._roles for shape, label in zip(r.shape.tolist(), r.label.tolist(), strict=True)
        }

    def unmatched(
        self, blobs: Sequence[Blob], matches: Matches, detections: Sequence[Detection], rejected: Sequence[Rejection]
    ) -> Sequence[Rejection]:
        """The largest blobs of each target that fit no outline of its required component, and in which nothing was
        found or turned down."""
        if not self._targets or not blobs:
            return ()
        mine = self._aligned(blobs)
        # now, for what is put off would keep the matches' contour map
        on = [{*matches.placed.blob[np.isin(matches.placed.shape, r.required_shapes)].tolist()} for r in self._roles]
        left = [[b for n, b in enumerate(mine) if n not in fits] for fits in on]
        return Deferred(lambda: unmatched(self._targets, left, detections, rejected))

    def _aligned(self, blobs: Sequence[Blob]) -> tuple[Blob, ...]:
        """Those that outlines are aligned with: matches count these."""
        labels = {label for _, label in self._wanted}
        return tuple(b for b in blobs if b.label in labels)

    def align(self, frame: ImageFrame, blobs: tuple[Blob, ...]) -> Matches:
        """Where markers' outlines lie on blobs' contours (paper, steps 1 to 5)."""
        blobs = self._aligned(blobs)
        if not blobs:
            return Matches.none(self._shapes)
        if self._config.profile == "paper":
            return align_literally(blobs, frame.size, self._shapes, self._wanted, self._config, frame.deadline)
        cmap = ContourMap.build(blobs, frame.size)
        scales = narrowed(scale_limits(self._config, frame.calibration), frame.scene.scale_limits(centres(blobs)))
        return find_matches(blobs, cmap, self._shapes, self._wanted, self._config, frame.deadline, self._blank, scales)

    def group(self, frame: ImageFrame, matches: Matches) -> tuple[tuple[Detection, ...], Sequence[Rejection], bool]:
        """Objects, what was turned down and why, and whether `search_nodes` ended the choice (paper, steps 6 to 8)."""
        if not len(matches):
            return (), (), False
        if self._config.profile == "paper":
            groups = [g for roles in self._roles for g in group_literally(roles, matches, self._config, frame.deadline)]
            return *_sifted(detections_of(groups, matches, self._targets, literal=True), frame.scene), False
        matches = matches.related(frame.deadline.part(self._config.time.overlap_share))
        if not len(matches):
            return (), (), False
        searches = [
            GroupSearch(candidates_of(roles, matches, self._config), matches, self._config, frame.deadline)
            for roles in self._roles
        ]
        solution = solve(searches, matches, self._config, frame.deadline)
        found = detections_of(solution.accepted, matches, self._targets, solution.margins)
        detections, misplaced = _sifted(found, frame.scene)
        overlap = matches.overlap  # a result that is kept shall not keep the contour map, nor tables of pairs
        for search in searches:
            search.forget_table()
        reasons = Deferred(lambda: (*misplaced, *rejections_of(solution, searches, overlap, self._config)))
        return detections, reasons, solution.out_of_nodes


def _sifted(detections: tuple[Detection, ...], scene: Scene) -> tuple[tuple[Detection, ...], tuple[Rejection, ...]]:
    """Those that can be where they are, numbered anew, and the others with the reason."""
    if not (scene and detections):
        return detections, ()
    places = np.array([(d.image.x, d.image.y) for d in detections])
    reasons = scene.reasons(places, np.array([d.image.scale for d in detections]))
    kept, refused, number = [], [], Counter[str]()
    for d, reason in zip(detections, reasons, strict=True):
        if reason is None:
            kept.append(replace(d, id=number[d.object]))
            number[d.object] += 1
        else:
            refused.append(Rejection(d.object, reason, d.score, d.image.x, d.image.y))
    return tuple(kept), tuple(refused)


def _distinct_shapes(targets: tuple[Target, ...], config: AlignmentConfig) -> tuple[list[Shape], list[ShapeOf]]:
    """Each outline once, however many components and targets show it, and which one each marker has."""
    shapes: list[Shape] = []
    number: dict[bytes, int] = {}
    shape_of: list[ShapeOf] = []
    for target in targets:
        mine: ShapeOf = {}
        for name, marker in target.model.markers.items():
            shape = Shape.from_marker(marker, config)
            key = shape.key()
            if key not in number:
                number[key] = len(shapes)
                shapes.append(shape)
            mine[name] = number[key]
        shape_of.append(mine)
    return shapes, shape_of

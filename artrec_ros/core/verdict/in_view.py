"""Components of told objects as the image shows them, and what of all their markers could be seen there.

Of a component that its markers close in, as a box or a ball of one colour, the outline is that of all that shows:
sides have no edges in the image. Its place is that of one of them, as of all markers; that of a ball, on which nothing
tells where a side lies, is its centre.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..geometry.polygons import signed_area
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.codes import OUTSIDE, OWNED
from ..image.image_frame import ImageFrame
from ..model.found import Instance
from ..model.kinematics import Frames
from ..model.surface import INSIDE_POINTS
from ..pose.finder import WholeObjectFinder
from ..pose.surface_kernels import LEAST_DEPTH_M
from .missing import MarkersInView
from .nearer import hidden_by_each, met_by_each
from .verdicts import Verdict


class Part(NamedTuple):
    """A component that is seen: the patch that shows it, and the probability that it lies there."""

    patch: int
    probability: float


Parts = dict[int, Part]  # by the component's index
Shows = dict[tuple[str, str], str]  # as of `Alternatives.shows`


class PartsInView:
    """Those of one target's objects."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, surface = finder, finder.surface
        patches = [surface.patches[p] for p in surface.markers]
        self._row = {p: row for row, p in enumerate(surface.markers.tolist())}
        # the points of all markers: samples of the inside, one number of them each, and after these what is drawn
        self._inside = len(patches), INSIDE_POINTS
        self._bulge = np.array([p.bulge for p in patches])
        self._points = np.concatenate([p.inside for p in patches] + [p.drawn for p in patches])
        n_drawn = [len(p.drawn) for p in patches]
        component = surface.component[surface.markers]
        self._on = np.concatenate([np.repeat(component, INSIDE_POINTS), np.repeat(component, n_drawn)])
        self._first_drawn = self._inside[0] * self._inside[1] + np.cumsum([0, *n_drawn])
        # what faces the camera is placed by the one side that is seen
        solids = surface.solids if not finder.facing else ()
        self._sides = {c: np.flatnonzero(component == c) for c in solids}
        self._turn = np.sign([signed_area(p.marker.outline) for p in patches if p.marker is not None])

    def of(
        self,
        verdicts: Sequence[Verdict],
        told: Sequence[Parts],
        frames: Frames,
        frame: ImageFrame,
        among: Sequence[Verdict],
        shows: Sequence[Shows] = (),
    ) -> tuple[list[tuple[Instance, ...]], MarkersInView]:
        """Components as the image shows them: where part of a marker is hidden, x, y are the visible part's centre, but
        for balls. And what of all markers could be seen.

        :param shows: of each object. Not given: nothing is known of it.
        """
        surface, camera = self._finder.surface, frame.camera
        X = surface.place(frames, self._points, self._on)
        pixels, samples = project(camera, X), slice(self._first_drawn[0])
        inside = pixels[:, samples].reshape(len(pixels), *self._inside, 2)
        within = frame.field.at(inside) != OUTSIDE  # a view from above is larger than what the image shows of it
        free, by = self._free(verdicts, among, inside, X[:, samples])
        first = self._first_drawn[:-1]
        shown = surface.shown(frames, surface.markers, INSIDE_POINTS)
        drawn = [self._outline(pixels, row) for row in range(len(first))]
        view = MarkersInView(pixels[:, first], X[:, first, 2], drawn, within, shown, free, by)
        weight = view.seen[..., None]
        count = weight.sum(axis=2)
        centroid, tail, head = (pixels[:, first + i] for i in range(3))  # (H, M, 2)
        # by how far the middle of what is seen is off that of all: the samples' own middle is not quite the centroid
        off = (inside * weight).sum(axis=2) / np.maximum(count, 1) - inside.mean(axis=2)
        centre = np.where((count > 0) & (self._bulge == 0)[:, None], centroid + off, centroid)
        theta = np.arctan2(head[..., 1] - tail[..., 1], head[..., 0] - tail[..., 0])
        # at the outline's centroid, of a ball at its centre, which is behind that
        far = np.linalg.norm(X[:, first], axis=2)
        scale = camera.focal_px / np.maximum(view.depth * np.hypot(far, self._bulge) / np.maximum(far, 1e-9), 1e-6)
        values = np.concatenate([centre, theta[..., None], scale[..., None]], axis=-1).tolist()  # (H, M, 4)
        parts = [
            tuple(self._component(part, pixels[h], values[h], view, h, own) for part in each.values())
            for h, (each, own) in enumerate(zip(told, shows or [Shows()] * len(told), strict=True))
        ]
        return parts, view

    def _component(
        self, part: Part, pixels: Array, values: list[list[float]], view: MarkersInView, h: int, shows: Shows
    ) -> Instance:
        """The component of object `h` that a patch shows. :param values: (M, 4) of all markers."""
        told = self._instance(part, pixels, values[self._row[part.patch]], shows)
        sides = self._sides.get(self._finder.surface.patches[part.patch].component)
        return told if sides is None else replace(told, contour=self._around(view, h, sides, told.contour))

    def _around(self, view: MarkersInView, h: int, sides: NDArray[np.int64], alone: Array) -> Array:
        """(n, 2) the outline of a solid: of all of its sides that face the camera. :param alone: of one of them."""
        area = np.array([signed_area(view.outlines[m][h]) for m in sides.tolist()])
        # an outline that is counter-clockwise with y up runs the other way round in an image, where its y is down
        facing = sides[(area * self._turn[sides] < 0) & (view.depth[h, sides] > LEAST_DEPTH_M)]
        if not facing.size:
            return alone
        outline = np.concatenate([view.outlines[m][h] for m in facing.tolist()])
        return np.asarray(cv2.convexHull(outline.astype(np.float32))[:, 0], float)

    def _free(
        self, verdicts: Sequence[Verdict], among: Sequence[Verdict], inside: Array, points: Array
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_] | None]:
        """`MarkersInView.free` and `by`. :param inside: (H, M, n, 2) pixels. :param points: (H, M n, 3) of the same."""
        owned = np.stack([v.claim.frame.field.at(inside[h]) == OWNED for h, v in enumerate(verdicts)])
        if self._finder.facing:  # which one is nearer is not known
            return ~owned, None
        share = met_by_each(verdicts, among, points).reshape(-1, *owned.shape)
        by = hidden_by_each(share, owned, self._finder.config.verdict.nearer)
        untold = owned & np.all(share == np.inf, axis=0)  # what took these is none of `among`
        return ~(np.any(by, axis=0) | untold), by

    def _instance(self, part: Part, pixels: Array, values: list[float], shows: Shows) -> Instance:
        """The component that a patch shows. :param pixels: (n, 2) of all markers' points."""
        shown, (x, y, theta, scale) = self._finder.surface.patches[part.patch], values
        assert shown.marker is not None  # what shows a component is a marker
        name, marker = self._finder.target.model.components[shown.component].name, shown.marker.name
        outline, own = self._outline(pixels, self._row[part.patch]).copy(), shows.get((name, marker), "")
        return Instance(name, marker, part.probability, x, y, theta, scale, outline, own)

    def _outline(self, pixels: Array, row: int) -> Array:
        """(..., m, 2) of the marker of a row, of all markers' points (..., n, 2): behind centroid, tail and head."""
        return pixels[..., self._first_drawn[row] + 3 : self._first_drawn[row + 1], :]

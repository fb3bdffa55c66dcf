"""First hypotheses of objects that face the camera: one of their components at pixels of the blobs of its class."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.range_limits import ScaleLimits
from ..geometry.transforms import Array
from ..image.blobs import Blob, centres
from ..image.image_frame import ImageFrame
from ..model.marker import Marker
from ..model.objects import ObjectModel
from .bends import Bends
from .grid_kernels import Grid, best_on_grid
from .guesses import is_small
from .pose_fit import fit_component
from .poses import Poses
from .surface_model import SpatialModel
from .view_bank import ViewBank
from .views import FACING, view_bank

_AT_ONCE = 16  # blobs between two looks at the clock
_MOST_MERGED = 16  # components that are looked for in one blob
_FINER = 4  # times as many points at most of a lattice over a blob that is larger than the component


class Guesses(NamedTuple):
    """Hypotheses with the votes for the component that is laid on blobs (H,), and of which blob and size each is (H,):
    of B blobs and the n-th smaller size n * B and more."""

    poses: Poses
    votes: Array
    blob: np.ndarray


class FacingGuesser:
    """Lays one component's markers on blobs, face on: a grid of places, directions and scales.

    It takes neither corners nor a blob of its own: patches of 8 px have no corners, and those that touch have one blob.
    One that may be of several classes is of the blob's: across two neighbours of different ones it does not lie.

    :ivar labels: classes of which the blobs are that the component makes. :ivar bends: of the joints that carry it.
    :ivar along: of the object's frame: a direction in its plane.
    """

    def __init__(
        self,
        model: ObjectModel,
        surface: SpatialModel,
        config: RecognizerConfig,
        component: int,
        turns: int | None = None,
    ) -> None:
        """:param turns: directions that are tried; None: as configured."""
        part, labels = model.components[component], surface.labels[component]
        roles = {n: (surface.roles.inside((n,)), surface.roles.ring((n,), part.body_labels)) for n in labels}
        table = surface.roles.table
        self._config, self._surface, self._component, self._markers = config, surface, component, part.markers
        views = [view_bank(m, config.guesses, facing=True) for m in part.markers]
        self._banks = {
            label: [ViewBank(v, table[inside], table[ring], surface.limits, config.guesses) for v in views]
            for label, (inside, ring) in roles.items()
        }
        self._turns = turns or config.facing.turns
        self.labels, self.bends = labels, Bends(surface, component, config.guesses.joint_draws)
        R, t = self.bends.R[0], self.bends.t[0]
        in_object = [(R @ _turn(m), R @ m.centre + t) for m in part.markers]
        self.along = in_object[0][0][:, 0]
        # the object's frame in a marker's about its centroid, as a camera that it faces sees it: a turn, an origin
        self._frames = [(FACING @ R_m.T, -FACING @ R_m.T @ centre) for R_m, centre in in_object]

    def guess(self, frame: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits, sizes: int = 1) -> Guesses:
        """The best of every direction about each blob; none of those that the deadline leaves.

        :param limits: of the scale.
        :param sizes: so many ranges of the component's size, one below the other, are looked through, each by itself: a
            large alignment that covers several merged components has more votes than a right one.
        """
        found = [Guesses(self._surface.no_poses, np.zeros(0), np.zeros(0, np.int64))]
        for part in frame.deadline.parts(len(blobs), _AT_ONCE):
            for label, banks in self._banks.items():
                rows = np.array([n for n in range(len(blobs))[part] if blobs[n].label == label], np.int64)
                if len(rows):
                    found += self._laid_on(frame, blobs, rows, banks, limits, sizes)
        poses, votes, of = zip(*found, strict=True)
        return Guesses(Poses.concatenate(list(poses)), np.concatenate(votes), np.concatenate(of))

    def _laid_on(
        self,
        frame: ImageFrame,
        blobs: Sequence[Blob],
        rows: NDArray[np.int64],
        banks: Sequence[ViewBank],
        limits: ScaleLimits,
        sizes: int,
    ) -> Iterator[Guesses]:
        """`guess` of some blobs, which are of one class. :param banks: of that class."""
        mine = [blobs[n] for n in rows]
        within = _within(frame, mine, limits)
        for (m, bank), size in product(enumerate(banks), range(sizes)):
            grid = self._grid(frame, mine, within, self._markers[m], size)
            most = int(grid.keep.sum()) * grid.turns
            T, votes, of = np.empty((most, 4)), np.empty(most), np.empty(most, np.int64)
            n = best_on_grid(grid, bank.arrays, bank.look, frame.view, T, votes, of)
            yield Guesses(self.lifted(T[:n], frame, m), votes[:n], rows[of[:n]] + size * len(blobs))
        if sizes == 1 and self._surface.is_lone_marker:
            yield from self._aligned(frame, blobs, rows, within, banks)

    def _aligned(
        self,
        frame: ImageFrame,
        blobs: Sequence[Blob],
        rows: NDArray[np.int64],
        within: Array,
        banks: Sequence[ViewBank],
    ) -> Iterator[Guesses]:
        """Alignments of a lone outline with those of whole blobs, as the paper has them: a grid lays a marker's middle
        on pixels of its class, and that of a ring or a wave lies beside them; and of what is slender or has many teeth
        its steps are too coarse. Where there are other markers these tell as well, and blobs hold parts of several.

        :param within: (B, 2) least and greatest scales.
        """
        for (m, bank), (row, (least, most)) in product(enumerate(banks), zip(rows.tolist(), within, strict=True)):
            if not is_small(blobs[row], self._config.guesses):
                T, votes, _ = bank.align_blob(frame, blobs[row], self._config.facing.aligned, self._config.blobs, 0)
                kept = np.flatnonzero((T[:, 3] >= least) & (T[:, 3] <= most))
                yield Guesses(self.lifted(T[kept], frame, m), votes[kept], np.full(len(kept), row))

    def fitted(self, frame: ImageFrame, poses: Poses) -> Poses:
        """What was laid on blobs, fitted to the component's contours; those that the deadline leaves stay.

        Lattice, scales and turns are coarser in proportion to the marker, and a fit finds no edge beyond its reach: so
        the first steps reach as far as the lattice's points are apart, where that is more than usual."""
        coarse = self._config.fit.coarse_reach_px
        size_px = np.sqrt(max(m.area for m in self._markers)) * frame.camera.focal_px / poses.t[:, 2]
        farther = np.ceil(size_px / (np.sqrt(self._config.facing.grid_points) * max(coarse))).astype(np.int64)
        out = Poses(poses.R.copy(), poses.t.copy(), poses.q.copy())
        for n in np.unique(farther).tolist():
            rows = np.flatnonzero(farther == n)
            reach_px = (*(n * reach for reach in coarse), *coarse) if n > 1 else coarse
            fit = fit_component(
                self._surface, frame, poses[rows], self._component, self._config.fit, reach_px, facing=True
            )
            out.R[rows], out.t[rows], out.q[rows] = fit.R, fit.t, fit.q
        return out

    def scales(
        self, frame: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits, marker: Marker | None = None
    ) -> Array:
        """(B, 2) least and greatest scale of a marker in its blob. :param marker: None: the component's first one."""
        blob_px = np.array([b.area_px for b in blobs])
        _, least, most = self._sizes(blob_px, _within(frame, blobs, limits), marker or self._markers[0], 0)
        return np.stack([least, most], axis=1)

    def in_view(self, place: Array) -> Array:
        """(2,) where the component's first marker, turned by nothing, sees a place (3,) of the object's frame."""
        R_marker, origin = self._frames[0]
        return np.asarray((R_marker @ place + origin)[:2])

    def _grid(self, frame: ImageFrame, blobs: Sequence[Blob], within: Array, marker: Marker, size: int) -> Grid:
        """:param within: (B, 2) least and greatest scales. :param size: the n-th smaller one."""
        config, blob_px = self._config.facing, np.array([b.area_px for b in blobs])
        area, least, most = self._sizes(blob_px, within, marker, size)
        keep = np.ceil(blob_px / (marker.area * np.maximum(least, 1e-9) ** 2)).astype(np.int64)
        spread = np.maximum(area, blob_px / _FINER)  # over as much a lattice is of about so many points
        return Grid(
            frame.field.padded_labels,
            np.array([b.label for b in blobs]),
            np.array([b.box.ravel() for b in blobs]),
            np.maximum(np.ceil(np.sqrt(spread / config.grid_points)), 1).astype(np.int64),
            np.ascontiguousarray(np.stack([least, np.maximum(most, least)], axis=1)),
            float(config.scale_ratio),
            self._turns,
            np.clip(keep, 1, _MOST_MERGED),
            0.5,
        )

    def _sizes(self, blob_px: Array, within: Array, marker: Marker, size: int) -> tuple[Array, Array, Array]:
        """(B,) areas in blobs and least and greatest scales; parameters as of `_grid`."""
        config, ratio = self._config.facing, self._config.guesses.most_area_ratio
        more, (lowest, highest) = self._config.guesses.most_area_more_px, within.T
        one_px = np.minimum(blob_px, marker.area * highest**2)  # else others are merged with it, be they clutter
        area = config.least_area_share**size * one_px
        most = np.minimum(np.sqrt((area if size else ratio * area + more) / marker.area), highest)
        least = np.minimum(np.sqrt(config.least_area_share * area / marker.area), most)  # a larger one: several merged
        return area, np.maximum(least, lowest), most

    def lifted(self, T: Array, frame: ImageFrame, marker: int = 0) -> Poses:
        """Poses of which one of the component's markers lies so in the image (H, 4: x, y, turn, scale)."""
        camera, (R_marker, origin) = frame.camera, self._frames[marker]
        c, s, roll = np.cos(T[:, 2]), np.sin(T[:, 2]), np.zeros((len(T), 3, 3))
        roll[:, 0, 0], roll[:, 0, 1], roll[:, 1, 0], roll[:, 1, 1], roll[:, 2, 2] = c, -s, s, c, 1.0
        depth = camera.focal_px / T[:, 3]
        t = np.column_stack([(T[:, :2] - camera.matrix[:2, 2]) * depth[:, None] / camera.focal_px, depth])
        return Poses(roll @ R_marker, t + roll @ origin, np.tile(self.bends.q[0], (len(T), 1)))


def _within(frame: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits) -> Array:
    """(B, 2) least and greatest scales of what is at blobs."""
    if frame.scene:
        return np.clip(frame.scene.scale_limits(centres(blobs)), limits.least, limits.greatest)
    return np.tile((limits.least, limits.greatest), (len(blobs), 1))


def _turn(marker: Marker) -> Array:
    assert marker.T_component_marker is not None  # the model is spatial
    return marker.T_component_marker.rotation

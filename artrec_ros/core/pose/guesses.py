"""Guesses of a spatial object's pose, from each blob that one of its components may have made."""

from __future__ import annotations

import numpy as np

from ..base.config import GuessesConfig, RecognizerConfig
from ..geometry.range_limits import range_limits
from ..geometry.transforms import Array
from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..model.marker import Marker
from ..model.objects import ObjectModel
from .bends import Bends
from .distinct import best_distinct
from .poses import Poses
from .same_sides import unlike_markers
from .solid_views import solids_of
from .surface_model import SpatialModel
from .view_bank import ViewBank
from .views import lift, view_bank
from .votes import Labels

Key = tuple[bytes, float | None, Labels, Labels]


class Guesser:
    """Aligns one component's markers, from many sides, with blobs: one by one, and together those that meet.

    :ivar labels: classes of which the blobs are that the component makes. :ivar bends: of the joints that carry it.
    :ivar has_solids: whether some meet. :ivar largest_m2: the greatest area of what makes one blob.
    :ivar reach_m: how far from the object's origin its markers get.
    """

    def __init__(
        self,
        model: ObjectModel,
        surface: SpatialModel,
        component: int,
        config: RecognizerConfig,
        banks: dict[Key, ViewBank] | None = None,
    ) -> None:
        """:param banks: of other components: equal markers of one class on equal bodies share one."""
        banks = {} if banks is None else banks
        self._all, self._config, self._search = config, config.guesses, config.search
        part, labels, stands = model.components[component], surface.labels[component], config.scene.floor.is_given
        self.labels, self._none = labels, surface.no_poses
        self._markers = [part.markers[n] for n in unlike_markers(surface, component, stands=stands)]
        inside = surface.table[surface.roles.inside(labels)]
        body = part.body_labels
        ring = surface.table[surface.roles.ring(labels, body)]
        for m in self._markers:
            if (key := _key(m, labels, body)) not in banks:
                banks[key] = ViewBank(view_bank(m, config.guesses), inside, ring, surface.limits, config.guesses)
        self._banks = [banks[_key(m, labels, body)] for m in self._markers]
        self.bends = Bends(surface, component, config.guesses.joint_draws)
        self.reach_m = float(
            np.linalg.norm(self.bends.t, axis=1).max()
            + max(np.linalg.norm(m.centre) + np.linalg.norm(m.outline - m.centroid, axis=1).max() for m in part.markers)
        )
        in_marker = [self._object_in_marker(m) for m in self._markers]
        solids = solids_of(surface, component, config.guesses)
        self.has_solids = len(solids) > 0
        for solid in solids:
            self._banks.append(ViewBank(solid.views, inside, ring, surface.limits, config.guesses, solid.flips))
            in_marker.append(self._object_in(np.eye(3), solid.centre))
        self.largest_m2 = max(float(bank.arrays.area.max()) for bank in self._banks)
        # the object's frame, see `lift`: (F, V, 3, 3) of each bank's views, and (3,) its origin along its own axes
        self._flips = [bank.flips @ R for bank, (R, _) in zip(self._banks, in_marker, strict=True)]
        self._origins = [R.T @ t for R, t in in_marker]

    def guess(self, frame: ImageFrame, blob: Blob, piece: int = 0) -> Poses:
        """Object poses from one blob within reach, the best of each marker by the votes for it, as many as there is
        time for; joints mid-range. :param piece: see `scale_range`."""
        growth = self._config.growth
        grown = growth if is_small(blob, self._config) else growth[:1]
        found = [self._none]
        for m in range(len(self._banks)):
            if frame.deadline.expired:
                break
            found.append(self._of_marker(m, frame, blob, grown, piece))
        return Poses.concatenate(found)

    def _of_marker(self, m: int, frame: ImageFrame, blob: Blob, grown: tuple[float, ...], piece: int) -> Poses:
        keep = self._config.blob_keep
        T, votes, view = self._banks[m].align_blob(frame, blob, keep, self._all.blobs, piece)
        if len(grown) > 1:
            T, view = np.concatenate([T * (1, 1, 1, g) for g in grown]), np.tile(view, len(grown))
        R, t = lift(self._flips[m], view, T, frame.camera, self._origins[m])
        found, votes = Poses(R, t, np.tile(self.bends.q[0], (len(R), 1))), np.tile(votes, len(R) // max(len(votes), 1))
        near_m, far_m = range_limits(self._all, frame.camera)
        if near_m > 0 or far_m < np.inf:  # else those behind the camera stay, too
            off = max(self._config.growth)  # a guess's depth is off by as much as its scale
            within = (t[:, 2] * off >= near_m) & (t[:, 2] <= far_m * off)
            found, votes = found[within], votes[within]
        floor = frame.scene.floor
        if floor is not None and len(self.bends) == 1:  # a limb's may yet be turned by the joints that carry it
            stands = floor.may_stand(found.R, found.t, self._config.standing_slack)
            found, votes = found[np.flatnonzero(stands)], votes[stands]
        return found[best_distinct(found, votes, keep * len(grown), self._search)]

    def _object_in_marker(self, marker: Marker) -> tuple[Array, Array]:
        """The object's frame (3, 3), (3,) in a marker's whose origin is its centroid; joints mid-range."""
        T = marker.T_component_marker
        assert T is not None  # the model is spatial
        return self._object_in(T.rotation, marker.centre)

    def _object_in(self, rotation: Array, centre: Array) -> tuple[Array, Array]:
        """The object's frame (3, 3), (3,) in one that is turned and placed so in the component; joints mid-range."""
        R = (self.bends.R[0] @ rotation).T
        return R, -R @ (self.bends.R[0] @ centre + self.bends.t[0])


def _key(marker: Marker, labels: Labels, body: Labels) -> Key:
    return (marker.outline - marker.centroid).round(9).tobytes(), marker.disc_radius, labels, body


def is_small(blob: Blob, config: GuessesConfig) -> bool:
    """Whether a blob's shape tells little of its marker."""
    return blob.area_px < config.small_px

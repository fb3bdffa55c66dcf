"""Which of two targets' objects it is that is seen in one place, once both are at rest: as of two turns of one object,
by what both explain, by how near to contours edges lie, and of lone markers by the pixels in which they differ."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from ..geometry.transforms import Array
from ..image.codes import OUTSIDE, OWNED
from ..image.image_frame import ImageFrame
from .differing import differing_px, outlines_of
from .finder import WholeObjectFinder
from .poses import Poses
from .turn_evidence import Evidence, scatters, share_of_votes, signed_ratio


class Laid(NamedTuple):
    """One object. :ivar pose: at rest. :ivar votes: for it."""

    finder: WholeObjectFinder
    pose: Poses
    votes: float


class Said(NamedTuple):
    """What speaks for a rival, against an object. :ivar pixels: (2,) in which they differ, for the object and for it.
    :ivar evidence: as of two turns of one object."""

    pixels: Array
    evidence: Evidence

    def log_odds(self, weights: Sequence[float] | Array) -> float:
        """That it is the rival that is there: before anything is known of them they are as likely.

        :param weights: of the logarithm of the pixels, how many more there are of each, and of the evidence.
        """
        own, other = np.log(self.pixels + weights[1])
        return float(weights[0] * (other - own) + self.evidence.log_odds((0.0, *weights[2:]))[0])


def said_of(frame: ImageFrame, own: Laid, rival: Laid) -> Said:
    """:param rival: its votes are those for what both explain."""
    share = share_of_votes(np.array([rival.votes]), np.array([max(own.votes, 1e-9)]))
    return Said(_differing(frame, own, rival), Evidence(np.log(share), _by_contours(frame, own, rival)))


def _differing(frame: ImageFrame, own: Laid, rival: Laid) -> Array:
    """(2,) pixels of all classes, of what faces the camera, or of what has but one marker: in space others may be
    hidden. What is not of a class tells as much as what is, which votes count little, for labels are easily gone."""
    pixels = np.zeros(2)
    if not own.finder.facing and not all(one.finder.surface.is_lone_marker for one in (own, rival)):
        return pixels
    codes, both = own.finder.surface.codes, [_shapes(frame, one) for one in (own, rival)]
    for labels in dict.fromkeys(chain(*both)):
        shown, nowhere = codes.share[:, list(labels)].sum(axis=1), codes.share[:, [OWNED, OUTSIDE]].sum(axis=1)
        worth = np.asarray(2 * shown - 1 + nowhere, np.float32)
        speaks = differing_px(worth, frame, [shapes.get(labels, ()) for shapes in both])
        pixels += speaks[(0, 1), (1, 0)]
    return pixels


def _shapes(frame: ImageFrame, one: Laid) -> dict[tuple[int, ...], list[Array]]:
    """Outlines (n, 2) of all markers, by their classes."""
    surface, out = one.finder.surface, dict[tuple[int, ...], list[Array]]()
    for marker, p in enumerate(surface.markers.tolist()):
        outline = outlines_of(surface, frame, one.pose, marker)[0]
        out.setdefault(surface.patches[p].labels, []).append(outline)
    return out


def _by_contours(frame: ImageFrame, own: Laid, rival: Laid) -> Array:
    """(1,) as of `Evidence`. Who shows fewer markers fits these better without being right: that counts for neither."""
    scatter, points, shown = np.zeros(2), np.zeros(2), np.zeros(2)
    for n, (finder, pose, _) in enumerate((own, rival)):
        used = finder.voter.supports(frame, pose)
        use = finder.surface.sides.with_all(used)
        scatter[n], points[n] = (float(value[0]) for value in scatters(finder, frame, pose, use, np.ones_like(use)))
        shown[n] = used.sum()
    return signed_ratio(scatter[:, None], points[:, None], (shown > shown[::-1])[:, None])

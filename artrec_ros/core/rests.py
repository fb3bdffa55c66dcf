"""What objects leave of the blobs that they share with others."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from .image.blobs import Blob, find_blobs
from .image.codes import OWNED
from .image.label_field import LabelField
from .pose.finder import WholeObjectFinder


class Rests:
    """Of one frame's blobs. A blob of several objects is none of them; what one of them leaves of it may be another."""

    def __init__(self) -> None:
        self._taken: dict[tuple[int, int], float] = {}  # of a finder's blob the share that was owned at the last look
        self._known: set[tuple[int, bytes]] = set()
        self._whole: dict[int, Blob] = {}
        self._kept: list[Blob] = []  # for their ids to stay theirs

    def whole(self, blob: Blob) -> Blob:
        """The blob that a rest, or a whole one, is of."""
        return self._whole.get(id(blob), blob)

    def of(self, field: LabelField, finder: WholeObjectFinder, blob: Blob) -> list[Blob]:
        """What is left of a blob and large enough to be told, each once; none where nobody took some of it since."""
        if not finder.may_be_told(blob, 0):  # nor is a part of it
            return []
        share, key = field.owned_share(blob.contour), (id(finder), id(blob))
        if share <= self._taken.get(key, 0.0):
            return []
        self._taken[key] = share
        out = []
        for rest in _parts(field, finder, blob):
            mark = id(finder), rest.pixels.tobytes()
            if mark not in self._known and finder.may_be_told(rest, _cut_px(field, rest)):
                self._known.add(mark)
                self._whole[id(rest)] = blob
                self._kept.append(rest)
                out.append(rest)
        return out


def _parts(field: LabelField, finder: WholeObjectFinder, blob: Blob) -> list[Blob]:
    corner = np.maximum(blob.pixels.min(axis=0) - 1, 0)  # a pixel around: what ends there is not cut
    (left, top), (right, bottom) = corner.tolist(), (blob.pixels.max(axis=0) + 2).tolist()
    labels = field.labels[top:bottom, left:right]
    inside = np.zeros(labels.shape, np.uint8)
    cv2.fillPoly(inside, [blob.pixels - corner], blob.label)
    rests = find_blobs(inside * (labels == blob.label), [blob.label], finder.config)
    return [replace(r, pixels=r.pixels + corner, contour=r.contour + corner) for r in rests]


def _cut_px(field: LabelField, rest: Blob) -> int:
    """How much of a rest's contour lies along what others own."""
    return int(np.count_nonzero(field.at(rest.contour + rest.normals) == OWNED))

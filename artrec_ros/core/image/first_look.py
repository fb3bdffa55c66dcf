"""What an image shows before anybody asks what that is: the classes of its pixels, and blobs of them.

It depends on the image alone, so that somebody else may look at the next image while objects are still sought in this
one.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..base.deadline import Deadline
from ..base.stopwatch import Stopwatch
from .blobs import Blob, find_blobs
from .label_field import LabelField
from .labeller import Labeller


@dataclass(frozen=True, eq=False)
class FirstLook:
    """One image.

    :param image: as the segmenter read it. :param ms: milliseconds of each stage, and in all.
    :param cut_short: whether the time budget was over before all classes were looked at.
    """

    image: NDArray
    field: LabelField
    blobs: tuple[Blob, ...]
    ms: Mapping[str, float]
    cut_short: bool

    @property
    def took_s(self) -> float:
        return self.ms["total"] / 1e3


def first_look(
    image: NDArray,
    segmenter: Labeller,
    config: RecognizerConfig,
    wanted: Collection[int],
    on_bodies: Collection[int],
) -> FirstLook:
    """Look at an image as the segmenter reads it.

    :param wanted: classes whose blobs are looked for. :param on_bodies: see `LabelField`.
    :raises ImageError: the image does not fit the segmenter's configuration.
    """
    watch, deadline = Stopwatch(), Deadline(config.time_budget_ms / 1e3)
    with watch.stage("segmentation"):
        codes, meaning = segmenter.codes(image), segmenter.meaning
        field = LabelField(codes, config.seams, meaning, segmenter.blank, on_bodies)
        labels = field.labels
    with watch.stage("blobs"):
        blobs = find_blobs(labels, wanted, config, segmenter.blank, deadline)
        if blobs:
            _ = field.padded  # whoever looks at a blob closely asks for it
    return FirstLook(image, field, blobs, watch.stop(), deadline.hit)

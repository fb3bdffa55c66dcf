"""Candidates that an image alone does not tell, for they are not probable enough, as they would be told: an object that
is known from images before may go on in one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..model.found import Detection
from ..pose.finder import WholeObjectFinder
from .descriptions import Describer
from .enough import lack_of
from .judge import Judge
from .offers import Told
from .verdicts import Verdict

_MOST = 3  # are described of each object, the most probable: what an image is full of is clutter


def verdicts_in_doubt(finder: WholeObjectFinder, judge: Judge, told: Told) -> Iterator[Verdict]:
    """Those on one target's candidates that are not told for they are not probable enough."""
    return (v for v in told.shared.others if v.claim.finder is finder and judge.doubts(v))


def doubtful(
    describers: Sequence[Describer], judge: Judge, frame: ImageFrame, blobs: Sequence[Blob], told: Told
) -> Iterator[Detection]:
    """Those of a frame, in which nothing but how probable they are speaks against them.

    :param told: what is told of it. :param blobs: in which what objects lack may be.
    """
    if frame.deadline.expired:
        return
    objects = [v for mine in told.verdicts for v in mine]
    for describer in describers:
        name = describer.finder.target.name
        fallen = (d for d in told.others if d.object == name and judge.is_low(d.there))
        yield from (d for d in fallen if lack_of(d, describer.finder, judge.lenient) is None)
        others = sorted(verdicts_in_doubt(describer.finder, judge, told), key=lambda v: -v.probability)
        for verdict in others[:_MOST]:
            described = describer.describe([verdict], frame, [*objects, verdict], blobs)
            yield from (d for d in described if judge.is_low(d.there))

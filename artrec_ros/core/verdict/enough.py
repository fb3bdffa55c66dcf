"""Which objects are told, by what is told of them: of what is there too little may be sure to tell any of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..image.image_frame import ImageFrame
from ..model.found import Detection
from ..model.frame_result import Rejection
from ..model.objects import ObjectModel
from ..pose.finder import WholeObjectFinder
from .descriptions import Describer
from .judge import NO_DIRECTION, Judge, too_low
from .other_objects import Rival
from .verdicts import Verdict

_OTHER_PLACES = "what is seen of it looks like other parts of it, laid otherwise"
_BY_CHANCE = "chance makes such an object of so many like patches"
_BESIDE_OTHERS = "without what lies beside it, which may be none, it is none"
_NOTHING_TOLD = "none of its components is sure enough to be told"
_NOT_LISTED = "the classes that its components show are those of none of its identities"


def without_surplus(
    describers: Sequence[Describer], accepted: Sequence[Verdict], frame: ImageFrame, judge: Judge
) -> tuple[list[list[Verdict]], list[Verdict], Sequence[Verdict], dict[Verdict, list[Rival]]]:
    """Of each target the objects that are told; those that no identity is left for; all objects but these: what is
    none explains nothing that another one leaves; and which of the latter may be there instead of each of the former.
    """
    shared = [describer.without_surplus(accepted, frame, judge) for describer in describers]
    told, surplus = [mine for mine, _, _ in shared], [v for _, none_left, _ in shared for v in none_left]
    instead = {v: rivals for _, _, of in shared for v, rivals in of.items()}
    return told, surplus, [v for mine in told for v in mine] if surplus else accepted, instead


def enough_of(
    detections: Sequence[Detection], finder: WholeObjectFinder, judge: Judge
) -> tuple[list[Detection], list[Detection], list[Rejection]]:
    """Those of one target that are told, the most probable first; the others; and why they are not."""
    ordered = sorted(detections, key=lambda d: -d.score)
    lacking = [lack_of(d, finder, judge) for d in ordered]
    told = [d for d, lack in zip(ordered, lacking, strict=True) if lack is None]
    others = [(d, lack) for d, lack in zip(ordered, lacking, strict=True) if lack is not None]
    reasons = [Rejection(d.object, lack, d.there, d.image.x, d.image.y) for d, lack in others]
    return [d if d.id == n else replace(d, id=n) for n, d in enumerate(told)], [d for d, _ in others], reasons


def lack_of(d: Detection, finder: WholeObjectFinder, judge: Judge) -> str | None:
    """Why an object is not told; None where it is."""
    if d.there < judge.min_probability:  # one that may be bent otherwise, or turned about what is seen of it, is there
        return too_low(d.there, judge.min_probability, _why_low(d, judge.min_probability))
    model, seen = finder.target.model, {part.component for part in d.components}
    wanted = judge.wanted(len(model.components))
    if len(seen) < wanted:
        return f"{len(seen)} of its components are sure enough to be told, {wanted} are wanted"
    if not seen:
        return _NOTHING_TOLD
    return NO_DIRECTION if finder.facing and model.needs_another and _is_lone_disc(d, model) else None


def _why_low(d: Detection, least: float) -> str:
    """What makes a detection less probable than that."""
    if d.there >= least * d.beyond_others:
        return _BESIDE_OTHERS
    if d.identity is not None and d.identity.listed < 0:
        return _NOT_LISTED
    return _BY_CHANCE if d.there >= least * d.beyond_chance else _OTHER_PLACES


def _is_lone_disc(d: Detection, model: ObjectModel) -> bool:
    """Whether nothing is told but a disc, and not because others have few pixels: all together these tell a turn."""
    seen = {part.component for part in d.components}
    small = any(lack.state == "too small" for lack in d.missing)
    return len(seen) == 1 and not small and all(model.component(name).is_disc for name in seen)

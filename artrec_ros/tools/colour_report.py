"""What `artrec learn-colours` prints: each class' references and what they make of the pixels that were shown."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping
from types import MappingProxyType

import numpy as np

from ..core.base.config import LearningConfig, VotesConfig
from ..core.geometry.transforms import Array
from ..core.learning.colour_counts import speaks
from ..core.learning.colour_learning import Learned
from ..io.learned.marked_objects import BESIDE, REST
from .colour_setup import ColourSetup
from .inspecting.too_small import too_large, too_small
from .taken_regions import MUCH

_UNKNOWN: Mapping[int, float] = MappingProxyType({})
_WORTH_TELLING = 0.01  # share of a class that gets another's label
_WIDER = 1.25  # limits of the scale, over what was marked: that of small patches is found to a tenth, or less
_FEW = 10  # objects: below it their scales tell little of how near and far others are
_BESIDE_PX = LearningConfig.beside_px  # what lies beside markers begins so far off: what reaches less far is none of it
_LEAST_PX = 0.7  # by which outlines are too small before that is told, as of `rings_px`


def report(
    learned: Learned,
    bodies: Collection[str] = (),
    scales: Array | None = None,
    beyond_px: Mapping[int, float] = _UNKNOWN,
) -> Iterator[str]:
    """Per class its references, and what they make of its pixels; what a background's go to, and what to do.

    :param bodies: classes of bodies alone. :param scales: px/m of marked objects, where there are some.
    :param beyond_px: as of `beyond_marks_px`, where that is known.
    """
    width = max(len(name) for name in learned.samples)
    yield f"{'class':{width}}   pixels   right  references r,g,b"
    for name, shares in learned.confusion.items():
        cls = learned.image.classes.get(name)
        if cls is None:
            others = sum(share for other, share in shares.items() if other != "unknown")
            yield f"{name:{width}}  {learned.samples[name]:7d}  {1 - others:6.1%}  (background)"
        else:
            yield f"{name:{width}}  {learned.samples[name]:7d}  {shares.get(name, 0.0):6.1%}  {_colours(cls.rgb)}"
        yield from (f"{'':{width}}    {line}" for line in _taken(name, shares))
    yield f"background: {_colours(learned.image.background) or 'no colour of its own'}"
    yield f"gamma: {learned.image.gamma:g}"
    yield f"blur_px: {learned.image.blur_px:g}"
    yield f"sharpen_px: {learned.image.sharpen_px}"
    yield from _advice(learned)
    yield from _advice_on_strays(learned)
    yield from _advice_on_outlines(learned, scales, beyond_px)
    yield from _advice_on_the_lost(learned, bodies)
    yield from _advice_on_lost_markers(learned)


def scale_limits(scales: Array) -> tuple[float, float]:
    """Least and greatest scale, px/m, that keep out what is smaller or larger than what was marked.

    A few tell little of how near and far objects come. On either side others may go beyond them by their range over
    their number less one, as of any numbers drawn evenly; where they happen to be alike by a factor of two, the less
    the more there are.
    """
    low, high, count = float(scales.min()), float(scales.max()), len(scales)
    beyond = max((high / low) ** (1 / max(count - 1, 1)), 2 ** (1 / count)) if are_few(scales) else 1.0
    return low / (_WIDER * beyond), high * _WIDER * beyond


def are_few(scales: Array) -> bool:
    """Whether limits of the scale rest on so few objects that this should be said."""
    return len(scales) < _FEW


def scale_line(scales: Array) -> str:
    """What the marked objects' scales are, and the limits that they suggest. :param scales: px/m, one or more."""
    low, high = scale_limits(scales)
    count, wider = len(scales), "a quarter wider"
    if are_few(scales):
        wider = f"which rests on {count} object{'s' * (count > 1)} (mark nearer and farther ones); much wider"
    return (
        f"scale: {scales.min():.4g} to {scales.max():.4g} px/m where marked; {wider}, recognizer.min_scale {low:.4g} "
        f"and max_scale {high:.4g} keep out what is smaller or larger"
    )


def size_lines(setup: ColourSetup, scales: Array) -> Iterator[str]:
    """What the marked objects' scales say, and what is too small to be seen at the least one that is given, else at
    that which they suggest. :param scales: px/m, of each marked object."""
    if len(scales):
        yield scale_line(scales)
    least = setup.min_scale or (scale_limits(scales)[0] if len(scales) else 0.0)
    for target in setup.targets:
        yield from (f"warning: {target.name}: {line}" for line in too_small(target.model, least, setup.min_blob_px))
    large = defaultdict[str, list[str]](list)  # several objects may be alike
    for target in setup.targets if len(scales) else ():
        for line in too_large(target.model, float(scales.min())):
            large[line].append(target.name)
    yield from (f"note: {', '.join(names)}: {line}" for line, names in large.items())


def _taken(name: str, shares: Mapping[str, float]) -> Iterator[str]:
    others = [(share, other) for other, share in shares.items() if other not in (name, "unknown")]
    for share, other in sorted(others, reverse=True):
        if share >= _WORTH_TELLING:
            yield f"{share:.1%} of its pixels are taken for {other}"


def _advice(learned: Learned) -> Iterator[str]:
    """A line for each class that takes much of a background."""
    for name, shares in learned.confusion.items():
        if name in learned.image.classes:
            continue
        for other, share in shares.items():
            own_ring = name == BESIDE and learned.rings_px.get(other, 0.0) > _BESIDE_PX + learned.image.blur_px
            if other in learned.image.classes and share >= MUCH and not own_ring:
                why = _why(name, learned.mostly_in.get((name, other)))
                yield (
                    f"{other} takes {share:.0%} of '{name}'. {why}it is too like: choose another colour, or "
                    f"lower image.{other}.spread ({learned.image.classes[other].spread:g})"
                )


def _advice_on_strays(learned: Learned) -> Iterator[str]:
    """A line for each reference that may have come from something else."""
    for stray in learned.strays:
        where = f", most of all in {stray.where}" if stray.where is not None else ""
        yield (
            f"{stray.name}'s reference {_colours(stray.rgb)} has another hue than most of it, {_colours(stray.usual)}, "
            f"and stands for {stray.share:.1%} of its pixels{where}. Where that is not {stray.name}, keep it out: mark "
            "smaller regions, or mark it as one of a category of its own, which is background"
        )


def _advice_on_outlines(learned: Learned, scales: Array | None, beyond_px: Mapping[int, float]) -> Iterator[str]:
    """A line for each class that is larger than what is marked of it, but where the object file has it so large."""
    for name, px in learned.rings_px.items():
        has_px = min(max(beyond_px.get(learned.image.classes[name].label, 0.0), 0.0), px)
        left_px = px - has_px
        if left_px < _LEAST_PX:
            continue
        metres = f" ({left_px / np.median(scales):.2g} m)" if scales is not None and len(scales) else ""
        larger = f" (it has {has_px:.1f} px more than what is marked)" if has_px >= _LEAST_PX else ""
        yield (
            f"{name} goes on for {px:.1f} px beyond its marked outlines, all around, and ends there. Enlarge radius, "
            f"rectangle or outline in the object file by {left_px:.1f} px{metres} on each side{larger}: objects are "
            "found by that. Marks change nothing in it; ends of axes that you mark from now on belong on the rim, as "
            "the camera shows it (docs/object_file.md)"
        )


def _advice_on_the_lost(learned: Learned, bodies: Collection[str]) -> Iterator[str]:
    """A line for each class that would speak for its objects by less than half of what a plain one does."""
    for name in sorted(set(learned.image.classes) & set(learned.confusion)):
        is_body = name in bodies
        shares = learned.confusion[name]
        if not speaks(name, shares, VotesConfig().body if is_body else VotesConfig().inside):
            rest = shares.get("unknown", 0.0)
            remedy = _remedy_of_body(name, shares, rest) if is_body else _remedy(name, shares, rest)
            yield (
                f"{shares.get(name, 0.0):.0%} of the {'body' if is_body else 'marker'}'s class '{name}' is told, too "
                f"little: it speaks for objects by less than half of what it should, or against them. {remedy}"
            )


def _advice_on_lost_markers(learned: Learned) -> Iterator[str]:
    """A line for each marker that is lost though its class, which others show as well, is told."""
    votes = VotesConfig().inside
    for name, markers in learned.markers.items():
        if not speaks(name, learned.confusion[name], votes):
            continue
        for marker, shares in markers.items():
            if not speaks(name, shares, votes):
                yield (
                    f"{marker or 'what is drawn of it'}: {shares.get(name, 0.0):.0%} told as {name}, too little, "
                    f"{learned.confusion[name].get(name, 0.0):.0%} of all that is {name}: it looks different from what "
                    "else has this class. Give it a class of its own, by `label` of the component in the object file "
                    "or of the object in the parameter file, and a name in image.classes; or mark more of it"
                )


def _remedy(name: str, shares: Mapping[str, float], unknown: float) -> str:
    """What helps a marker's class: it is known in the light and by the pixels in which it was marked."""
    others = {other: share for other, share in shares.items() if other not in (name, "unknown")}
    most = max(others, key=lambda other: others[other], default=None)
    if most is None or sum(others.values()) < unknown:
        return (
            "Most of the rest counts as background, or as no colour: grey, dark or glaring pixels. Look whether the "
            "marks lie on it, and well inside its edges; mark it in more light and shade; else choose a colour that "
            "differs more from what is around it"
        )
    return f"{most} takes {others[most]:.0%} of it: mark both in the same light, or choose colours that differ more"


def _remedy_of_body(name: str, shares: Mapping[str, float], unknown: float) -> str:
    """What helps a body's class: one that another class takes is lost around markers, too, without its label."""
    others = {other: share for other, share in shares.items() if other not in (name, "unknown")}
    most = max(others, key=lambda other: others[other], default=None)
    if most is None or sum(others.values()) < unknown:
        return "Leave the label out of the body (docs/object_file.md), or make it as small as what shows it"
    return (
        f"{most} takes {others[most]:.0%} of it: mark {most} well inside its edges, and where other things have its "
        "colour, give --around, so that they do not count as background. Leave the label in the body"
    )


def _why(name: str, where: str | None) -> str:
    """What may be wrong with what nobody has marked; of what somebody has, nothing is, but for one region.

    :param where: the one that most of what is taken lies in.
    """
    if name == BESIDE:
        return (
            "Outlines are lost there: if it belongs to the object, such as a plate that bears the marker, give the "
            "component a body of that size with a class of its own; else "
        )
    if where is not None:
        return f"Most of that lies in {where}: look whether something of its colour is there; else, as marked, "
    if name != REST:
        return "As marked, "
    return (
        "If things of its colour lie there, mark or ignore them; if objects that nobody has marked, mark them or give "
        "--around; else "
    )


def _colours(rgb: tuple[int, ...]) -> str:
    return "; ".join(",".join(map(str, colour)) for colour in np.reshape(rgb, (-1, 3)).astype(int))

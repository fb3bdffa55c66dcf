"""What the image shows of objects at rest: their components, which ones they are, and how else they may lie."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..model.found import IdentityFit
from ..model.kinematics import Frames
from ..pose.finder import WholeObjectFinder
from ..pose.other_layouts import Layouts
from ..pose.poses import Poses
from .acceptance import verdicts_of
from .at_rest import AtRest
from .claims import claims_of
from .identity import Identifier, doubted
from .in_view import Part, Parts
from .parts import part_probabilities
from .verdicts import Verdict

_NO_PART = Part(-1, 0.0)


class Shown(NamedTuple):
    """What the image shows of H objects at rest.

    :ivar frames: where their components are. :ivar parts: what shows each. :ivar told: of that what is told.
    :ivar seen: components told that are seen.
    :ivar shows: in which frame each is looked at. :ivar layouts: how else they may lie; None: not asked.
    :ivar read: what they are by their pixels. :ivar identities: the same as far as they are objects.
    :ivar names: their identities by number.
    """

    frames: Frames
    parts: list[Parts]
    told: list[Parts]
    seen: list[set[int]]
    shows: Sequence[ImageFrame]
    layouts: Layouts | None
    read: Sequence[IdentityFit | None]
    identities: Sequence[IdentityFit | None]
    names: Sequence[int | None]


class ShownObjects:
    """Those of one target."""

    def __init__(self, finder: WholeObjectFinder, identifier: Identifier) -> None:
        self._finder, self._identifier = finder, identifier

    def of(
        self,
        rest: AtRest,
        frame: ImageFrame,
        judged: dict[Verdict, Parts],
        leaves: Callable[[int, Poses], Array] | None = None,
    ) -> Shown:
        """:param judged: as of `_as_judged`. :param leaves: as of `Layouts.around`."""
        finder, verdicts, poses = self._finder, rest.verdicts, rest.poses
        parts = self.parts(rest, frame, judged)
        # what hides part of what faces the camera is not known to be nearer
        shows = [v.claim.frame for v in verdicts] if finder.facing else rest.frames
        seen = self.seen(rest, parts)
        compared = self._identifier.identities or finder.exchanges or self._may_be_others(seen)
        layouts = Layouts.around(finder, frame, poses, shows, seen, leaves) if compared else None
        read, probable = self._identifier.identify(frame, poses, seen, layouts), [v.probability for v in verdicts]
        identities = doubted(read, probable, finder.config.verdict.misread)
        frames, names = finder.surface.kinematics.seen(poses.R, poses.t, poses.q), self._identifier.numbers(identities)
        return Shown(frames, parts, self._told(parts), seen, shows, layouts, read, identities, names)

    def parts(self, rest: AtRest, frame: ImageFrame, judged: dict[Verdict, Parts]) -> list[Parts]:
        """What shows each component, and how probably, as candidates were judged. Of what faces the camera judged at
        rest, too, while there is time, where that lacks some: markers that look larger than they are make a candidate
        that is too large, beside which lies what is at the end of a limb. :param judged: as of `_as_judged`."""
        out = _as_judged(rest.verdicts, judged)
        whole = len(self._finder.target.model.components)
        lacking = [h for h, told in enumerate(self._told(out)) if len(told) < whole] if self._finder.facing else []
        for h in lacking:
            if frame.deadline.expired:
                break
            again = judged_at(rest.poses[h : h + 1], rest.verdicts[h])
            for c, p in part_probabilities([again])[0].items():
                if c != self._finder.root and p > out[h].get(c, _NO_PART).probability:
                    out[h][c] = Part(again.shown[c], p)
        return out

    def seen(self, rest: AtRest, parts: Sequence[Parts]) -> list[set[int]]:
        """The components that are told without a required one that is not confirmed: of that no marker is."""
        root, told = self._finder.root, self._told(parts)
        return [{c for c in of if c != root or v.required_shown} for v, of in zip(rest.verdicts, told, strict=True)]

    def _told(self, parts: Sequence[Parts]) -> list[Parts]:
        """Of those that something shows the components that are told of each."""
        least, root = self._finder.config.min_component_probability, self._finder.root
        return [{c: part for c, part in of.items() if c == root or part.probability >= least} for of in parts]

    def _may_be_others(self, seen: Sequence[set[int]]) -> bool:
        """Whether of some of these the components that are seen lie on like ones of the object laid otherwise."""
        others = self._finder.seen_alike
        return others is not None and (self._finder.on_likes.any or any(len(others.of(of)) for of in seen))


def judged_at(pose: Poses, verdict: Verdict) -> Verdict:
    """One that was judged elsewhere."""
    return verdicts_of(claims_of(verdict.claim.finder, pose, verdict.claim.frame.unhurried()))[0]


def _as_judged(verdicts: Sequence[Verdict], known: dict[Verdict, Parts]) -> list[Parts]:
    """What shows each component of one target's objects, and how probably, as they were judged.

    :param known: of those that were asked for before; the others are added.
    """
    new = [v for v in verdicts if v not in known]
    for v, of in zip(new, part_probabilities(new), strict=True):
        known[v] = {c: Part(v.shown[c], p) for c, p in of.items()}
    return [dict(known[v]) for v in verdicts]

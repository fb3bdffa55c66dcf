"""What is told of accepted spatial objects: fitted poses and how sure they are, joints, components in the image."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np

from ..geometry.transforms import Array, Pose
from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..model.found import Detection, IdentityFit, ImagePose, Instance, Missing
from ..model.kinematics import Frames
from ..pose.along_joints import AlongJoints
from ..pose.finder import WholeObjectFinder
from ..pose.other_layouts import Layouts
from ..pose.other_ways import OtherWays
from ..pose.poses import Poses
from ..pose.siblings import Siblings
from ..pose.surface_kernels import LEAST_DEPTH_M
from .acceptance import verdicts_of
from .at_rest import AtRest, at_rest, candidates
from .chance import Chances, beyond_chance
from .claims import claims_of
from .identity import Identifier, doubted, one_of_these
from .in_view import Part, Parts, PartsInView
from .judge import Judge
from .left_over import LeftOvers, in_doubt_of
from .missing import MissingParts
from .other_places import beside_laid_otherwise, beside_other_places
from .otherwise import as_it_lies, bent_otherwise, otherwise
from .parts import part_probabilities
from .verdicts import Verdict

_NO_PART = Part(-1, 0.0)


class _Looks(NamedTuple):
    """What the image shows of H objects at rest.

    :ivar frames: where their components are. :ivar parts: what shows each. :ivar told: of that what is told.
    :ivar seen: components told that are seen.
    :ivar shows: in which frame each is looked at. :ivar layouts: how else they may lie; None: not asked.
    :ivar names: their identities by number.
    """

    frames: Frames
    parts: list[Parts]
    told: list[Parts]
    seen: list[set[int]]
    shows: Sequence[ImageFrame]
    layouts: Layouts | None
    identities: Sequence[IdentityFit | None]
    names: Sequence[int | None]


class Describer:
    """Describes all of one target's objects in a frame together."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self.finder, self._in_view = finder, PartsInView(finder)
        self._identifier, self._missing, self._judge = Identifier(finder), MissingParts(finder), Judge.of(finder.config)
        self._left_over, self._other_ways = LeftOvers(finder), OtherWays(finder)
        self._along_joints, self._siblings = AlongJoints(finder), Siblings(finder)
        self._chances = Chances(finder) if finder.facing else None

    def without_surplus(
        self, verdicts: Sequence[Verdict], frame: ImageFrame, judge: Judge
    ) -> tuple[list[Verdict], list[Verdict]]:
        """Those of this target that are told, and those that no identity is left for, where each occurs once; without
        identities there is one."""
        mine = [v for v in verdicts if v.claim.finder is self.finder]
        if not self._identifier.may_be_surplus(len(mine)):
            return mine, []
        # by all pixels: what one leaves is easily like another, though both can't be there
        alone = judge.verdicts(self.finder, candidates(mine), frame.unhurried())
        # as they will be told: where a candidate is a little off, its components may lie on others' colours
        rest = at_rest(self.finder, mine, verdicts, frame)
        told = self._told(self._parts(rest.verdicts, rest.poses, frame, {}))
        seen = self._seen(rest.verdicts, told)
        surplus = self._identifier.surplus(frame, rest.poses, seen, alone.probability, alone.claims.votes)
        kept, none_left = (np.flatnonzero(which).tolist() for which in (~surplus, surplus))
        left_out = [alone[i] for i in none_left]  # as they were compared
        if len(kept) == 1 and kept != [0]:  # the first one's pixels are its own again
            return [alone[kept[0]]], left_out
        return [mine[i] for i in kept], left_out

    def describe(
        self,
        verdicts: Sequence[Verdict],
        frame: ImageFrame,
        among: Sequence[Verdict] = (),
        blobs: Sequence[Blob] = (),
    ) -> list[Detection]:
        """Detections, the most probable first.

        :param among: all objects of the frame, other targets' too. :param blobs: in which what they lack may be.
        """
        if not verdicts:
            return []
        judged = dict[Verdict, Parts]()
        verdicts, among, refused = self._right_way_round(verdicts, frame, among, judged)
        verdicts = sorted(verdicts, key=lambda v: -v.probability)
        rest = at_rest(self.finder, verdicts, among, frame)
        anew, first = dict(zip(verdicts, rest.verdicts, strict=True)), self._first_in_their_places(rest)
        among, rest = [anew.get(v, v) for v in among], rest.of(first)
        looks = self._looks(rest, frame, judged)
        detections = self._as_seen(rest, looks, frame, among, blobs)
        detections = self._beside_others(detections, rest, looks, frame, among, blobs)
        if looks.layouts is None:
            return detections
        shares = looks.layouts.as_told(looks.names).tolist()
        lies = zip(detections, shares, [verdicts[n] for n in first], strict=True)
        detections = [as_it_lies(d, share) if v in refused else d for d, share, v in lies]
        return beside_other_places(self.finder, frame.camera, looks.layouts, looks.names, detections)

    def _looks(self, rest: AtRest, frame: ImageFrame, judged: dict[Verdict, Parts]) -> _Looks:
        """:param judged: as of `_as_judged`."""
        finder, verdicts, poses = self.finder, rest.verdicts, rest.poses
        parts = self._parts(verdicts, poses, frame, judged)
        told = self._told(parts)
        # what hides part of what faces the camera is not known to be nearer
        shows = [v.claim.frame for v in verdicts] if finder.facing else rest.frames
        seen = self._seen(verdicts, told)
        compared = self._identifier.identities or self._may_be_others(seen)
        layouts = Layouts.around(finder, frame, poses, shows, seen) if compared else None
        read, probable = self._identifier.identify(frame, poses, seen, layouts), [v.probability for v in verdicts]
        identities = doubted(read, probable, finder.config.verdict.misread)
        frames, names = finder.surface.kinematics.seen(poses.R, poses.t, poses.q), self._identifier.numbers(identities)
        return _Looks(frames, parts, told, seen, shows, layouts, identities, names)

    def _as_seen(
        self, rest: AtRest, looks: _Looks, frame: ImageFrame, among: Sequence[Verdict], blobs: Sequence[Blob]
    ) -> list[Detection]:
        """What the image shows of each, whatever else may be true."""
        finder, verdicts, poses, frames = self.finder, rest.verdicts, rest.poses, looks.frames
        # what faces the camera has a pose on the scene's plane alone
        asked = not finder.facing or frame.scene.plane is not None
        covariances = list(rest.covariances(finder)) if asked else [None] * len(poses)
        shown = looks.layouts.read.shown[: len(poses)] if looks.layouts is not None else ()
        classes = [finder.alternatives.shows(of) for of in shown]
        parts, view = self._in_view.of(verdicts, looks.told, frames, frame, among, classes)
        probable = [{c: part.probability for c, part in of.items()} for of in looks.parts]
        missing = self._missing.of(verdicts, looks.seen, probable, view, frames, frame, among)
        times = [1.0] * len(poses)
        if self._chances is not None:
            times = self._chances.times(verdicts, frame, blobs, among or verdicts).tolist()
        each = enumerate(zip(verdicts, parts, covariances, looks.identities, missing, times, strict=True))
        return [self._detection(verdict, n, poses[n : n + 1], *of) for n, (verdict, *of) in each]

    def _beside_others(
        self,
        detections: Sequence[Detection],
        rest: AtRest,
        looks: _Looks,
        frame: ImageFrame,
        among: Sequence[Verdict],
        blobs: Sequence[Blob],
    ) -> list[Detection]:
        """Detections with what else may be true of them: turns, ways to bend and places, and blobs that they leave."""
        finder, poses = self.finder, rest.poses
        ways = self._other_ways.of(looks.shows, poses, looks.seen, rest.used)
        bends = self._along_joints.of(looks.shows, poses, looks.seen)
        siblings = self._siblings.of(looks.shows, poses, looks.seen, rest.used)
        left_over = self._left_over.of(looks.seen, looks.frames, frame, blobs, among or rest.verdicts)
        out = list[Detection]()
        for n, d in enumerate(detections):
            d = otherwise(d, rest.elsewhere[n], rest.others[n], ways[n])
            d = beside_laid_otherwise(finder, frame.camera, poses[n : n + 1], rest.laid[n], d)
            d = bent_otherwise(bent_otherwise(d, bends[n]), siblings[n])
            out.append(in_doubt_of(finder, d, left_over[n]))
        return out

    def _right_way_round(
        self, verdicts: Sequence[Verdict], frame: ImageFrame, among: Sequence[Verdict], judged: dict[Verdict, Parts]
    ) -> tuple[Sequence[Verdict], Sequence[Verdict], Collection[Verdict]]:
        """The same, judged anew where an object that looks almost the same turned otherwise is likelier so, if it is an
        object so: what all are called together may tell that, too; and those that are none so.

        :param judged: as of `_as_judged`.
        """
        if not self.finder.facing:
            return verdicts, among, ()
        told = self._told(_as_judged(verdicts, judged))
        if not self.finder.exchanges and not self._may_be_others(self._seen(verdicts, told)):
            return verdicts, among, ()
        poses = at_rest(self.finder, verdicts, among, frame).poses
        seen = self._seen(verdicts, self._told(self._parts(verdicts, poses, frame, judged)))
        layouts = Layouts.around(self.finder, frame, poses, [v.claim.frame for v in verdicts], seen)
        names = self._identifier.numbers(self._identifier.identify(frame, poses, seen, layouts))
        poses, changed = layouts.likelier(names)
        turned = {verdicts[h]: self._judged_at(poses[h : h + 1], verdicts[h]) for h in changed.tolist()}
        anew = {v: again for v, again in turned.items() if self._judge.reason(again) is None}
        both = [anew.get(v, v) for v in verdicts], [anew.get(v, v) for v in among]
        return *both, turned.keys() - anew.keys()

    def _judged_at(self, pose: Poses, verdict: Verdict) -> Verdict:
        """One that was judged elsewhere."""
        return verdicts_of(claims_of(self.finder, pose, verdict.claim.frame.unhurried()))[0]

    def _detection(
        self,
        verdict: Verdict,
        number: int,
        pose: Poses,
        parts: tuple[Instance, ...],
        covariance: Array | None,
        identity: IdentityFit | None,
        missing: tuple[Missing, ...],
        times: float,
    ) -> Detection:
        """:param times: how many times as easily as elsewhere chance bears it out."""
        target, kin = self.finder.target, self.finder.surface.kinematics
        root = next(p for p in parts if p.component == target.model.required.name)
        if not verdict.required_shown:
            parts = tuple(p for p in parts if p is not root)
            if parts and self.finder.required.anchors(pose)[0, 2] <= LEAST_DEPTH_M:  # behind the camera it has no place
                root = max(parts, key=lambda part: part.score)
        names = {p.component for p in parts}
        seen = [c for c, component in enumerate(target.model.components) if component.name in names]
        if covariance is None:
            told = [{c, kin.parent[c]} <= {-1, *seen} for c in kin.carried.tolist()]
        else:  # how little is known of one that lacks one of its two components is told beside it
            told = np.atleast_1d(kin.moves[seen].any(axis=0)).tolist()  # joints that move a component that is told
        joints, deviations = [(j, name) for j, name in enumerate(target.model.joint_names) if told[j]], {}
        if covariance is not None:  # within its limits who knows nothing is off by no more
            most = (kin.upper - kin.lower) / np.sqrt(12)
            deviations = {name: float(min(np.sqrt(covariance[6 + j, 6 + j]), most[j])) for j, name in joints}
        score = one_of_these(verdict.probability, identity)
        share = beyond_chance(score, times)
        return Detection(
            target.name,
            number,
            score * share,
            ImagePose(root.x, root.y, root.theta, root.scale),
            tuple(part.rated(part.score * share) for part in parts) if share < 1 else parts,
            Pose(pose.R[0], pose.t[0]),
            {name: float(pose.q[0, j]) for j, name in joints},
            None if covariance is None else covariance[:6, :6].copy(),
            identity=identity,
            joint_deviations=deviations,
            missing=missing,
            beyond_chance=share,
        )

    def _first_in_their_places(self, rest: AtRest) -> list[int]:
        """Rows of those in whose places none before is: what an object leaves of its rim may come to rest on it."""
        if len(rest.poses) == 1:
            return [0]
        turn, first = self.finder.config.search.niche_rad, list[int]()
        same = self.finder.required.is_in_place_of(rest.drawn, rest.poses, turn)
        for n in range(len(rest.poses)):
            if not same[n, first].any():
                first.append(n)
        return first

    def _parts(
        self, verdicts: Sequence[Verdict], poses: Poses, frame: ImageFrame, judged: dict[Verdict, Parts]
    ) -> list[Parts]:
        """What shows each component, and how probably, as candidates were judged. Of what faces the camera judged at
        rest, too, while there is time, where that lacks some: markers that look larger than they are make a candidate
        that is too large, beside which lies what is at the end of a limb. :param judged: as of `_as_judged`."""
        out = _as_judged(verdicts, judged)
        whole = len(self.finder.target.model.components)
        lacking = [h for h, told in enumerate(self._told(out)) if len(told) < whole] if self.finder.facing else []
        for h in lacking:
            if frame.deadline.expired:
                break
            again = self._judged_at(poses[h : h + 1], verdicts[h])
            for c, p in part_probabilities([again])[0].items():
                if c != self.finder.root and p > out[h].get(c, _NO_PART).probability:
                    out[h][c] = Part(again.shown[c], p)
        return out

    def _told(self, parts: Sequence[Parts]) -> list[Parts]:
        """Of those that something shows the components that are told of each."""
        least, root = self.finder.config.min_component_probability, self.finder.root
        return [{c: part for c, part in of.items() if c == root or part.probability >= least} for of in parts]

    def _seen(self, verdicts: Sequence[Verdict], told: Sequence[Parts]) -> list[set[int]]:
        """Of those that are told the components without a required one that is not confirmed: of that no marker is."""
        root = self.finder.root
        return [{c for c in of if c != root or v.required_shown} for v, of in zip(verdicts, told, strict=True)]

    def _may_be_others(self, seen: Sequence[set[int]]) -> bool:
        """Whether of some of these the components that are seen lie on like ones of the object laid otherwise."""
        others = self.finder.seen_alike
        return others is not None and (self.finder.on_likes.any or any(len(others.of(of)) for of in seen))


def _as_judged(verdicts: Sequence[Verdict], known: dict[Verdict, Parts]) -> list[Parts]:
    """What shows each component of one target's objects, and how probably, as they were judged.

    :param known: of those that were asked for before; the others are added.
    """
    new = [v for v in verdicts if v not in known]
    for v, of in zip(new, part_probabilities(new), strict=True):
        known[v] = {c: Part(v.shown[c], p) for c, p in of.items()}
    return [dict(known[v]) for v in verdicts]

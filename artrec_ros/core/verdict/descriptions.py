"""What is told of accepted spatial objects: fitted poses and how sure they are, joints, components in the image."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import NamedTuple

import numpy as np

from ..geometry.transforms import Array, Pose
from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..model.found import Detection, IdentityFit, ImagePose, Instance, Missing
from ..pose.along_joints import doubts_along
from ..pose.finder import WholeObjectFinder
from ..pose.other_ways import OtherWays
from ..pose.poses import Poses
from ..pose.siblings import Siblings
from ..pose.surface_kernels import LEAST_DEPTH_M
from .at_rest import AtRest, at_rest, candidates
from .chance import Chances, beyond_chance
from .identity import Identifier, one_of_these
from .in_view import Parts, PartsInView
from .judge import Judge
from .left_over import LeftOvers, in_doubt_of
from .missing import MissingParts
from .other_blobs import OnOthers, OtherBlobs
from .other_objects import Rival
from .other_places import beside_laid_otherwise, beside_other_places
from .otherwise import as_it_lies, bent_otherwise, on_other_blobs, otherwise
from .readings import Readings
from .shown import Shown, ShownObjects, judged_at
from .verdicts import Verdict


class Described(NamedTuple):
    """What is told of some objects, the most probable first; and where to go on from in the next frame: verdicts on all
    of them as they were found, or as they are told where what is followed would not come from the one to the other."""

    detections: Sequence[Detection]
    verdicts: Sequence[Verdict]


class Describer:
    """Describes all of one target's objects in a frame together."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self.finder, self._in_view = finder, PartsInView(finder)
        self._identifier, self._missing, self._judge = Identifier(finder), MissingParts(finder), Judge.of(finder.config)
        if finder.facing:  # how many of its components are told is asked of what is described
            self._judge = self._judge.seeking
        self._left_over, self._other_ways = LeftOvers(finder), OtherWays(finder)
        self._siblings, self._other_blobs = Siblings(finder), OtherBlobs(finder)
        self._shown = ShownObjects(finder, self._identifier)
        self._chances = Chances(finder) if finder.facing else None
        self.readings = None if self._chances is None else Readings(finder, self._judge, self._chances)

    def without_surplus(
        self, verdicts: Sequence[Verdict], frame: ImageFrame, judge: Judge
    ) -> tuple[list[Verdict], list[Verdict], dict[Verdict, list[Rival]]]:
        """Those of this target that are told, and those that no identity is left for, where each occurs once; without
        identities there is one; and which of the latter may be there instead of each of the former."""
        mine = [v for v in verdicts if v.claim.finder is self.finder]
        if not self._identifier.may_be_surplus(len(mine)):
            return mine, [], {}
        # by all pixels: what one leaves is easily like another, though both can't be there
        alone = judge.verdicts(self.finder, candidates(mine), frame.unhurried())
        # as they will be told: where a candidate is a little off, its components may lie on others' colours
        rest = at_rest(self.finder, mine, verdicts, frame)
        seen = self._shown.seen(rest, self._shown.parts(rest, frame, {}))
        probable = np.array([v.alone for v in mine])  # be it with markers that look larger
        surplus, odds = self._identifier.surplus(frame, rest.poses, seen, probable, alone.claims.votes)
        kept, none_left = (np.flatnonzero(which).tolist() for which in (~surplus, surplus))
        left_out = {j: alone[j] for j in none_left}  # as they were compared
        rivals = {
            i: [Rival(self.finder, odds[i, j], v, rest.poses[j : j + 1]) for j, v in left_out.items()] for i in kept
        }
        # of one alone, be it not the first one, the first one's pixels are its own
        told = {i: alone[i] if kept == [i] and i else mine[i] for i in kept}
        return list(told.values()), list(left_out.values()), {told[i]: rivals[i] for i in kept}

    def describe(
        self,
        verdicts: Sequence[Verdict],
        frame: ImageFrame,
        among: Sequence[Verdict] = (),
        blobs: Sequence[Blob] = (),
    ) -> list[Detection]:
        """The detections of `described`."""
        return list(self.described(verdicts, frame, among, blobs).detections)

    def described(
        self,
        verdicts: Sequence[Verdict],
        frame: ImageFrame,
        among: Sequence[Verdict] = (),
        blobs: Sequence[Blob] = (),
        known: Poses | None = None,
    ) -> Described:
        """:param among: all objects of the frame, other targets' too. :param blobs: in which what they lack may be.
        :param known: where earlier frames have this target's objects."""
        if not verdicts:
            return Described((), ())
        judged = dict[Verdict, Parts]()
        verdicts = _probable_first(verdicts)
        rest = at_rest(self.finder, verdicts, among, frame)
        shown = self._shown.of(rest, frame, judged, self._leaves(rest, among, frame, blobs))
        on_others = self._on_others(rest, shown, frame, among, blobs)
        turned, refused = self._turned(rest, shown)
        turned |= (moved := self._moved(rest, on_others, known, frame))
        if turned:
            verdicts, among = _probable_first([turned.get(v, v) for v in verdicts]), [turned.get(v, v) for v in among]
            rest = at_rest(self.finder, verdicts, among, frame)
        anew, first = dict(zip(verdicts, rest.verdicts, strict=True)), self._first_in_their_places(rest)
        among = [anew.get(v, v) for v in among]
        found = {again: v for v, again in turned.items() if v not in moved}
        go_on = [v if v in moved.values() else self._goes_on(found.get(v, v), again) for v, again in anew.items()]
        if turned or len(first) < len(verdicts):
            rest = rest.of(first)
            shown = self._shown.of(rest, frame, judged, self._leaves(rest, among, frame, blobs))
            on_others = self._on_others(rest, shown, frame, among, blobs)
        detections = self._as_seen(rest, shown, frame, among, blobs)
        detections = self._beside_others(detections, rest, shown, frame, among, blobs, on_others)
        if shown.layouts is None:
            return Described(detections, go_on)
        layouts, kept = shown.layouts, [verdicts[n] in refused for n in first]
        shares = np.where(kept, layouts.as_told(shown.names), layouts.as_told_unnamed(shown.names)).tolist()
        detections = [as_it_lies(d, share) for d, share in zip(detections, shares, strict=True)]
        detections = beside_other_places(self.finder, frame, layouts, shown.names, detections)
        return Described(detections, go_on)

    def _leaves(
        self, rest: AtRest, among: Sequence[Verdict], frame: ImageFrame, blobs: Sequence[Blob]
    ) -> Callable[[int, Poses], Array] | None:
        """Log odds of other poses of each object by what they leave to clutter."""
        readings = self.readings
        left = None if readings is None else readings.free(among or rest.verdicts, frame, blobs)
        if readings is None or left is None:
            return None
        return lambda h, poses: readings.log_odds(rest.verdicts[h], poses, left)

    def _goes_on(self, found: Verdict, told: Verdict) -> Verdict:
        """From which of an object's poses the next frame goes on. Mirrored turns are followed beside what was found."""
        finder, at = self.finder, found.claim.poses
        if told is not found and finder.joint_steps.stepped(at, told.claim.poses):
            return told
        ways = finder.in_place, finder.like_sides, finder.taken_back or ()
        if told is found or finder.facing or not any(map(len, ways)):
            return found
        reached = Poses.concatenate([at, finder.required.flips(at)])
        return told if finder.strayed(told.claim.poses, reached) >= 1 else found

    def _as_seen(
        self, rest: AtRest, shown: Shown, frame: ImageFrame, among: Sequence[Verdict], blobs: Sequence[Blob]
    ) -> list[Detection]:
        """What the image shows of each, whatever else may be true."""
        finder, verdicts, poses, frames = self.finder, rest.verdicts, rest.poses, shown.frames
        # what faces the camera has a pose on the scene's plane alone
        asked = not finder.facing or frame.scene.plane is not None
        covariances = list(rest.covariances(finder)) if asked else [None] * len(poses)
        best = shown.layouts.read.shown[: len(poses)] if shown.layouts is not None else ()
        classes = [finder.alternatives.shows(of) for of in best]
        parts, view = self._in_view.of(verdicts, shown.told, frames, frame, among, classes)
        probable = [{c: part.probability for c, part in of.items()} for of in shown.parts]
        missing = self._missing.of(verdicts, shown.seen, probable, view, frames, frame, among)
        times = [1.0] * len(poses)
        if self._chances is not None:
            times = self._chances.times(verdicts, frame, blobs, among or verdicts).tolist()
        each = enumerate(zip(verdicts, parts, covariances, shown.identities, missing, times, strict=True))
        return [self._detection(verdict, n, poses[n : n + 1], *of) for n, (verdict, *of) in each]

    def _beside_others(
        self,
        detections: Sequence[Detection],
        rest: AtRest,
        shown: Shown,
        frame: ImageFrame,
        among: Sequence[Verdict],
        blobs: Sequence[Blob],
        on_others: Sequence[OnOthers | None],
    ) -> list[Detection]:
        """Detections with what else may be true of them: turns, ways to bend and places, and blobs that they leave."""
        finder, poses = self.finder, rest.poses
        ways = self._other_ways.of(shown.shows, poses, shown.seen, rest.used)
        siblings = self._siblings.of(shown.shows, poses, shown.seen, rest.used)
        left_over = self._left_over.of(shown.seen, shown.frames, frame, blobs, among or rest.verdicts)
        out = list[Detection]()
        for n, d in enumerate(detections):
            d = otherwise(d, rest.elsewhere[n], rest.others[n], ways[n])
            d = beside_laid_otherwise(finder, frame, poses[n : n + 1], rest.laid[n], d)
            d = bent_otherwise(d, doubts_along(finder, poses[n : n + 1], rest.along[n]))
            d = bent_otherwise(d, siblings[n])
            d = on_other_blobs(finder, on_others[n], poses[n : n + 1], frame.camera, d)
            left = self._left_over.beside_steps(left_over[n], poses[n : n + 1], shown.seen[n], frame.camera, blobs)
            out.append(in_doubt_of(finder, d, left))
        return out

    def _on_others(
        self, rest: AtRest, shown: Shown, frame: ImageFrame, among: Sequence[Verdict], blobs: Sequence[Blob]
    ) -> list[OnOthers | None]:
        lie = shown.frames, frame, blobs, among or rest.verdicts
        return self._other_blobs.of(shown.shows, rest.poses, shown.seen, rest.used, *lie)

    def _moved(
        self, rest: AtRest, on_others: Sequence[OnOthers | None], known: Poses | None, frame: ImageFrame
    ) -> dict[Verdict, Verdict]:
        """Those of which something is to be told on another blob, judged anew, as far as they are objects so."""
        out, known = dict[Verdict, Verdict](), self.finder.surface.no_poses if known is None else known
        for n, verdict in enumerate(rest.verdicts):
            other = self._other_blobs.likelier(on_others[n], rest.poses[n : n + 1], known, frame.camera)
            again = None if other is None else judged_at(other, verdict)
            if again is not None and self._judge.reason(again) is None:
                out[verdict] = again
        return out

    def _turned(self, rest: AtRest, shown: Shown) -> tuple[dict[Verdict, Verdict], Collection[Verdict]]:
        """Of objects that face the camera those that are likelier turned so that they look almost the same, judged
        anew, as far as they are objects so: what all are called together may tell that, too; and those that are none
        so."""
        if not self.finder.facing or shown.layouts is None:
            return {}, ()
        poses, changed = shown.layouts.likelier(self._identifier.numbers(shown.read))
        turned = {rest.verdicts[h]: judged_at(poses[h : h + 1], rest.verdicts[h]) for h in changed.tolist()}
        anew = {v: again for v, again in turned.items() if self._judge.reason(again) is None}
        return anew, turned.keys() - anew.keys()

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
        """Rows of those in whose places none before is, be they turned onto themselves: what an object leaves of its
        rim, or of its length, may come to rest on it; what faces the camera may be told with its ends elsewhere."""
        h, first = len(rest.poses), list[int]()
        if h == 1:
            return [0]
        every = Poses.concatenate([rest.drawn, self.finder.in_place.of(rest.drawn)])
        told = rest.drawn if self.finder.facing else rest.poses
        there = self.finder.required.is_in_place_of(every, told, self.finder.config.search.niche_rad)
        same = there[:h] | there[h:].reshape(h, len(self.finder.in_place), h).any(axis=1)
        for n in range(h):
            if not same[n, first].any():
                first.append(n)
        return first


def _probable_first(verdicts: Sequence[Verdict]) -> list[Verdict]:
    return sorted(verdicts, key=lambda v: -v.probability)

"""Find whole spatial objects: pose and joints at once, judged by every pixel of their markers and bodies.

The paper's phase 1 finds the required component, phase 2 the others. Here the required component's pose in
space comes first, and another component must sit where its joint can carry it: a curve in place of a box.
What is found is refined on all contours together, and judged with the parts that hide each other.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import cached_property

import numpy as np

from ..base.config import RecognizerConfig
from ..image.blobs import Blob
from ..image.codes import LABELS, Codes
from ..image.image_frame import ImageFrame
from ..model.target import Target
from .alternatives import Alternatives
from .apart import Apart
from .at_scale import AtScale
from .bending import Bending
from .climber import Climb, Climber
from .distinct import apart
from .exchanges import Exchanges
from .hidden_ends import HiddenEnds
from .joint_steps import JointSteps
from .laid_alike import LaidAlike
from .like_sides import LikeSides
from .lookalikes import Lookalikes
from .on_likes import OnLikes
from .other_ends import OtherEnds
from .other_joints import OtherJoints
from .poses import Poses
from .ranked import Ranked
from .refit import Refit
from .required_place import RequiredPlace
from .resting import Resting
from .seeds import Seeds
from .seen_alike import SeenAlike
from .stand_ins import StandIns
from .surface_model import SpatialModel
from .taken_back import TakenBack
from .through_middles import ThroughMiddles
from .tilts import Tilts
from .upright import Upright
from .voter import Voter

_MOST_MOVES = 4  # from lookalike to lookalike: enough to cross rows of a dozen


class WholeObjectFinder:
    """Hypotheses of one target in a frame."""

    def __init__(
        self,
        target: Target,
        config: RecognizerConfig,
        codes: Codes = LABELS,
        *,
        facing: bool = False,
    ) -> None:
        """:param codes: what pixels' codes say of their labels.
        :param facing: the object faces the camera: it turns about the optical axis alone.
        """
        self.facing = facing
        self.target, self.config, self._search = target, config, config.search
        self.surface = _surface_of(target, config, codes, facing=facing)
        self.root, self.root_labels = self.surface.root, target.root_labels
        self._equip()
        self.alternatives = Alternatives(self.surface, config.verdict)
        self.required = RequiredPlace(target.model, self.surface)
        self.upright = Upright(self.required)
        self.hidden_ends = None if facing else HiddenEnds(self.surface, self.voter, self.rest, self.required, config)
        self.other_ends = OtherEnds(self.surface, self.voter, self.climber, config) if facing else None
        self.last_climb = Climb.last(config, facing=facing)
        self._bend()
        self._lay_otherwise()
        # what faces the camera is guessed from the front alone, elsewhere: views from all sides take long to make
        self._seeds = None if facing else Seeds(target, self.surface, config, self._lookalikes)
        # classes of whose blobs an object is guessed
        self.seed_labels = self._seeds.labels if self._seeds else set(self.root_labels)

    def _bend(self) -> None:
        """What seeks joints."""
        search, kin = self._search, self.surface.kinematics
        self.first_grids, self._grids = kin.grids(search.first_joint_step), kin.grids(search.joint_step)
        fine, plain = kin.grids(search.fine_joint_step), float(self.config.votes.inside[0])
        self.stand_ins = StandIns(self.surface, fine, self.config.verdict.stand_in)
        step, most, near = search.fine_joint_step, search.other_joints, 1 - search.near_joints
        self.other_joints = OtherJoints(self.surface, self.voter.value, step, most, plain, near)
        self.bending = Bending(self)

    def _lay_otherwise(self) -> None:
        """What knows the poses in which the object looks much like itself."""
        surface, facing = self.surface, self.facing
        self._lookalikes, self.like_sides = Lookalikes(surface), LikeSides(surface)
        self.in_place = Lookalikes(surface, in_place=True, unlike=not facing)
        self.on_likes, self.joint_steps = OnLikes(self, self._lookalikes), JointSteps(surface)
        self.exchanges = Exchanges(surface) if facing else None
        self.seen_alike = SeenAlike(surface) if facing else None
        self.laid_alike = None if facing else LaidAlike(surface)
        self.tilts = None if facing else Tilts(surface, self.required)
        self.taken_back = None if facing else TakenBack(surface)

    @cached_property
    def swollen(self) -> tuple[WholeObjectFinder, ...]:
        """The same with markers that look larger than they are, by half of `facing.swollen_px` and by all of it, for
        votes, joints and fits to the contours; the rest takes them as they are. None where that is nothing, and where
        markers adjoin each other: together they tell how large they are."""
        most = self.config.facing.swollen_px
        apart = bool(self.surface.open_contour.all())
        return tuple(self._swollen(share * most) for share in (0.5, 1.0)) if most and apart else ()

    def _swollen(self, by_px: float) -> WholeObjectFinder:
        twin = copy(self)
        twin.surface = self.surface.swollen(by_px)
        twin._equip()
        return twin

    def _equip(self) -> None:
        """What judges and moves hypotheses of this surface."""
        self.voter = Voter(self.surface, self.config)
        self.climber = Climber(self.voter, self.config, facing=self.facing)
        self.refit = Refit(self.surface, self.voter.value, self.config, facing=self.facing)
        self.rest = Resting(self.voter, self.climber, self.config, facing=self.facing)
        self.at_scale = AtScale(self.voter, self.config) if self.facing else None

    @cached_property
    def apart(self) -> Apart:
        """How far apart its components can be."""
        return Apart(self.surface, self.config)

    @cached_property
    def through_middles(self) -> ThroughMiddles:
        """Poses that have components where blobs are."""
        return ThroughMiddles(self.surface, self.config, facing=self.facing)

    @property
    def is_alike_throughout(self) -> bool:
        """Whether the blob of any component leads to the object: a rigid one with components that look the same."""
        components = range(len(self.target.model.components))
        return len(components) > 1 and all(self._lookalikes.leads_to(c) for c in components)

    @property
    def is_plain(self) -> bool:
        """Whether a few guesses may be enough. Where sides meet, amid what looks like one of them there may be another:
        one that holds part of a blob is as good as one that holds all of it until all are compared."""
        return self._seeds is not None and not self._seeds.has_solids

    def warm_up(self, frame: ImageFrame, poses: Poses) -> None:
        """Have the compiled code that counts votes and climbs on them ready, by a step from some poses."""
        self.voter.total(self.voter.judge(frame, poses, occlusion=True))
        found = self.ranked(frame, poses)
        self.climber.climb(frame, self.climber.sweep(frame, found), Climb(1, 1, 1.0))

    def plain_guesses(self, frame: ImageFrame, blob: Blob) -> Ranked:
        """A few of an object in plain view whose required component made a blob; none where there can be no such."""
        assert self._seeds is not None  # nobody asks of what faces the camera
        return self.with_joints(frame, self._seeds.few(frame, blob))

    def guesses(self, frame: ImageFrame, blob: Blob, piece: int = 0) -> Ranked:
        """Hypotheses of which any component made a blob, or part of it. :param piece: see `scale_range`."""
        assert self._seeds is not None
        return self.with_joints(frame, self._seeds.all(frame, blob, piece))

    def may_belong(self, limb: Blob, root: Blob) -> bool:
        """See `Seeds.may_belong`."""
        return self._seeds is not None and self._seeds.may_belong(limb, root)

    def may_be_told(self, rest: Blob, cut_px: int) -> bool:
        """Whether what others leave of a blob tells something of its marker's shape, beside what a rim of theirs takes.

        :param cut_px: length of the contour along theirs.
        """
        return rest.area_px - self.surface.votes.ring_px * cut_px >= self.config.guesses.small_px

    def may_be_several(self, blob: Blob) -> bool:
        """See `Seeds.may_be_several`."""
        return self._seeds is not None and self._seeds.may_be_several(blob)

    def climbed(self, frame: ImageFrame, found: Ranked, climb: Climb, *, sure: bool) -> Ranked:
        """The best, or of a sure object it and its rivals, after a climb on the votes and a fit to the contours."""
        search, keep = self._search, np.flatnonzero(found.votes > 0)
        if sure:
            keep = apart(found.poses, found.votes, search.rival * found.votes[0], search.niche_rad, search.niche_range)
        found = found[keep[: climb.most]]
        found = self._with_bent(frame, found).best(climb.most, search)
        found = self._with_rival_flips(frame, self.climber.sweep(frame, found))
        found = self.climber.climb(frame, found, climb)
        found = self._with_lookalikes(frame, self.fit_all(frame, found.poses).best(len(found), search))
        return self._with_upright(frame, found, climb)

    def _with_upright(self, frame: ImageFrame, found: Ranked, climb: Climb) -> Ranked:
        """Where none stands on the scene's floor, add them turned upright, after a climb and a fit of their own: as
        they are all are refused."""
        if frame.deadline.expired or frame.scene.stand(found.poses.R, found.poses.t).any():
            return found
        upright = self.upright.of(frame, found.poses)
        again = self.polished(frame, self.ranked(frame, upright), climb) if len(upright) else found[:0]
        return found + again[np.flatnonzero(frame.scene.stand(again.poses.R, again.poses.t))]

    def followed(self, frame: ImageFrame, expected: Poses, votes: float, left: float, climb: Climb) -> Ranked:
        """Where an object is that is expected near some poses, and its mirrored turns, best first.

        :param votes: that it had. :param left: share of them without which a first fit is not worth more.
        """
        search = self._search
        found = self.fit_all(frame, expected).best(1, search)
        if found.votes[0] < left * votes:
            return found[:0]
        found = self._with_bent(frame, found)
        found = self.climber.climb(frame, self.climber.sweep(frame, found.best(1, search)), climb)
        found = self.fit_all(frame, found.poses).best(1, search)
        if found.votes[0] < search.near_joints * votes:  # else its joints are no worse than they were
            found = self.rejointed(frame, found, climb)
        return self._with_rival_flips(frame, found).best(search.flip_keep, search)

    def ranked(self, frame: ImageFrame, poses: Poses) -> Ranked:
        """Hypotheses and their votes."""
        return Ranked(poses, self.voter.votes(frame, poses, occlusion=True))

    def rejointed(self, frame: ImageFrame, best: Ranked, climb: Climb) -> Ranked:
        """One hypothesis with a joint elsewhere, after a fit and a climb, and then the next, while that is better."""
        for _ in range(self.surface.kinematics.n_joints):
            if frame.deadline.expired:
                break
            others = self.other_joints.of(frame, best.poses, float(best.votes[0]))
            found = self.fit_all(frame, others.poses).best(1, self._search) if len(others) else best[:0]
            found = found[found.votes > self._search.near_joints * best.votes[0]]
            if len(found) and found.votes[0] <= best.votes[0]:
                found = self.fit_all(frame, self.climber.climb(frame, found, climb).poses).best(1, self._search)
            if not len(found) or found.votes[0] <= best.votes[0]:
                break
            best = found
        return best

    def _with_bent(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """Add the same with joints sought anew: a better pose may show a limb that a worse one missed."""
        return found + self.ranked(frame, self.surface.search_joints(frame, found.poses, self._grids))

    def moved(self, frame: ImageFrame, found: Ranked, climb: Climb) -> Ranked:
        """Hypotheses after a climb on the votes."""
        return self.climber.climb(frame, self.climber.sweep(frame, found), climb)

    def polished(self, frame: ImageFrame, found: Ranked, climb: Climb) -> Ranked:
        """Hypotheses after a climb on the votes, and a fit to the contours."""
        return self.fit_all(frame, self.moved(frame, found, climb).poses)

    def with_joints(self, frame: ImageFrame, poses: Poses) -> Ranked:
        """The best with the joints at which the labels like the other components best, fitted to all contours."""
        search = self._search
        poses = self.standing(frame, poses)
        poses = self.surface.search_joints(frame, poses, self.first_grids)
        found = Ranked(poses, self.voter.votes(frame, poses, occlusion=False)).best(search.joint_keep, search)
        poses = Poses.concatenate([found.poses, self.flips(found)])
        poses = self.standing(frame, poses)
        found = self.fit_all(frame, poses).best(search.fit_keep, search)
        return self._with_lookalikes(frame, found)

    def standing(self, frame: ImageFrame, poses: Poses) -> Poses:
        """Those that stand on the scene's floor, about."""
        stand = frame.scene.may_stand(poses.R, poses.t, self.config.guesses.standing_slack)
        return poses if stand.all() else poses[np.flatnonzero(stand)]

    def _with_lookalikes(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """Add those of the best one's lookalikes that come near to it, and theirs in turn while they are better."""
        search, ways = self._search, len(self._lookalikes) + len(self.like_sides)
        for _ in range(_MOST_MOVES * (len(found) > 0 and ways > 0)):
            best = found.poses[:1]
            poses = self.standing(frame, Poses.concatenate([self._lookalikes.of(best), self.like_sides.of(best).poses]))
            poses = self.surface.search_joints(frame, poses, self.first_grids)
            others = self.ranked(frame, poses).best(search.flip_keep, search)
            others = others[others.votes > search.rival * found.votes[0]]
            if not len(others):
                break
            best, others = found.votes[0], self.fit_all(frame, others.poses)
            found = (found + others).best(search.fit_keep, search)
            if found.votes[0] <= best:
                break
        return found

    def looked_again(self, frame: ImageFrame, begun: Poses) -> Ranked:
        """What a second look at an object makes of poses: fits to the contours before and after a climb."""
        poses = self.climber.within_limits(frame.camera, begun)
        return self.polished(frame, self.fit_all(frame, poses), self.last_climb)

    def _with_rival_flips(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """Add the best one's siblings that come near to it."""
        flips = self.flips(found[:1])
        if not len(flips):
            return found
        fitted = self.fit_all(frame, flips).best(self._search.flip_keep, self._search)
        return found + fitted[fitted.votes > self._search.rival * found.votes[0]]

    def strayed(self, poses: Poses, expected: Poses) -> float:
        """How far the first hypothesis is from the nearest of some others: 1 where no climb would lead to it."""
        niche, near = self._search, poses[:1]
        off = np.linalg.norm(expected.t - near.t, axis=1) / (niche.niche_range * float(np.linalg.norm(near.t)))
        cosine = (np.einsum("kij,ij->k", expected.R, near.R[0]) - 1) / 2
        return float(np.maximum(off, np.arccos(np.minimum(np.maximum(cosine, -1), 1)) / niche.niche_rad).min())

    def flips(self, found: Ranked) -> Poses:
        """Siblings of the best."""
        return self.required.flips(found.best(self._search.flip_keep, self._search).poses)

    def gone_on(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """With fits of those beyond whose contours their class goes on: see `GoingOn`."""
        farther = self.rest.gone_on(frame, found.poses)
        return found + self.fit_all(frame, farther) if len(farther) else found

    def fit_all(self, frame: ImageFrame, poses: Poses) -> Ranked:
        """Hypotheses and their fits to the contours of all markers that the labels support, with votes; beside those
        that lean too much for the scene's floor, the same turned upright."""
        fitted = self.refit.of(frame, poses, self.climber.depths(frame.camera))
        upright = self.upright.of(frame, fitted.poses)
        return fitted + self.ranked(frame, upright) if len(upright) else fitted


def _surface_of(target: Target, config: RecognizerConfig, codes: Codes, *, facing: bool) -> SpatialModel:
    """What shows of a target, and what its pixels count."""
    votes = config.votes
    if facing and codes is not LABELS:
        colour = config.facing
        votes = replace(votes, ring_px=colour.colour_ring_px, inside_empty=colour.colour_inside_empty)
    surface = SpatialModel(target.model, target.label, votes, codes)
    if facing:  # it is judged by as few points as its curves were fitted with
        level = surface.is_level and not surface.is_lone_marker  # which may be seen at a slant
        surface.limits = surface.limits._replace(point_px=np.inf, level=level)
    return surface

"""Find whole spatial objects: pose and joints at once, judged by every pixel of their markers and bodies.

The paper's phase 1 finds the required component, phase 2 the others. Here the required component's pose in
space comes first, and another component must sit where its joint can carry it: a curve in place of a box.
What is found is refined on all contours together, and judged with the parts that hide each other.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..base.config import RecognizerConfig, SearchConfig
from ..geometry.camera import Camera
from ..geometry.range_limits import scale_limits
from ..geometry.transforms import Array
from ..image.blobs import Blob
from ..image.codes import LABELS, Codes
from ..image.image_frame import ImageFrame
from ..model.target import Target
from . import climb_kernels as climbing
from .alternatives import Alternatives
from .climb_kernels import Steps, Value
from .colour_fit import ColourFit
from .distinct import apart
from .lookalikes import Lookalikes
from .other_joints import OtherJoints
from .pose_fit import ContourFit, contour_fit, fit_poses
from .ranked import Ranked
from .rebends import Rebends
from .refit import Refit
from .region_fit import RegionFit
from .required_place import RequiredPlace
from .seeds import Seeds
from .stand_ins import StandIns
from .surface_model import PatchScores, Poses, SpatialModel

_MOST_MOVES = 4  # from lookalike to lookalike: enough to cross rows of a dozen
_AT_ONCE = 32  # hypotheses of what faces the camera that climb between two looks at the clock; of others one


class Climb(NamedTuple):
    """A climb on the votes: of at most so many hypotheses, so many rounds, the first steps in units of `climbing`."""

    most: int
    rounds: int
    first_step: float


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
        votes = config.votes
        if facing and codes is not LABELS:
            votes = replace(votes, ring_px=config.facing.colour_ring_px)
        self.surface = SpatialModel(target.model, target.label, votes, codes)
        if facing:  # it is judged by as few points as its curves were fitted with
            self.surface.limits = self.surface.limits._replace(point_px=np.inf)
        self.root = self.surface.root
        self.root_labels = self.surface.labels[self.root]
        self._value = Value(len(target.model.components), self.root, float(config.votes.hidden_cost), occlusion=True)
        self._steps = _steps(config.search)
        self.refit = Refit(self.surface, self._value, config, facing=facing)
        self.alternatives = Alternatives(self.surface, config.verdict)
        self.required = RequiredPlace(target.model, self.surface)
        self._lookalikes = Lookalikes(self.surface)
        kin = self.surface.kinematics
        self.first_grids, self._grids = kin.grids(self._search.first_joint_step), kin.grids(self._search.joint_step)
        fine = kin.grids(self._search.fine_joint_step)
        self.stand_ins = StandIns(self.surface, fine, config.verdict.stand_in)
        self._rebends = Rebends(self.surface, self._search, self._value.hidden_cost)
        step, most, plain = self._search.fine_joint_step, self._search.other_joints, float(config.votes.inside[0])
        self._other_joints = OtherJoints(self.surface, self._value, step, most, plain, 1 - self._search.near_joints)
        self.regions = RegionFit(self.surface, config) if facing else None
        self._to_colours = self.regions or ColourFit(self.surface, config)
        # what faces the camera is guessed from the front alone, elsewhere: views from all sides take long to make
        self._seeds = None if facing else Seeds(target, self.surface, config, self._lookalikes)
        # classes of whose blobs an object is guessed
        self.seed_labels = self._seeds.labels if self._seeds else set(self.root_labels)

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
        twin.refit = Refit(twin.surface, self._value, self.config, facing=self.facing)
        return twin

    @property
    def is_alike_throughout(self) -> bool:
        """Whether the blob of any component leads to the object: a rigid one with components that look the same."""
        components = range(len(self.target.model.components))
        return len(components) > 1 and all(self._lookalikes.leads_to(c) for c in components)

    def warm_up(self, frame: ImageFrame, poses: Poses) -> None:
        """Have the compiled code that counts votes and climbs on them ready, by a step from some poses."""
        self.total(self.judge(frame, poses, occlusion=True))
        found = Ranked(poses, self.votes(frame, poses, occlusion=True))
        self._climb(frame, self._sweep(frame, found), Climb(1, 1, 1.0))

    def plain_guesses(self, frame: ImageFrame, blob: Blob) -> Ranked:
        """A few of an object in plain view whose required component made a blob; none where there can be no such."""
        assert self._seeds is not None  # nobody asks of what faces the camera
        return self._with_joints(frame, self._seeds.few(frame, blob))

    def guesses(self, frame: ImageFrame, blob: Blob, piece: int = 0) -> Ranked:
        """Hypotheses of which any component made a blob, or part of it. :param piece: see `scale_range`."""
        assert self._seeds is not None
        return self._with_joints(frame, self._seeds.all(frame, blob, piece))

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
            keep = apart(found.poses, found.votes, search.rival * found.votes[0], search)
        found = found[keep[: climb.most]]
        found = self._with_bent(frame, found).best(climb.most, search)
        found = self._with_rival_flips(frame, self._sweep(frame, found))
        found = self._climb(frame, found, climb)
        return self._with_lookalikes(frame, self._fit_all(frame, found.poses).best(len(found), search))

    def followed(self, frame: ImageFrame, expected: Poses, votes: float, left: float, climb: Climb) -> Ranked:
        """Where an object is that is expected near some poses, and its mirrored turns, best first.

        :param votes: that it had. :param left: share of them without which a first fit is not worth more.
        """
        search = self._search
        found = self._fit_all(frame, expected).best(1, search)
        if found.votes[0] < left * votes:
            return found[:0]
        found = self._with_bent(frame, found)
        found = self._climb(frame, self._sweep(frame, found.best(1, search)), climb)
        found = self._fit_all(frame, found.poses).best(1, search)
        if found.votes[0] < search.near_joints * votes:  # else its joints are no worse than they were
            found = self.rejointed(frame, found, climb)
        return self._with_rival_flips(frame, found).best(search.flip_keep, search)

    def rebent(self, frame: ImageFrame, found: Ranked, climb: Climb, begun: Poses | None = None) -> Ranked:
        """The same, the first one with joints bent otherwise where labels like that better.

        :param begun: poses with which the search has begun: their required component may be turned otherwise.
        """
        if not len(found):
            return found
        best = self.rejointed(frame, found[:1], climb)
        if self._rebends.any:
            best = self._bent_anew(frame, best, climb)
            if begun is not None and len(begun) and not self._is_explained(frame, best):
                best = self._bent_anew(frame, self._better_bent(frame, best, begun, climb), climb)
        return best + found if best.votes[0] > found.votes[0] else found

    def _bent_anew(self, frame: ImageFrame, best: Ranked, climb: Climb) -> Ranked:
        """One hypothesis with all joints sought anew while that is better, as it is turned and in its mirrored turns:
        these look alike, but with joints that were found for another one what hangs on the required component is
        elsewhere."""
        while not (frame.deadline.expired or self._is_explained(frame, best)):
            starts = Poses.concatenate([best.poses, self._flips(best)])
            bent = self._better_bent(frame, best, starts, climb)
            if bent is best:
                break
            best = bent
        return best

    def _better_bent(self, frame: ImageFrame, best: Ranked, starts: Poses, climb: Climb) -> Ranked:
        """What some hypotheses come to with all joints sought anew, where that is better than the best; else that."""
        search, found = self._search, best[:0]
        for n in range(len(starts)):
            if len(found) and frame.deadline.expired:
                break
            bent = self._rebends.of(frame, starts[n : n + 1])
            tried = Ranked(bent, self.votes(frame, bent, occlusion=True))
            tried = self._sweep(frame, tried[np.argsort(-tried.votes, kind="stable")[: search.bend_keep]])
            found = found + self._fit_all(frame, tried.poses).best(search.bend_keep, search)
        found = self.polished(frame, found.best(search.bend_keep, search), climb).best(1, search)
        return found if found.votes[0] > best.votes[0] else best

    def _is_explained(self, frame: ImageFrame, best: Ranked) -> bool:
        """Whether each marker of the first hypothesis that should be in view lies on its labels: no other bend has more
        to win."""
        m, said = self.surface.markers, self.judge(frame, best.poses, occlusion=True)
        plain = float(self.config.votes.inside[0])
        return bool((said.votes[0, m] >= plain * said.area_px[0, m]).all())

    def rejointed(self, frame: ImageFrame, best: Ranked, climb: Climb) -> Ranked:
        """One hypothesis with a joint elsewhere, after a fit and a climb, and then the next, while that is better."""
        for _ in range(self.surface.kinematics.n_joints):
            if frame.deadline.expired:
                break
            others = self._other_joints.of(frame, best.poses, float(best.votes[0]))
            found = self._fit_all(frame, others).best(1, self._search) if len(others) else best[:0]
            found = found[found.votes > self._search.near_joints * best.votes[0]]
            if len(found) and found.votes[0] <= best.votes[0]:
                found = self._fit_all(frame, self._climb(frame, found, climb).poses).best(1, self._search)
            if not len(found) or found.votes[0] <= best.votes[0]:
                break
            best = found
        return best

    def _with_bent(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """Add the same with joints sought anew: a better pose may show a limb that a worse one missed."""
        bent = Poses.concatenate([found.poses, self.surface.search_joints(frame, found.poses, self._grids)])
        return Ranked(bent, self.votes(frame, bent, occlusion=True))

    def moved(self, frame: ImageFrame, found: Ranked, climb: Climb) -> Ranked:
        """Hypotheses after a climb on the votes."""
        return self._climb(frame, self._sweep(frame, found), climb)

    def polished(self, frame: ImageFrame, found: Ranked, climb: Climb) -> Ranked:
        """Hypotheses after a climb on the votes, and a fit to the contours."""
        return self._fit_all(frame, self.moved(frame, found, climb).poses)

    def _with_joints(self, frame: ImageFrame, poses: Poses) -> Ranked:
        """The best with the joints at which the labels like the other components best, fitted to all contours."""
        search = self._search
        poses = self._standing(frame, poses, self.config.guesses.standing_slack)
        poses = self.surface.search_joints(frame, poses, self.first_grids)
        found = Ranked(poses, self.votes(frame, poses, occlusion=False)).best(search.joint_keep, search)
        poses = Poses.concatenate([found.poses, self._flips(found)])
        poses = self._standing(frame, poses, self.config.guesses.standing_slack)
        found = self._fit_all(frame, poses).best(search.fit_keep, search)
        return self._with_lookalikes(frame, found)

    def _standing(self, frame: ImageFrame, poses: Poses, slack: float) -> Poses:
        """Those that stand on the scene's floor, by so many times its limits."""
        floor = frame.scene.floor
        if floor is None:
            return poses
        return poses[np.flatnonzero(floor.standing(poses.R, poses.t, slack))]

    def _with_lookalikes(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """Add those of the best one's lookalikes that come near to it, and theirs in turn while they are better."""
        search = self._search
        for _ in range(_MOST_MOVES * (len(found) > 0 and len(self._lookalikes) > 0)):
            poses = self._lookalikes.of(found.poses[:1])
            poses = self.surface.search_joints(frame, poses, self.first_grids)
            others = Ranked(poses, self.votes(frame, poses, occlusion=True)).best(search.flip_keep, search)
            others = others[others.votes > search.rival * found.votes[0]]
            if not len(others):
                break
            best, others = found.votes[0], self._fit_all(frame, others.poses)
            found = (found + others).best(search.fit_keep, search)
            if found.votes[0] <= best:
                break
        return found

    def _with_rival_flips(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """Add the best one's siblings that come near to it."""
        flips = self._flips(found[:1])
        if not len(flips):
            return found
        fitted = self._fit_all(frame, flips).best(self._search.flip_keep, self._search)
        return found + fitted[fitted.votes > self._search.rival * found.votes[0]]

    def _sweep(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """Joints at their best by the votes of the whole object, which know what hides what."""
        kin, surface = self.surface.kinematics, self.surface
        if not kin.n_joints:
            return found
        moved = found.copied()
        for j, grid in enumerate(kin.grids(self._search.joint_step)):
            if frame.deadline.expired:
                break
            climbing.sweep(
                surface.compiled, kin.chain, frame.view, surface.limits, self._value, j, grid, *moved.arrays
            )  # fmt: skip
        return moved

    def _climb(self, frame: ImageFrame, found: Ranked, climb: Climb) -> Ranked:
        """Local search on the votes of the whole object: no hypothesis gets worse, and the clock ends it."""
        kin, moved, surface = self.surface.kinematics, found.copied(), self.surface
        near_m, far_m = self._depths(frame.camera)
        limits = kin.lower, kin.upper, kin.unit, kin.endless
        moves = climbing.Moves(self._steps, frame.camera.focal_px, near_m, far_m, *limits)
        steps = np.full((len(found), 6 + kin.n_joints), climb.first_step, float)
        if self.facing:
            steps[:, 3:5] = 0.0
        for part in frame.deadline.parts(len(found), _AT_ONCE if self.facing else 1):
            arrays = [values[part] for values in (steps, *moved.arrays)]
            climbing.climb(
                surface.compiled, kin.chain, frame.view, surface.limits, self._value, moves, climb.rounds, *arrays
            )  # fmt: skip
        return moved

    def judge(self, frame: ImageFrame, poses: Poses, *, occlusion: bool, covered: bool = False) -> PatchScores:
        """What the labels say of every patch under each hypothesis: see `SpatialModel.score`."""
        patches = np.arange(len(self.surface.patches))
        return self.surface.score(frame, poses, patches, occlusion=occlusion, covered=covered)

    def votes(self, frame: ImageFrame, poses: Poses, *, occlusion: bool) -> Array:
        """(H,) votes of whole objects; a component that speaks against itself counts as hidden, at a price."""
        surface, view, out = self.surface, frame.view, np.empty(len(poses))
        value = self._value._replace(occlusion=occlusion)
        R, t, q = poses.R, poses.t, poses.q
        climbing.votes_of(surface.compiled, surface.kinematics.chain, view, surface.limits, value, R, t, q, out)
        return out

    def total(self, scores: PatchScores) -> Array:
        """(H,) votes of whole objects from what is said of all their patches."""
        out = np.empty(len(scores.votes))
        climbing.totals(self.surface.compiled, self._value, scores.votes, scores.area_px, out)
        return out

    def strayed(self, poses: Poses, expected: Poses) -> float:
        """How far the first hypothesis is from the nearest of some others: 1 where no climb would lead to it."""
        niche, near = self._search, poses[:1]
        off = np.linalg.norm(expected.t - near.t, axis=1) / (niche.niche_range * float(np.linalg.norm(near.t)))
        cosine = (np.einsum("kij,ij->k", expected.R, near.R[0]) - 1) / 2
        return float(np.maximum(off, np.arccos(np.clip(cosine, -1, 1)) / niche.niche_rad).min())

    def _flips(self, found: Ranked) -> Poses:
        """Siblings of the best."""
        return self.required.flips(found.best(self._search.flip_keep, self._search).poses)

    def fitted(self, frame: ImageFrame, poses: Poses, used: np.ndarray | None = None) -> Poses:
        """Fits to the contours of the markers used (H, M), or of all that the labels support."""
        supported = self.supported(self.judge(frame, poses, occlusion=True)) if used is None else used
        return self._fitted(frame, poses, supported)

    def _fit_all(self, frame: ImageFrame, poses: Poses) -> Ranked:
        """Hypotheses and their fits to the contours of all markers that the labels support, with votes."""
        return self.refit.of(frame, poses, self._depths(frame.camera))

    def supported(self, scores: PatchScores) -> np.ndarray:
        """(H, M) markers that the labels support."""
        m, config = self.surface.markers, self.config
        seen = (scores.area_px[:, m] > config.min_blob_px) & (scores.agree[:, m] > config.votes.supported_agree)
        return np.asarray(seen & (scores.votes[:, m] > 0))

    def settled(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> Poses:
        """Hypotheses at rest on the contours of the markers used (H, M), which are finer than the votes, but for those
        whose votes fall far."""
        fitted = self._fitted(frame, poses, used, last=True)
        both = Poses.concatenate([poses, fitted])
        before, after = self.votes(frame, both, occlusion=True).reshape(2, -1)
        return both[np.arange(len(poses)) + len(poses) * (after > self._search.settled_votes * before)]

    def at_rest(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> Poses:
        """Hypotheses at rest on the contours of the markers used (H, M), and on what the image's colours show; of what
        faces the camera not on those of what covers part of it."""
        settled = self.settled(frame, poses, used)
        fitted = self.on_colours(frame, settled, used)
        if not self.facing or fitted is settled:
            return fitted
        covered = (used & (self.lacks_px(self.judge(frame, settled, occlusion=True)) > 0)).any(axis=1)
        return Poses.concatenate([fitted, settled])[np.arange(len(poses)) + len(poses) * covered]

    def lacks_px(self, scores: PatchScores) -> Array:
        """(H, M) pixels of each marker that are not of its class, less what a rim around it can take: 0 or less of one
        that is seen whole."""
        surface, m = self.surface, self.surface.markers
        area_px: Array = scores.area_px[:, m]
        around_px = surface.perimeter * np.sqrt(area_px / surface.compiled.area[m])
        return np.asarray((1 - scores.agree[:, m]) * area_px - surface.votes.ring_px * around_px, np.float64)

    def on_colours(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> Poses:
        """Hypotheses at rest on what the image's colours show; the same where it has none. As `settled`."""
        return poses if frame.image is None else self._to_colours.fitted(frame, poses, used)

    def edges(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> tuple[ContourFit, Array, Array]:
        """Contours of poses that rest on them, and residuals and weights (H, M, m) of the edges that the image shows in
        its colours, or in its labels where it has none."""
        if frame.image is not None and isinstance(self._to_colours, ColourFit):
            return self._to_colours.edges(frame, poses, used)
        fit = contour_fit(self.surface, frame, poses, used, self.config.covariance.reach_px, self.config.fit)
        return fit, fit.residual, fit.weight

    def _fitted(self, frame: ImageFrame, poses: Poses, use: np.ndarray, *, last: bool = False) -> Poses:
        """Fits to the contours of the markers in use (H, M); what faces the camera stays within its scale's limits."""
        fit = self.config.fit
        fitted = fit_poses(self.surface, frame, poses, use, fit.fine_reach_px, fit, facing=self.facing, last=last)
        return self.within_limits(frame.camera, fitted) if self.facing else fitted

    def within_limits(self, camera: Camera, poses: Poses) -> Poses:
        """Hypotheses with their origins in the image where they are, and at scales that are looked for."""
        depth = poses.t[:, 2]
        near_m, far_m = self._depths(camera)
        return Poses(poses.R, poses.t * (np.clip(depth, near_m, far_m) / depth)[:, None], poses.q)

    def _depths(self, camera: Camera) -> tuple[float, float]:
        """Between which depths hypotheses stay while they move: of what faces the camera, those of its scale."""
        if not self.facing:
            return 0.0, np.inf
        limits, f = scale_limits(self.config, None), float(camera.focal_px)
        return f / float(limits.greatest), f / float(limits.least) if limits.least > 0 else np.inf


def _steps(search: SearchConfig) -> Steps:
    """Steps of a climb for compiled code; a whole number would be compiled for anew."""
    units = search.step_px, search.step_depth, search.step_rad, search.joint_step
    return Steps(*map(float, (*units, search.lengthen, search.turn, search.least_step)))

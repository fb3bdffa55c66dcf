"""What is found, as users get it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ..geometry.transforms import Array, Pose, rotvec_from_rotation

SURE = 700.0  # log odds: for more there is no number


@dataclass(frozen=True)
class Instance:
    """A marker found in the image: paper, step 5.

    :param x, y: centroid of the marker's outline, of a whole object's marker of what of it is in view; pixels.
    :param theta: direction of its axis (tail to head), radians from +x towards +y.
    :param scale: pixels per metre.
    :param score: 0..1: in space the probability that it lies on its own marker; in the image plane the share of
        evidence that agrees.
    :param contour: (n, 2) the marker's outline in the image, pixels, for drawing.
    :param shows: of a component that may be of several classes, the one that its pixels show best; else empty.
    """

    component: str
    marker: str
    score: float
    x: float
    y: float
    theta: float
    scale: float
    contour: Array = field(default_factory=lambda: np.zeros((0, 2)), repr=False, compare=False)
    shows: str = ""

    def rated(self, score: float) -> Instance:
        """The same with another score; `replace` would take four times as long."""
        place = self.x, self.y, self.theta, self.scale
        return Instance(self.component, self.marker, score, *place, self.contour, self.shows)


@dataclass(frozen=True)
class OtherTurn:
    """A second pose of an object found, which the image bears out nearly as well: its mirrored turn, of which a flat
    marker far away or alone tells little. Or better, where that would be no object by itself: its outline is off.

    :param probability: 0..1, that it is this one. :param joints: as `Detection.joints`, at this turn, the shorter way
        around from those that are told.
    :param sides: of a rigid object with sides that look alike, how probable it is that another one is seen than is
        told; `Detection.as_told` counts it.
    """

    pose: Pose
    probability: float
    joints: Mapping[str, float] = field(default_factory=dict)
    sides: float = field(default=0.0, repr=False, compare=False)

    def spread(self, told: Pose) -> Array:
        """(6, 6) what it would add to the covariance of the pose told, were it surely the true one: along the camera's
        axes, about that pose."""
        turn = rotvec_from_rotation(self.pose.rotation @ told.rotation.T)
        off = np.concatenate([self.pose.position - told.position, turn])
        return np.asarray(np.outer(off, off), np.float64)


MissingState = Literal["in doubt", "not seen", "too small", "hidden", "out of view", "turned away", "elsewhere"]


@dataclass(frozen=True)
class Missing:
    """A component of an object found that is not told, and why; or one that is, and may be on another blob.

    :param state: `in doubt`: something of its class is there, which may well be another's; `not seen`: enough of it
        should be in view, and its class is not where the pose puts it: it lies elsewhere, or its pixels have another
        class; `too small`: in view, with fewer pixels than tell anything, or as so narrow a sliver; `hidden`: by what
        `by` names; `out of view`: most of it beyond the image's border; `turned away` from the camera; `elsewhere`: a
        blob of its class, about as large as its marker, lies where the pose does not put it, and nothing explains it:
        it may be this component, which is told elsewhere or not at all. Of several markers what is said of the one that
        is nearest to being seen.
    :param x, y: where that marker's centroid would be in the image, pixels; `elsewhere`: where that blob's middle is.
    :param by: `itself`, or the other object's name; empty: nothing that was found.
    :param score: of what is in doubt the probability that it is its own marker, of another blob of a component that is
        told that it is this one; 0: not known, as of the required one.
    """

    component: str
    state: MissingState
    x: float
    y: float
    by: str = ""
    score: float = 0.0


@dataclass(frozen=True)
class ImagePose:
    """Where an object's required component lies in the image; units as in `Instance`."""

    x: float
    y: float
    theta: float
    scale: float


@dataclass(frozen=True)
class OtherPlace:
    """Where else in the image an object may lie: what of it is seen looks there like other parts of it; or how large it
    may be: its long markers end elsewhere.

    :param image: of its required component. :param probability: 0..1, that it is there; others may be as likely.
    :param told: what is told where it lies there; None where that is not known, or there are more such places.
    :param there: whether there is one in any case: `Detection.as_told` counts it.
    """

    image: ImagePose
    probability: float
    told: Detection | None = field(default=None, repr=False, compare=False)
    there: bool = field(default=False, repr=False, compare=False)


@dataclass(frozen=True)
class OtherObject:
    """An object of another target that may be what is seen instead: what it explains is the same.

    :param object: the target's name. :param probability: 0..1, that it is this one; `Detection.as_told` counts it.
    """

    object: str
    probability: float


@dataclass(frozen=True)
class ClassFit:
    """The class of configurations that an object shows.

    :param name: None: it lies outside every class, or could be of more than one.
    :param confidence: 0..1, of the class, or that there is none.
    :param runner_up: the class that fits next best, with its confidence; None: there is one class only.
    :param reason: why it is of no class: which dimension of the best fitting one fails, by how much.
    """

    name: str | None
    confidence: float
    runner_up: str | None = None
    runner_up_confidence: float = 0.0
    reason: str = ""


PoseSource = Literal["fit", "size", "plane"]
"""How a pose in space is known: the whole object was fitted; or it was found flat, and is taken to face the camera,
with its size in the image telling how far off it is, or to lie on the plane that is given."""


@dataclass(frozen=True)
class IdentityFit:
    """Which one of several like objects an object is.

    :param name: None: two fit nearly alike, all names are taken, or nothing is seen that tells (no `evidence`).
    :param probability: 0..1, of the best one against its runner-up.
    :param unique: whether there is one of each name.
    :param least: probability below which no name is told.
    :param evidence: name -> log-likelihood of what was seen, up to a constant.
    :param listed: log odds that what was seen is one of these, and none that is not declared.
    """

    name: str | None
    probability: float
    runner_up: str | None = None
    unique: bool = False
    least: float = field(default=0.5, repr=False, compare=False)
    evidence: Mapping[str, float] = field(default_factory=dict, repr=False, compare=False)
    listed: float = field(default=SURE, repr=False, compare=False)


@dataclass(frozen=True)
class Motion:
    """How an object moves, by a filter over time.

    :param twist: (6,) of the object's origin, m/s, and about x, y, z, rad/s, along the axes of the frame
        in which the pose is.
    :param joints: joint's name -> rate, rad/s (m/s for prismatic joints).
    """

    twist: Array
    joints: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Filtered:
    """Where an object is by a filter over time.

    :param covariance: (6, 6) as `Detection.pose_covariance`. :param joints: as `Detection.joints`.
    :param joint_deviations: joint's name -> its standard deviation.
    """

    pose: Pose
    covariance: Array
    joints: Mapping[str, float] = field(default_factory=dict)
    joint_deviations: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Detection:
    """One recognised object. `pose` is the object's frame in another one, None where it is not known.

    :param frame_id: the frame in which `pose` is; empty: the camera's optical frame.
    :param pose_from: how `pose` is known.
    :param plane_scale: how many times as large it looks as it would on the scene's plane; None: it is on none.
    :param joints: joint's name -> its angle in radians (metres for prismatic joints).
    :param margin: how much lighter the best choice of objects without this one is, as a share of what this one explains
        (1: nothing else explains it, 0: another choice is as good); None where that is not known.
    :param identity: None where the object has no identities.
    :param class_fit: None where the object has no classes of configurations.
    :param pose_covariance: (6, 6) of (x, y, z, rotation about x, y, z fixed axes), m^2 and rad^2, along the axes of the
        frame in which `pose` is; None without pose.
    :param joint_deviations: joint's name -> its standard deviation; empty: not known.
    :param predicted: it is not seen in this frame but expected; it has no components.
    :param motion: None where it is not known: without pose, or seen for the first time.
    :param filtered: None where it is not asked for, or not known.
    :param missing: why each of the other components is not told; of what is found as a whole alone.
    :param other_turn: None where there is none; else the covariance and the joints' deviations count it.
    :param other_place: None where there is none; else `score` counts it.
    :param other_object: None where there is none.
    :param as_told: how probable it is this object in its pose, in space or in the image, if something is there, where
        blobs that may be components of it are left unexplained, where another target's object explains as much, or,
        found flat, where what is seen may be bent otherwise, or laid so, or its long markers may end elsewhere;
        `score` counts it, and of the former joints' deviations do.
    :param beyond_chance: the share of its probability that is left where chance makes such objects of like patches, in
        an image that faces it; `score` counts it.
    :param beyond_others: the share that is left where others whose pixels say nothing of it may not be there; `score`
        counts it.
    """

    object: str
    id: int
    score: float
    image: ImagePose
    components: tuple[Instance, ...]
    pose: Pose | None = None
    joints: dict[str, float] = field(default_factory=dict)
    pose_covariance: Array | None = field(default=None, repr=False, compare=False)
    class_fit: ClassFit | None = None
    margin: float | None = None
    identity: IdentityFit | None = None
    frame_id: str = ""
    pose_from: PoseSource = "fit"
    plane_scale: float | None = field(default=None, compare=False)
    joint_deviations: Mapping[str, float] = field(default_factory=dict, repr=False, compare=False)
    predicted: bool = False
    motion: Motion | None = field(default=None, repr=False, compare=False)
    filtered: Filtered | None = field(default=None, repr=False, compare=False)
    missing: tuple[Missing, ...] = field(default=(), repr=False, compare=False)
    other_turn: OtherTurn | None = field(default=None, repr=False, compare=False)
    other_place: OtherPlace | None = field(default=None, repr=False, compare=False)
    other_object: OtherObject | None = field(default=None, repr=False, compare=False)
    as_told: float = field(default=1.0, repr=False, compare=False)
    beyond_chance: float = field(default=1.0, repr=False, compare=False)
    beyond_others: float = field(default=1.0, repr=False, compare=False)

    @property
    def there(self) -> float:
        """The probability that it is there, be it otherwise than it is told."""
        return min(self.score / self.as_told, 1.0) if self.as_told > 0 else 0.0

    @property
    def may_be_elsewhere(self) -> bool:
        """Whether `there` is the less for what is seen may be other parts of it, laid elsewhere."""
        return self.other_place is not None and not self.other_place.there

    @property
    def is_in_doubt(self) -> bool:
        """Whether its score is the probability that it is there, to which other frames add; of what was put together
        in the image plane it is that all of it is right."""
        return self.margin is None

    def instance_of(self, component: str) -> Instance | None:
        """What shows a component; None: it is not told."""
        return next((c for c in self.components if c.component == component), None)

    @property
    def told_pose(self) -> Pose | None:
        """`pose`, or what the filter makes of it where that is asked for."""
        return self.pose if self.filtered is None else self.filtered.pose

    @property
    def told_joints(self) -> Mapping[str, float]:
        """`joints`, or what the filter makes of them where that is asked for."""
        return self.joints if self.filtered is None else {**self.joints, **self.filtered.joints}

    @property
    def name(self) -> str:
        """What it is called in messages and pictures: by its identity, yellow_gr, where it is known and there is one of
        each; else by its number, red_0, or yellow_unknown_0 where its name is not known: names may be numbers, too."""
        fit = self.identity
        if fit is None:
            return f"{self.object}_{self.id}"
        if fit.name is None:
            return f"{self.object}_unknown_{self.id}"
        return f"{self.object}_{fit.name}" if fit.unique else f"{self.object}_{fit.name}_{self.id}"

    def beside(self, other: OtherTurn, gained: float) -> Detection:
        """The same with another turn beside it.

        :param gained: that turn's probability, as far as covariance and joint deviations do not count it yet.
        """
        assert self.pose is not None and self.pose_covariance is not None
        bent = {name: other.joints.get(name, q) - q for name, q in self.joints.items()}
        deviations = {
            name: float(np.sqrt(max(deviation**2 + gained * bent.get(name, 0.0) ** 2, 0.0)))
            for name, deviation in self.joint_deviations.items()
        }
        covariance = self.pose_covariance + gained * other.spread(self.pose)
        return replace(self, other_turn=other, pose_covariance=covariance, joint_deviations=deviations)

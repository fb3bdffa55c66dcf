"""Which class of configurations a recognised object shows, how sure that is, or that it shows none of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..alignment.shapes import Shape
from ..alignment.symmetry import ANY_ANGLE
from ..base.config import RecognizerConfig
from ..constraints.classes import LEAST_RANGE, ConfigurationClass
from ..constraints.constraint_set import ConstraintSet
from ..constraints.intervals import Interval
from ..constraints.pairs import ANGLES, Key, PairConstraint, at_one_scale, configuration, configuration_noise
from ..geometry.transforms import Array
from ..grouping.candidates import ImagePoses
from ..model.found import ClassFit, Detection, Instance
from ..model.kinematics import Kinematics
from ..model.objects import ObjectModel
from ..model.target import Target

_SIGMAS = 2.5  # half a class's box, in standard deviations of its configurations
_TOLD = ("distance_m", "offset_x_m", "offset_y_m", *ANGLES)  # what tells classes apart; scales do not


@dataclass(frozen=True)
class Term:
    """One dimension of a configuration against a class.

    :param value: what was measured, with its standard deviation `noise`; :param allowed: the class's.
    :param span: length over which objects of no class spread.
    :param weight: relations between pairs of components depend on each other: they count by so much.
    """

    name: str
    value: float
    noise: float
    allowed: Interval
    span: float
    weight: float

    @property
    def excess(self) -> float:
        """How far the value lies outside what is allowed, beyond twice its noise; 0 inside."""
        return max(0.0, float(self.allowed.excess(self.value)) - 2 * self.noise)

    @property
    def evidence(self) -> float:
        """Logarithm of how likely the value is in the class over how likely it is in none."""
        half = self.allowed.width / 2
        sigma = np.hypot(half / _SIGMAS, self.noise)
        middle = Interval((self.allowed.low + self.allowed.high) / 2, (self.allowed.low + self.allowed.high) / 2)
        away = float(replace(middle, period=self.allowed.period).excess(self.value))
        ratio = -0.5 * (away / sigma) ** 2 - np.log(sigma * np.sqrt(2 * np.pi)) + np.log(max(self.span, 1e-9))
        return float(self.weight * ratio)


@dataclass(frozen=True)
class ClassScore:
    """One class's case. `seen`: share of the class's components, or joints, that the object shows."""

    name: str
    terms: tuple[Term, ...]
    seen: float

    @property
    def evidence(self) -> float:
        """Logarithm of the odds against no class; of nothing seen 0."""
        return sum(t.evidence for t in self.terms)

    @property
    def failed(self) -> Term | None:
        """The dimension that lies farthest outside the class's region, in shares of what is allowed; None: inside."""
        outside = [t for t in self.terms if t.excess > 0]
        return max(outside, key=lambda t: t.excess / max(t.allowed.width + 2 * t.noise, 1e-9), default=None)


class Classifier:
    """Tells the classes of each target that has learned some."""

    def __init__(self, targets: Sequence[Target], config: RecognizerConfig) -> None:
        self._config = config
        learned = [(t, t.constraints) for t in targets if isinstance(t.constraints, ConstraintSet)]
        self._models = {t.name: _ClassModel(t.model, c, config) for t, c in learned if c.classes}

    def classified(self, detections: Iterable[Detection]) -> tuple[Detection, ...]:
        """The detections, with `class_fit` where their object has classes."""
        return tuple(replace(d, class_fit=self.fit(d)) if d.object in self._models else d for d in detections)

    def fit(self, detection: Detection) -> ClassFit:
        """The class that fits best, or none. The object must have classes."""
        scores = self._models[detection.object].scores(detection)
        odds = np.array([0.0, *(s.evidence for s in scores)])  # of no class first
        share = np.exp(odds - odds.max())
        share = share / share.sum()
        order = np.argsort(-share[1:], kind="stable")
        refusals = {int(n): self._refusal(scores[n], float(share[n + 1])) for n in order}
        best = next((n for n, refusal in refusals.items() if not refusal), None)
        others = [int(n) for n in order if n != best]
        runner_up = others[0] if others else None
        return ClassFit(
            None if best is None else scores[best].name,
            float(share[0] if best is None else share[best + 1]),
            None if runner_up is None else scores[runner_up].name,
            0.0 if runner_up is None else float(share[runner_up + 1]),
            refusals[int(order[0])] if best is None else "",
        )

    def _refusal(self, score: ClassScore, confidence: float) -> str:
        """Why the object is not of this class; empty where it is."""
        if score.seen < self._config.min_class_seen or not score.terms:
            return f"{score.name}: {score.seen:.2f} of its parts seen, {self._config.min_class_seen:g} are wanted"
        failed = score.failed
        if failed is not None:
            low, high = failed.allowed.low, failed.allowed.high
            return f"{score.name}: {failed.name} lies {failed.excess:.3g} outside {low:.3g} to {high:.3g}"
        if confidence < self._config.min_class_confidence:
            return f"{score.name}: confidence {confidence:.2f} is below {self._config.min_class_confidence:g}"
        return ""


class _ClassModel:
    """One target's classes, ready to be asked."""

    def __init__(self, model: ObjectModel, constraints: ConstraintSet, config: RecognizerConfig) -> None:
        self._constraints, self._config = constraints, config
        self._kinematics = Kinematics(model)
        self._joints = model.joint_names
        self._areas = {(c.name, m.name): m.area for c in model.components for m in c.markers}
        self._shapes = {(c.name, m.name): Shape.from_marker(m) for c in model.components for m in c.markers}
        self._spans = {
            frozenset((p.first, p.second)): {d: i.width for d, i in p.allowed.items()} for p in constraints.pairs
        }

    def scores(self, detection: Detection) -> list[ClassScore]:
        """Where joints are known they are compared, else pairs of markers as the image plane shows them: what was found
        flat may have a pose by its size or on a plane, and has no joints by that."""
        classes = self._constraints.classes
        posed = detection.pose is not None and (detection.pose_from == "fit" or detection.joints)
        if posed and any(c.joints for c in classes):
            return [self._by_joints(c, detection) for c in classes]
        return [self._by_pairs(c, detection) for c in classes]

    def _by_joints(self, c: ConfigurationClass, detection: Detection) -> ClassScore:
        terms = []
        for name in (n for n in c.joints if n in detection.joints):
            j = self._joints.index(name)
            noise = self._config.constraints.class_noise * float(self._kinematics.unit[j])
            span = least = float(self._kinematics.upper[j] - self._kinematics.lower[j])
            if self._kinematics.revolute[j]:
                span, least = min(span, 2 * np.pi), 1.0
            allowed = _resolved(c.joints[name].allowed, LEAST_RANGE * least)
            terms.append(Term(name, detection.joints[name], noise, allowed, max(span, allowed.width), 1.0))
        return ClassScore(c.name, tuple(terms), len(terms) / max(len(c.joints), 1))

    def _by_pairs(self, c: ConfigurationClass, detection: Detection) -> ClassScore:
        own = {(i.component, i.marker): i for i in detection.components}
        found = at_one_scale({key: self._pose(key, i) for key, i in own.items()}, self._areas)
        shown = [p for p in c.pairs if p.first in found and p.second in found]
        components = {k[0] for p in shown for k in (p.first, p.second)}
        weight = (len(components) - 1) / max(len(shown), 1)
        terms = [t for p in shown for t in self._pair_terms(p, found, own, weight)]
        everything = {k[0] for p in c.pairs for k in (p.first, p.second)}
        return ClassScore(c.name, tuple(terms), len(components) / max(len(everything), 1))

    def _pair_terms(
        self, p: PairConstraint, found: Mapping[Key, ImagePoses], own: Mapping[Key, Instance], weight: float
    ) -> Iterator[Term]:
        a, b = found[p.first], found[p.second]
        T = configuration(a, b)
        noise = configuration_noise(a, b, T)
        orders = [self._order(k, own[k]) for k in (p.first, p.second)]
        spans = self._spans.get(frozenset((p.first, p.second)), {})
        for d, interval in p.allowed.items():
            if d not in _TOLD:
                continue
            folded = _folded(_resolved(interval, p.least_width(d)), *(orders if d == "turn_rad" else orders[:1]))
            greatest = folded.period or 2 * self._constraints.reach_m
            span = min(spans.get(d, greatest), greatest)
            name = f"{'/'.join(p.first)} - {'/'.join(p.second)} {d}"
            more = self._config.constraints.class_noise * (1.0 if d in ANGLES else float(T["distance_m"]))
            yield Term(name, float(T[d]), float(np.hypot(noise[d], more)), folded, max(span, folded.width), weight)

    def _pose(self, key: Key, i: Instance) -> ImagePoses:
        radius_px = self._shapes[key].rms_radius_m * i.scale
        noise = self._config.constraints
        place = float(np.hypot(noise.contour_noise_px, noise.model_noise * radius_px))
        relative = place / max(radius_px, 1e-9)
        values: tuple[Array, ...] = tuple(
            np.asarray(v, float) for v in (i.x, i.y, i.theta, i.scale, place, relative, relative)
        )
        return ImagePoses(*values)

    def _order(self, key: Key, i: Instance) -> int:
        """In how many directions a marker looks the same at its scale; 1 where its direction has no meaning."""
        order = self._shapes[key].symmetry.order(i.scale, self._config.alignment.symmetry_px)
        return order if order != ANY_ANGLE else 1


def _resolved(interval: Interval, least_width: float) -> Interval:
    """An interval as wide as images resolve at least, about the same middle."""
    more = max(0.0, least_width - interval.width) / 2
    return Interval(interval.low - more, interval.high + more, interval.period)


def _folded(interval: Interval, *orders: int) -> Interval:
    """An interval of angles modulo symmetries as well (`constraints.pairs`); other intervals as they are."""
    if not interval.period:
        return interval
    period = 2 * np.pi / math.lcm(round(2 * np.pi / interval.period), *orders)
    return Interval(interval.low, interval.low + min(interval.width, period), period)

"""Which claims are objects: a probability from what the labels confirm.

The probability is that of an additive logistic model: each kind of evidence adds what its curve says, a line through a
few points that never falls. Claims of which no other component should be in view, of which none is confirmed, of which
some are, and of which some are while the required one is out of sight, or bears no labels, have a model each; where
another component of the rigid body that it is part of is confirmed, that one is judged in its place. The curves are
fitted on objects made up at random, and how well the probability is calibrated is measured on others
(`benchmarks/acceptance.py`; what learned colours add and strays take: `acceptance_colour.py`, `acceptance_strays.py`).
"""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..pose.at_scale import OffScale
from ..pose.finder import WholeObjectFinder
from ..pose.surface_model import SpatialModel
from . import acceptance_curves, colour_curves, facing_curves, stray_curves
from .acceptance_curves import Model
from .alike import alike_of
from .claims import Claims
from .curve_kernels import Curves, probabilities
from .evidence import Evidence
from .evidence_kernels import Criteria, Found, Said, examine
from .verdicts import CASES, ONE_OF_ITS_BODY, SHOWN, Verdicts

_KNOWN, _EVEN, _FAINT, _COLOUR = (Evidence._fields.index(name) for name in ("known", "even", "faint", "colour"))


def verdicts_of(claims: Claims, sizes: int = 1) -> Verdicts:
    """Which components the labels confirm of each claim, by which marker, and how probable that makes it.

    :param sizes: of which markers may look: chance bears out each claim as many times as easily.
    """
    finder, by = claims.finder, _criteria(claims.finder, in_colour=claims.frame.image is not None)
    surface, n = finder.surface, (len(claims), by.n_components)
    said = Said(*claims.scores.arrays, claims.seen.full_px, claims.votes, claims.scale)
    found = Found(
        np.empty(n, np.int64), np.empty(n, bool), np.empty(n), np.empty(n), np.empty(n),
        np.empty(n[0], np.int64),
        np.empty((n[0], len(Evidence._fields))),
        np.empty(n[0]),
    )  # fmt: skip
    poses = claims.poses
    compiled, chain, view = surface.compiled, surface.kinematics.chain, claims.frame.view
    examine(compiled, chain, poses.R, poses.t, poses.q, view, surface.limits, said, by, found)
    found.evidence[:, _KNOWN], found.evidence[:, _EVEN] = -claims.known, claims.seen.even
    found.evidence[:, _FAINT] = -found.evidence[:, _COLOUR]
    if claims.frame.image is not None:
        found.case[:] = _in_colour(finder.facing)[found.case]
    out = np.empty(n[0])
    probabilities(_curves(finder.facing), found.case, found.evidence, out)
    times = _of_several(found.confirmed, surface)
    if (one := ONE_OF_ITS_BODY[found.case]).any():
        times[one] *= 1 + by.rigid.sum()
    times = sizes * times * found.times
    probability = np.asarray(out / (out + (1 - out) * times))
    off_scale = _off_scale(claims, probability)
    odds = np.exp(off_scale.odds)
    return Verdicts(claims, *found, probability / (probability + (1 - probability) * odds), off_scale)


def _off_scale(claims: Claims, probability: Array) -> OffScale:
    """Whatever others own of their pixels, of those that are probable enough to be told."""
    told, at_scale = OffScale.of_none(len(claims)), claims.finder.at_scale
    rows = np.flatnonzero(probability >= claims.finder.config.verdict.least_known)
    if at_scale is None or not len(rows):
        return told
    for column, values in zip(told, at_scale.off_scale(claims.frame.unowned, claims.poses[rows]), strict=True):
        column[rows] = values
    return told


# of each finder, as long as it lives; in images with colours or of labels alone
_CRITERIA: WeakKeyDictionary[WholeObjectFinder, dict[bool, Criteria]] = WeakKeyDictionary()


def _criteria(finder: WholeObjectFinder, *, in_colour: bool) -> Criteria:
    """By which one target's claims are judged."""
    known = _CRITERIA.setdefault(finder, {})
    if in_colour not in known:
        known[in_colour] = _criteria_of(finder, in_colour=in_colour)
    return known[in_colour]


def _criteria_of(finder: WholeObjectFinder, *, in_colour: bool) -> Criteria:
    surface, config, v = finder.surface, finder.config, finder.surface.votes
    thin_px, most = 2 * (v.ring_px + v.ring_width_px), float(v.rim[0] + v.ring[2])
    told = np.zeros(len(surface.patches), bool)
    told[surface.classed_faces] = True
    return Criteria(
        finder.root, surface.rigid_to_root & (not finder.facing), len(surface.model.components), told,
        *surface.classes, float(config.verdict.several_parted) if in_colour else 1.0,
        float(v.body[2]), float(config.min_blob_px), float(v.supported_agree), float(config.verdict.told_agree),
        float(thin_px), float(v.inside[0]), float(v.inside[0] - v.inside[2]), most * v.ring_width_px,
        most, config.required == "visible", surface.root_others,
        finder.facing, finder.facing and surface.overlaps,
        alike_of(surface, config.verdict, facing=finder.facing),
    )  # fmt: skip


def _of_several(confirmed: Array, surface: SpatialModel) -> Array:
    """(H,) how many times as easily chance bears out objects whose components may be of one of several classes, or show
    one of several markers that lie on each other, than those of one, of which the curves are. It may show any
    combination of these of what is confirmed, but each may be there, too: as many times as a component has classes and
    views, in the mean. All of them counted: robots with
    three patches, each of several classes, seen in bad light, 19 told of 160 in place of 86.

    :param confirmed: (H, C)
    """
    if not surface.choices.any():
        return np.ones(len(confirmed))
    mean = confirmed @ surface.choices / np.maximum(confirmed.sum(axis=1), 1)
    return np.asarray(np.exp(mean), np.float64)


_NEVER: Model = -50.0, {}  # a case that is not looked for


@cache
def _models(facing: bool) -> dict[str, Model]:
    """By case. Of what faces the camera curves of scenes with strays add to those of usual ones; in space curves of
    images with colours to those of labels, and what stands in for the required component is judged as that is. How few
    distances a floor leaves open counts as how few scales do where objects face the camera."""
    if facing:
        models = dict(facing_curves.CURVES)
        for case, more in stray_curves.ADDED.items():
            models[case] = _with(models[case], more)
        return models
    models = dict(acceptance_curves.CURVES)
    for case, more in colour_curves.ADDED.items():
        models[f"{case} in colour"] = _with(models[case], more)
    for case, its_own in models.items():
        models[case] = _with(its_own, (0.0, {"known": facing_curves.CURVES[case][1]["known"]}))
    for way, case in product(("", " in colour"), SHOWN):
        if model := models.get(f"{case}{way}"):
            models |= {f"{why}, {case}{way}": model for why in ("unseen", "faded")}
    return models


def _with(model: Model, more: Model) -> Model:
    """A model with further evidence."""
    return model[0] + more[0], {**model[1], **more[1]}


@cache
def _curves(facing: bool) -> Curves:
    return packed([_models(facing).get(case, _NEVER) for case in CASES], Evidence)


@cache
def _in_colour(facing: bool) -> NDArray[np.int_]:
    """(cases,) which of `CASES` each is in an image with colours: itself where it has no curves of their own."""
    own = [f"{case} in colour" for case in CASES]
    return np.array([CASES.index(c) if c in _models(facing) else n for n, c in enumerate(own)])


def packed(models: list[Model], kind: type[NamedTuple]) -> Curves:
    """Some models of one kind of evidence for compiled code."""
    names, most = kind._fields, max(len(xs) for _, curves in models for xs, _ in curves.values())
    count, points = np.zeros((len(models), len(names)), np.int64), np.zeros((2, len(models), len(names), most))
    for m, (_, curves) in enumerate(models):
        for name, both in curves.items():
            k = names.index(name)
            count[m, k] = len(both[0])
            points[:, m, k, : count[m, k]] = both
    return Curves(np.array([bias for bias, _ in models], float), count, points[0], points[1])

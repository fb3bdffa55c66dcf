"""Is an object in space there as often as its score says? Random objects, among clutter, strangers and each other.

    python benchmarks/acceptance.py --save found.npz [--first 0] [--worlds 112] [--scenes 12]    # some ten minutes
    python benchmarks/acceptance.py --load found.npz [more.npz ...] [--fit]                      # at once

Each world has one or two random targets (`benchmarks/random_solids.py`). The recogniser's own search and sharing out
runs on its scenes, with no least probability, and each claim is right or wrong (`is_at`). `--fit` fits the curves of
`core/verdict/acceptance.py` on even-numbered worlds and writes them; tables are always of odd-numbered ones. Which
claims there are depends a little on the curves in force: after a change of the evidence, save and fit twice.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import fill

import numpy as np
from acceptance_fit import Curves, best_of_several, expected_error, log_loss, reliability, threshold
from numpy.typing import NDArray
from random_solids import World, random_frames, random_world
from tqdm import tqdm

from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Array
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.surface_model import Poses
from artrec_ros.core.spatial_search import SpatialSearch
from artrec_ros.core.verdict import acceptance_curves
from artrec_ros.core.verdict.acceptance import Evidence, Verdict
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.core.verdict.ownership import share_out
from artrec_ros.simulation.simulator import SimulatedFrame
from artrec_ros.simulation.surfaces import component_poses
from artrec_ros.simulation.truth import ObjectTruth

OUT = Path(acceptance_curves.__file__)
# Of each case the evidence that lowers the log-loss on worlds left out; more of it does not
COLUMNS = {
    "alone": ("size", "edge", "bare", "body", "facing"),
    "deserted": ("size", "edge", "bare", "body", "shown", "others", "faces", "missing"),
    "borne out": ("size", "edge", "shown", "colour", "edges", "faces", "facing"),
}
INDEX = {case: tuple(Evidence._fields.index(name) for name in names) for case, names in COLUMNS.items()}
SURE_WRONG, LIKELY_WRONG = 0.03, 0.08  # of claims that the search takes for sure, or for likely, at most so many
# How far a claim may be off: of its marker's size in the image and of its range, and pixels of that size
SIZE_SHARE, RANGE_SHARE, SIZE_PX, RANGE_PX = 0.35, 0.1, 1.0, 2.0


@dataclass(frozen=True)
class Recorder(Judge):
    """Judges, and keeps what the search asked about."""

    asked: list[Verdict] = field(default_factory=list)

    def trust_in(self, finder: WholeObjectFinder, poses: Poses, frame: ImageFrame) -> float:
        verdict = self.verdicts(finder, poses[:1], frame)[0] if len(poses) else None
        if verdict is None:
            return 0.0
        self.asked.append(verdict)
        return self.trust(verdict)


def shown_centre(verdict: Verdict) -> Array:
    """(3,) the centre of the marker that shows a claim's required component, in the camera."""
    finder, poses = verdict.claim.finder, verdict.claim.poses
    marker = finder.surface.patches[verdict.shown[finder.root]].marker
    assert marker is not None
    frames = finder.surface.kinematics.forward(poses.R, poses.t, poses.q)
    return np.asarray(frames.R[0, finder.root] @ marker.centre + frames.t[0, finder.root])


def is_at(verdict: Verdict, truth: ObjectTruth, frame: SimulatedFrame) -> bool:
    """Whether a claim is right in place: its required component is where the claim has it.

    Of that component's markers that face the camera, one must be where the claim has its own: within a third of its
    size in the image (its neighbours of the same shape are farther off), and within a tenth of its range (something
    small and near is nothing large and far). A segmenter's seam may take a pixel on either side of a marker, and so
    a small one may be off by more of its range. How exact a pose is, and which way it is turned, is not asked:
    of that `Detection.pose_covariance` speaks.
    """
    placed, model = truth.placed, truth.placed.target.model
    if placed.target.name != verdict.claim.finder.target.name:
        return False
    claimed = shown_centre(verdict)
    T = placed.T_camera_object @ component_poses(model, placed.joints)[model.required.name]
    for seen in truth.markers:
        if seen.component != model.required.name:
            continue
        true, size_px = T.apply(model.required.marker(seen.marker).centre[None])[0], max(seen.full_px, 1.0) ** 0.5
        off_px = np.linalg.norm(np.diff(project(frame.camera, np.stack([claimed, true])), axis=0))
        off_range = abs(np.linalg.norm(claimed) / np.linalg.norm(true) - 1)
        if off_px <= SIZE_SHARE * size_px + SIZE_PX and off_range <= max(RANGE_SHARE, RANGE_PX / size_px):
            return True
    return False


@dataclass(frozen=True)
class Claims:
    """n claims.

    :param world: (n,) their worlds' numbers. :param final: (n,) bool: of those that pixels were shared out to; else
        the search asked about it. :param case: (n,) `Verdict.case`. :param right: (n,) 1 or 0.
    :param score: (n,) what they got. :param evidence: (n, columns) `Evidence`.
    """

    world: NDArray[np.int_]
    final: NDArray[np.bool_]
    case: NDArray[np.str_]
    right: Array
    score: Array
    evidence: Array

    @classmethod
    def of(cls, rows: list[tuple[int, bool, Verdict, bool]]) -> Claims:
        world, final, verdicts, right = zip(*rows, strict=True)
        return cls(
            np.array(world),
            np.array(final),
            np.array([v.case for v in verdicts]),
            np.array(right, float),
            np.array([v.probability for v in verdicts]),
            np.array([v.evidence for v in verdicts], float),
        )

    @classmethod
    def load(cls, files: list[Path]) -> Claims:
        parts = [np.load(f) for f in files]
        return cls(**{name: np.concatenate([p[name] for p in parts]) for name in cls.__annotations__})

    def __getitem__(self, rows: NDArray) -> Claims:
        return Claims(**{name: values[rows] for name, values in vars(self).items()})


def claims_in(frame: SimulatedFrame, finders: list[WholeObjectFinder]) -> Iterator[tuple[bool, Verdict, bool]]:
    """Claims in a scene: whether pixels were shared out to it, and whether it is right. Of several at an object's
    place only the first, the one with the most votes, is."""
    config, judge = RecognizerConfig(), Recorder(RecognizerConfig().min_votes, 0.0)
    image = ImageFrame(LabelField(frame.labels), frame.camera)
    blobs = find_blobs(frame.labels, {label for f in finders for label in f.surface.labels}, config)
    accepted, _ = share_out(SpatialSearch(image, judge).run(finders, blobs), image, judge)
    left = list(frame.truths)
    for verdict in accepted:
        there = next((n for n, truth in enumerate(left) if is_at(verdict, truth, frame)), None)
        if there is not None:
            del left[there]
        yield True, verdict, there is not None
    for verdict in judge.asked:
        if verdict.confirmed[verdict.claim.finder.root]:
            yield False, verdict, any(is_at(verdict, truth, frame) for truth in frame.truths)


def search(first: int, worlds: int, scenes: int) -> Claims:
    """Claims in the scenes of so many worlds."""
    rows = []
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        world: World = random_world(number)
        finders = [WholeObjectFinder(t) for t in world.targets]
        for frame in random_frames(world, number, scenes):
            rows += [(number, *claim) for claim in claims_in(frame, finders)]
    return Claims.of(rows)


@dataclass(frozen=True)
class Model:
    """Curves of each case, and how they were chosen."""

    curves: dict[str, Curves]
    notes: dict[str, str]

    @classmethod
    def fitted(cls, claims: Claims) -> Model:
        parts = {case: claims[claims.case == case] for case in INDEX}
        found = {c: best_of_several(p.evidence[:, INDEX[c]], p.right, p.world) for c, p in parts.items()}
        return cls({c: f[0] for c, f in found.items()}, {c: f[1] for c, f in found.items()})

    def probability(self, claims: Claims) -> Array:
        """(n,)"""
        out = np.empty(len(claims.right))
        for case, curves in self.curves.items():
            rows = claims.case == case
            out[rows] = curves.probability(claims.evidence[rows][:, INDEX[case]])
        return out


def summary(p: Array, claims: Claims) -> str:
    return (
        f"{len(p)} claims, {claims.right.mean():.3f} right: log-loss {log_loss(p, claims.right):.3f}, "
        f"expected calibration error {expected_error(p, claims.right):.3f}"
    )


def report(title: str, p: Array, claims: Claims) -> None:
    print(f"{title}: {summary(p, claims)}\nprobability   claims   mean   right")
    for low, high, count, mean, share in reliability(p, claims.right):
        print(f"{low:.2f} to {high:.2f}  {count:7d}  {mean:.3f}  {share:.3f}")


def write(model: Model, fitted_on: Claims, held_out: Claims, sure: float, likely: float) -> None:
    """The committed file of fitted numbers."""
    final, worlds = held_out[held_out.final], np.unique(np.r_[fitted_on.world, held_out.world])
    text = (
        f"Fitted on {fitted_on.final.sum()} claims in the even-numbered of worlds {worlds.min()} to {worlds.max()} "
        f"({'; '.join(f'{case}: {note}' for case, note in model.notes.items())}). On the odd-numbered ones: "
        f"{summary(model.probability(final), final)}."
    )
    lines = ['"""The curves of `acceptance.py`, written by `python benchmarks/acceptance.py --fit`.', ""]
    lines += [fill(text, 118), '"""', ""]
    lines += ["# Of each case the bias, and of each evidence the points of its curve: how much there is, what it adds"]
    lines += ["CURVES: dict[str, tuple[float, dict[str, tuple[tuple[float, ...], tuple[float, ...]]]]] = {"]
    for case, curves in model.curves.items():
        lines += [f'    "{case}": (', f"        {curves.bias:.3f},", "        {"]
        for name, (x, y) in zip(COLUMNS[case], curves.points, strict=True):
            xs, ys = (", ".join(f"{v:.3f}" for v in values) for values in (x, y))
            lines += [f'            "{name}": (', *(f"                ({v})," for v in (xs, ys)), "            ),"]
        lines += ["        },", "    ),"]
    lines += ["}", "# What the search takes for sure, and for likely: of the claims that it asked about no more than"]
    lines += [f"# {SURE_WRONG:.0%} above the first and {LIKELY_WRONG:.0%} above the second are wrong"]
    lines += [f"SURE, LIKELY = {sure:.3f}, {likely:.3f}"]
    OUT.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0, help="number of the first world")
    parser.add_argument("--worlds", type=int, default=112)
    parser.add_argument("--scenes", type=int, default=12, help="of each world")
    parser.add_argument("--save", type=Path, metavar="FILE.npz")
    parser.add_argument("--load", type=Path, nargs="+", metavar="FILE.npz")
    parser.add_argument("--fit", action="store_true", help=f"write {OUT.name}")
    args = parser.parse_args()
    claims = Claims.load(args.load) if args.load else search(args.first, args.worlds, args.scenes)
    if args.save:
        np.savez(args.save, **vars(claims))
    even = claims.world % 2 == 0
    final, asked = (claims[~even & kind] for kind in (claims.final, ~claims.final))
    report("as they scored", final.score, final)
    if args.fit:
        model = Model.fitted(claims[even & claims.final])
        known = claims[even & ~claims.final]
        sure, likely = (threshold(model.probability(known), known.right, most) for most in (SURE_WRONG, LIKELY_WRONG))
        write(model, claims[even], claims[~even], sure, likely)
        report("fitted", model.probability(final), final)
        for case in INDEX:
            part = final[final.case == case]
            print(f"{case}: {summary(model.probability(part), part)}")
        p = model.probability(final)
        for least in (0.2, 0.25, 0.3, 0.35, 0.4, 0.5):
            taken = p >= least
            kept = final.right[taken].sum() / final.right.sum()
            print(f"min_probability {least:.2f}: expected precision {p[taken].mean():.3f},", end=" ")
            print(f"precision {final.right[taken].mean():.3f}, {kept:.3f} of the right claims are kept")
        p = model.probability(asked)
        for name, least in (("sure", sure), ("likely", likely)):
            print(f"{name}: above {least:.3f} are {np.mean(p > least):.3f} of what the search asks about,", end=" ")
            print(f"{1 - asked.right[p > least].mean():.3f} of these are wrong")


if __name__ == "__main__":
    main()

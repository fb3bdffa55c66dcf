"""Is a flat object in an uncalibrated image there as often as its score says? As `acceptance.py`, of flat objects.

python benchmarks/acceptance_facing.py --save found.npz [--first 0] [--worlds 340] [--scenes 14]
python benchmarks/acceptance_facing.py --load found.npz [more.npz ...] [--fit]
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from acceptance import COLUMNS, PART_INDEX, Model, arguments, fitted_parts, report, rows_of, summary, write
from acceptance_claims import RANGE_PX, RANGE_SHARE, SIZE_PX, SIZE_SHARE, Claims, Parts, Watcher, joined, load, save
from acceptance_fit import best_of_several
from numpy.typing import NDArray
from random_flat import LEAST_PX, MOST_PX, FlatScene, alone, flat_frames, flat_world, strewn, true_scales, world_colours
from tqdm import tqdm

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.facing_search import FacingSearch
from artrec_ros.core.facing_stage import FacingStage
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.range_limits import ScaleLimits, scale_limits
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.codes import Codes
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.verdict import facing_curves
from artrec_ros.core.verdict.descriptions import Describer
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.core.verdict.ownership import share_out
from artrec_ros.core.verdict.verdicts import Verdict
from artrec_ros.simulation.simulator import SimulatedFrame
from artrec_ros.simulation.surfaces import component_poses
from artrec_ros.simulation.truth import ObjectTruth

OUT = Path(facing_curves.__file__)
# Of each case the evidence that lowers the log-loss on worlds left out; blur, which takes from a rim, takes more of it
# in pictures than in made-up ones
OF_LABELS = {
    case: (*("edge" if name == "rim" else name for name in names), "parted") for case, names in COLUMNS.items()
}
FACING = {case: (*names, "known") for case, names in OF_LABELS.items()}
FACING |= {
    f"{case} in colour": (*dict.fromkeys((*names, "others")), "known", "even") for case, names in OF_LABELS.items()
}
UNSEEN = [case for case in FACING if case.startswith(("unseen", "faded"))]
RARE = "unseen", "unseen in colour"  # few and seldom right: fitted together, on all worlds, by what labels tell
FACING |= dict.fromkeys(RARE, FACING["unseen"])
WIDER = 0.05, 0.4  # limits of the scale are wider than what there is, logarithm

_Verdicts = tuple[Sequence[Verdict], Sequence[Verdict]]


def is_there(verdict: Verdict, truth: ObjectTruth, faced: ImageFrame, scene: FlatScene) -> bool:
    """Whether a claim's required component is where the image shows it, within a third of its size, at its scale: what
    moves is seen larger by its way."""
    placed, model, frame = truth.placed, truth.placed.target.model, scene.frame
    if placed.target.name != verdict.claim.finder.target.name:
        return False
    claimed = verdict.claim.finder.required.anchors(verdict.claim.poses)
    T = placed.T_camera_object @ component_poses(model, placed.joints)[model.required.name]
    true = T.apply(model.required.markers[0].centre[None])
    off_px = float(np.linalg.norm(project(faced.camera, claimed) - project(frame.camera, true)))
    scale = faced.camera.focal_px / claimed[0, 2], frame.camera.focal_px / true[0, 2]
    size_px = scale[1] * np.sqrt(model.required.markers[0].area)
    off_scale = abs(np.log(scale[0] / scale[1]))
    return bool(
        off_px <= SIZE_SHARE * size_px + SIZE_PX
        and off_scale <= max(1.5 * RANGE_SHARE, (RANGE_PX + scene.way_px) / size_px)
    )


class FacingWatcher(Watcher):
    """Searches scenes for some flat targets, as the recogniser does."""

    def __init__(self, targets: Sequence[Target], colours: ImageConfig, seed: int, required: str = "strict") -> None:
        super().__init__(())
        self._targets, self._segmenter, self._required = targets, Segmenter(colours), required
        self._rng = np.random.default_rng([24, seed])

    def see(self, scene: FlatScene) -> None:
        """Search a scene by its labels, or in a picture of it; at all scales, and between limits."""
        for limits in (ScaleLimits(0.0, 0.0), self._limits(scene.frame)):
            config = RecognizerConfig(
                min_component_probability=0.0,
                min_scale=limits.least,
                max_scale=limits.greatest,
                required=self._required,
            )
            self._search(scene, config)

    def _limits(self, frame: SimulatedFrame) -> ScaleLimits:
        """About what there is; about anything where nothing is."""
        names = {target.name for target in self._targets}
        scales = true_scales([t for t in frame.truths if t.placed.target.name in names], frame)
        area = self._targets[0].model.required.markers[0].area
        any_one = np.exp(self._rng.uniform(*np.log([LEAST_PX, MOST_PX]))) / np.sqrt(area)
        wider = np.exp(self._rng.uniform(*WIDER))
        return ScaleLimits(min(scales, default=any_one) / wider, max(scales, default=any_one) * wider)

    def _search(self, scene: FlatScene, config: RecognizerConfig) -> None:
        frame, picture, _ = scene
        if picture is None:
            field = LabelField(frame.labels)
        else:
            field = LabelField(self._segmenter.codes(picture), meaning=self._segmenter.meaning)
        image = ImageFrame(field, image=picture).faced()
        shared = self._verdicts(image, config, field.meaning)
        self._note(Judge.of(config), *shared, frame.truths, image, partial(is_there, faced=image, scene=scene))

    def _verdicts(self, image: ImageFrame, config: RecognizerConfig, codes: Codes) -> _Verdicts:
        """On objects, and on the best of the others at each place."""
        stage = FacingStage(self._targets, config, codes)
        self._describers = {d.finder.target.name: d for d in stage.describers}
        wanted = {label for d in stage.describers for labels in d.finder.surface.labels for label in labels}
        return stage.verdicts(image, find_blobs(image.field.labels, wanted, config), scale_limits(config, None))[:2]


class FirstLooks(FacingWatcher):
    """The same by the first look alone, at blobs of the required component's class."""

    def _verdicts(self, image: ImageFrame, config: RecognizerConfig, codes: Codes) -> _Verdicts:
        finders = [WholeObjectFinder(t, config, codes, facing=True) for t in self._targets]
        self._describers = {f.target.name: Describer(f) for f in finders}
        blobs = find_blobs(image.field.labels, {label for f in finders for label in f.root_labels}, config)
        limits = scale_limits(config, None)
        found = [(f, FacingSearch(f, config).run(image, blobs, limits)) for f in finders]
        return share_out(found, image, Judge.of(config))[:2]


def watch(first: int, worlds: int, scenes: int, dotted: float | None = None) -> tuple[Claims, Parts]:
    """Claims, and components of claims, in the scenes of so many worlds.

    :param dotted: share of the worlds with objects of dots, in scenes with strays; None: there are neither.

    Claims that show their required component are those of the first look: a second one is at what that left, and would
    have them counted twice. Others, and components, are those of both, in half of the worlds with objects among them
    whose required component is out of sight.
    """
    claims, parts = [], []
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        world, colours = flat_world(number, dotted or 0.0), world_colours(number)
        looks = FirstLooks(world.targets, colours, number)
        both = FacingWatcher(world.targets, colours, number, "visible" if number // 2 % 2 else "strict")
        for scene in flat_frames(world, number, scenes, alone if dotted is None else partial(strewn, world=world)):
            looks.see(scene)
            both.see(scene)
        found = [c for c in looks.claims if c[1].case not in UNSEEN] + [c for c in both.claims if c[1].case in UNSEEN]
        claims.append(Claims.of(number, found))
        parts.append(Parts.of(number, both.parts))
    return joined(claims), joined(parts)


def fitted(claims: Claims, even: NDArray[np.bool_]) -> Model:
    """:param even: (n,) which claims are of even-numbered worlds."""
    usual = Model.fitted(claims[even], {case: names for case, names in FACING.items() if case not in RARE})
    rare = claims[np.isin(claims.case, RARE)]
    curves, note = best_of_several(rows_of(rare, FACING["unseen"]), rare.right, rare.world)
    of_all = {case: usual.curves.get(case, curves) for case in FACING}
    return Model(FACING, of_all, {case: usual.notes.get(case, note) for case in FACING})


def main() -> None:
    args = arguments(__doc__, 340, 14, OUT)
    claims, parts = load(args.load) if args.load else watch(args.first, args.worlds, args.scenes)
    if args.save:
        save(args.save, claims, parts)
    even, even_part = claims.world % 2 == 0, parts.world % 2 == 0
    report("as they scored", claims[~even].score, claims[~even])
    report("components as they scored", parts[~even_part].score, parts[~even_part], "components")
    if args.fit:
        model, of_parts, rest = fitted(claims, even), fitted_parts(parts[even_part]), claims[~even]
        p, p_parts = model.probability(rest), of_parts[0].probability(parts[~even_part].evidence[:, PART_INDEX])
        said = (
            f"Fitted on {even.sum()} claims and {even_part.sum()} components in the even-numbered of worlds "
            f"{claims.world.min()} to {claims.world.max()}; those whose required component is out of sight in all, "
            "together.",
            f"On the odd-numbered ones: {summary(p, rest)}; {summary(p_parts, parts[~even_part], 'components')}.",
        )
        write(model, of_parts, said, OUT, Path(__file__).name)
        report("fitted", p, rest)
        report("components, fitted", p_parts, parts[~even_part], "components")
        for case in FACING:
            print(f"{case}: {summary(p[rest.case == case], rest[rest.case == case])}")
        for least in (0.2, 0.3, 0.4, 0.5, 0.6):
            taken = p >= least
            print(f"min_probability {least}: expected precision {p[taken].mean():.3f}, precision", end=" ")
            print(f"{rest.right[taken].mean():.3f}, kept {rest.right[taken].sum() / rest.right.sum():.3f}")


if __name__ == "__main__":
    main()

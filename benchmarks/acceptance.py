"""Is an object in space there as often as its score says? Random objects, among clutter, strangers and each other.

    python benchmarks/acceptance.py --save found.npz [--first 0] [--worlds 640] [--scenes 12]    # 45 minutes
    python benchmarks/acceptance.py --load found.npz [more.npz ...] [--fit]          # at once

Each world has one or two random targets (`benchmarks/random_solids.py`). The recogniser's own search and sharing out
runs on its scenes, and each claim, and each of its components, is right or wrong (`benchmarks/acceptance_claims.py`).
`--fit` fits the curves of `core/verdict/acceptance.py` and `parts.py` on even-numbered worlds and writes them; tables
are always of odd-numbered ones. Which claims there are depends a little on the curves in force: after a change of the
evidence, save and fit twice.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill

import numpy as np
from acceptance_claims import Claims, Parts, load, save, watch
from acceptance_fit import Curves, best_of_several, expected_error, log_loss, reliability, threshold

from artrec_ros.core.geometry.transforms import Array
from artrec_ros.core.verdict import acceptance_curves
from artrec_ros.core.verdict.evidence import Evidence
from artrec_ros.core.verdict.parts import PartEvidence

OUT = Path(acceptance_curves.__file__)
# Of each case the evidence that lowers the log-loss on worlds left out; more of it does not
COLUMNS = {
    "alone": ("size", "edge", "bare", "body", "facing"),
    "deserted": ("size", "edge", "bare", "body", "shown", "others", "facing", "missing"),
    "unseen": ("size", "shown", "edges", "faces", "missing", "lacking"),
    "faded": ("size", "rim", "body", "shown", "colour", "edges", "parts", "facing", "missing"),
    "borne out": ("size", "rim", "bare", "shown", "colour", "others", "edges", "parts", "faces", "facing", "missing"),
}
PART_COLUMNS = ("own", "alone", "open", "edge", "parted", "whole")  # of components
PART_INDEX = tuple(PartEvidence._fields.index(name) for name in PART_COLUMNS)
SURE_WRONG, LIKELY_WRONG = 0.03, 0.08  # of claims that the search takes for sure, or for likely, at most so many


@dataclass(frozen=True)
class Model:
    """Curves of each case, and how they were chosen."""

    columns: dict[str, tuple[str, ...]]
    curves: dict[str, Curves]
    notes: dict[str, str]

    @classmethod
    def fitted(cls, claims: Claims, columns: dict[str, tuple[str, ...]] = COLUMNS) -> Model:
        """:param columns: of each case the evidence that its curves are of."""
        parts = {case: claims[claims.case == case] for case in columns}
        found = {c: best_of_several(rows_of(p, columns[c]), p.right, p.world) for c, p in parts.items()}
        return cls(columns, {c: f[0] for c, f in found.items()}, {c: f[1] for c, f in found.items()})

    def probability(self, claims: Claims) -> Array:
        """(n,)"""
        out = np.empty(len(claims.right))
        for case, curves in self.curves.items():
            rows = claims.case == case
            out[rows] = curves.probability(rows_of(claims[rows], self.columns[case]))
        return out


def rows_of(claims: Claims, columns: Sequence[str]) -> Array:
    """(n, columns) some of the evidence."""
    return claims.evidence[:, [Evidence._fields.index(name) for name in columns]]


def summary(p: Array, claims: Claims | Parts, name: str = "claims") -> str:
    return (
        f"{len(p)} {name}, {claims.right.mean():.3f} right: log-loss {log_loss(p, claims.right):.3f}, "
        f"expected calibration error {expected_error(p, claims.right):.3f}"
    )


def report(title: str, p: Array, claims: Claims | Parts, name: str = "claims") -> None:
    print(f"{title}: {summary(p, claims, name)}\nprobability   claims   mean   right")
    for low, high, count, mean, share in reliability(p, claims.right):
        print(f"{low:.2f} to {high:.2f}  {count:7d}  {mean:.3f}  {share:.3f}")


def fitted_parts(parts: Parts) -> tuple[Curves, str]:
    return best_of_several(parts.evidence[:, PART_INDEX], parts.right, parts.world)


def literal(curves: Curves, columns: Sequence[str], indent: str) -> list[str]:
    """Lines of a `Model`."""
    lines = [f"{indent}{curves.bias:.3f},", f"{indent}{{"]
    for name, (x, y) in zip(columns, curves.points, strict=True):
        xs, ys = (", ".join(f"{v:.3f}" for v in values) for values in (x, y))
        lines += [f'{indent}    "{name}": (', *(f"{indent}        ({v})," for v in (xs, ys)), f"{indent}    ),"]
    return [*lines, f"{indent}}},"]


def write(
    model: Model,
    of_parts: tuple[Curves, str],
    said: Sequence[str],
    out: Path,
    program: str,
    sure_likely: tuple[float, float] | None = None,
) -> None:
    """The committed file of fitted numbers.

    :param said: what they were fitted on, and how they do on the rest. :param program: that fitted them.
    :param sure_likely: thresholds of the search.
    """
    head = f"The curves of `acceptance.py` and `parts.py`, written by `python benchmarks/{program} --fit`."
    lines = [f'"""{head}', ""]
    notes = "; ".join(f"{case}: {note}" for case, note in {**model.notes, "components": of_parts[1]}.items())
    lines += [fill(text, 118) for text in (said[0], f"Chosen: {notes}.", *said[1:])]
    lines += ['"""', "", "Model = tuple[float, dict[str, tuple[tuple[float, ...], tuple[float, ...]]]]", ""]
    lines += ["# Of each case the bias, and of each evidence the points of its curve: how much there is, what it adds"]
    lines += ["CURVES: dict[str, Model] = {"]
    for case, curves in model.curves.items():
        lines += [f'    "{case}": (', *literal(curves, model.columns[case], " " * 8), "    ),"]
    lines += ["}", "# The same of components besides the required one"]
    lines += ["PARTS: Model = (", *literal(of_parts[0], PART_COLUMNS, " " * 4), ")"]
    if sure_likely is not None:
        lines += ["# What the search takes for sure, and for likely: of the claims that it asked about no more than"]
        lines += [f"# {SURE_WRONG:.0%} above the first and {LIKELY_WRONG:.0%} above the second are wrong"]
        lines += ["SURE, LIKELY = {:.3f}, {:.3f}".format(*sure_likely)]
    out.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_added(
    added: dict[str, tuple[Curves, str]], columns: Sequence[str], said: str, out: Path, about: str, home: str
) -> None:
    """The committed file of what is added to the curves of some cases.

    :param columns: the further evidence. :param about: what the file is. :param home: the module that has `Model`.
    """
    notes = "; ".join(f"{case}: {note}" for case, (_, note) in added.items())
    lines = [
        f'"""{about}', "", fill(f"{said} Chosen: {notes}.", 118), '"""', "",
        f"from .{home} import Model", "",
        "# Of each case what the bias is more, and of further evidence the points of its curve: how much there is,",
        "# what it adds", "ADDED: dict[str, Model] = {",
    ]  # fmt: skip
    for case, (curves, _) in added.items():
        lines += [f'    "{case}": (', *literal(curves, columns, " " * 8), "    ),"]
    out.write_text("\n".join([*lines, "}"]) + "\n", encoding="utf-8")


def arguments(description: str | None, worlds: int, scenes: int, out: Path) -> argparse.Namespace:
    """What is asked for. :param worlds, scenes: by default. :param out: what a fit writes."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0, help="number of the first world")
    parser.add_argument("--worlds", type=int, default=worlds)
    parser.add_argument("--scenes", type=int, default=scenes, help="of each world")
    parser.add_argument("--save", type=Path, metavar="FILE.npz")
    parser.add_argument("--load", type=Path, nargs="+", metavar="FILE.npz")
    parser.add_argument("--fit", action="store_true", help=f"write {out.name}")
    return parser.parse_args()


def main() -> None:
    args = arguments(__doc__, 640, 12, OUT)
    claims, parts = load(args.load) if args.load else watch(args.first, args.worlds, args.scenes)
    if args.save:
        save(args.save, claims, parts)
    even, even_part = claims.world % 2 == 0, parts.world % 2 == 0
    final, asked = (claims[~even & kind] for kind in (claims.final, ~claims.final))
    report("as they scored", final.score, final)
    report("components as they scored", parts[~even_part].score, parts[~even_part], "components")
    if args.fit:
        model, of_parts = Model.fitted(claims[even & claims.final]), fitted_parts(parts[even_part])
        known, odd_parts = claims[even & ~claims.final], parts[~even_part]
        sure, likely = (threshold(model.probability(known), known.right, most) for most in (SURE_WRONG, LIKELY_WRONG))
        p_parts = of_parts[0].probability(odd_parts.evidence[:, PART_INDEX])
        worlds = np.unique(claims.world)
        said = (
            f"Fitted on {(even & claims.final).sum()} claims and {even_part.sum()} components in the even-numbered of "
            f"worlds {worlds.min()} to {worlds.max()}.",
            f"On the odd-numbered ones: {summary(model.probability(final), final)}; "
            f"{summary(p_parts, odd_parts, 'components')}.",
        )
        write(model, of_parts, said, OUT, Path(__file__).name, (sure, likely))
        report("fitted", model.probability(final), final)
        report("components, fitted", p_parts, odd_parts, "components")
        for case in COLUMNS:
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

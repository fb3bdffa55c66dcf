"""What an object's components are to each other, as far as that has consequences: a part of `artrec model`'s report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...core.model.kinematics import Kinematics
from ...core.model.objects import ObjectModel

_LISTED = 6  # names on a line
_ASIDE = 0.5  # cosine: a marker turned farther than that from all others may be seen without them


def structure(model: ObjectModel) -> Iterator[str]:
    """A line for each thing to know."""
    loose = ["/".join(key) for key, m in model.markers.items() if m.T_component_marker is None]
    if loose:
        where = "the object is found in the image plane only, with constraints from artrec train"
        yield f"note: {shortened(loose)}: no pose: {where}"
        return
    fixed = [c.name for c in model.components if c.joint is None and not c.required]
    if fixed:
        yield f"note: without joint, and so taken to be fixed to the object's frame: {', '.join(fixed)}"
    if model.is_flat:
        return
    moves = Kinematics(model).moves.tolist()
    borne = [moved for c, moved in zip(model.components, moves, strict=True) if c.bodies]
    if bare := [c.name for c, moved in zip(model.components, moves, strict=True) if moved not in borne]:
        yield f"note: without body, so that what they hide, their own far side too, is not known: {', '.join(bare)}"
    if around := _on_other_sides(model):
        yield (
            f"note: where {shortened(around)} face the camera, '{model.required.name}' may be out of sight: there "
            "the object is told with recognizer.required: visible alone"
        )


def _on_other_sides(model: ObjectModel) -> list[str]:
    """Components that are rigid to the required one, with a marker that faces where none of its own does."""
    kin, required = Kinematics(model), model.components.index(model.required)
    R = kin.in_object(kin.middle[None]).R[0]
    facing = [
        np.array([R[c] @ m.T_component_marker.rotation[:, 2] for m in part.markers if m.T_component_marker is not None])
        for c, part in enumerate(model.components)
    ]
    rigid = (kin.moves == kin.moves[required]).all(axis=1)
    return [
        part.name
        for c, part in enumerate(model.components)
        if rigid[c] and c != required and ((facing[c] @ facing[required].T).max(axis=1) < _ASIDE).any()
    ]


def shortened(names: Sequence[str]) -> str:
    """Names on a line, the first few."""
    return ", ".join(names[:_LISTED]) + (f" and {len(names) - _LISTED} more" if len(names) > _LISTED else "")

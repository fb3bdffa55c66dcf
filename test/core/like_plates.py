"""A car with three plates that look the same, on the left, behind and in front: a sign between two bars."""

from __future__ import annotations

import numpy as np
from solids import BLUE, CAB, FRONT, LEFT_SIDE, marker, rectangle

from artrec_ros.core.model.objects import Component, ObjectModel

REAR = FRONT @ np.diag([-1.0, 1.0, -1.0])
PLATES = {"left": (LEFT_SIDE, (0, 0.13, 0)), "rear": (REAR, (-0.22, 0.01, 0.01)), "front": (FRONT, (0.24, 0, 0))}
SIGN, BAR = 0.35 * CAB, rectangle(0.02, 0.06)


def car(required: str = "left_sign", plates=tuple(PLATES)) -> ObjectModel:
    parts = []
    for plate in plates:
        R, at = PLATES[plate]
        for name, outline, off in (("sign", SIGN, 0.0), ("bar1", BAR, -0.065), ("bar2", BAR, 0.065)):
            full = f"{plate}_{name}"
            m = marker("m", outline, R, R @ (off, 0, 0) + at)
            parts.append(Component(full, (m,), required=full == required, label=BLUE if name == "sign" else None))
    return ObjectModel("car", tuple(parts))


def plate(model: ObjectModel, name: str) -> frozenset[int]:
    """The components of one plate."""
    return frozenset(c for c, one in enumerate(model.components) if one.name.startswith(name))

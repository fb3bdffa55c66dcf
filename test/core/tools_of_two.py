"""A tool with a tape around its shaft and another one at its tail, and exact pictures of it."""

from __future__ import annotations

import numpy as np
from solids import marker, rectangle
from squares import TEAM, Placing, hinge

from artrec_ros.core.model.objects import Component, ObjectModel

TAPE, END, REACH = rectangle(0.11, 0.03), rectangle(0.05, 0.03), 0.13
TAIL = TEAM + 1


def tool(outline=TAPE, *, slides: bool = False) -> ObjectModel:
    """:param outline: of the tape: after half a turn this one looks the same. :param slides: the tail does."""
    joint = hinge("tape", (REACH, 0, 0), (1, 0, 0), "prismatic", (-0.02, 0.02)) if slides else None
    tail = marker("end", END, np.eye(3), (0, 0, 0) if slides else (REACH, 0, 0))
    tape = Component("tape", (marker("tape", outline, np.eye(3), (0, 0, 0)),), required=True)
    return ObjectModel("tool", (tape, Component("tail", (tail,), label=TAIL, joint=joint)))


class Tool(Placing):
    """Its `name` is that of the part that is hidden."""

    def patches(self):
        parts = {"tape": (self.at(TAPE), TEAM), "tail": (self.at(END + (REACH, 0.0)), TAIL)}
        return [patch for name, patch in parts.items() if name != self.name]

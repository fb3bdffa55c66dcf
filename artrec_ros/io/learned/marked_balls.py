"""Balls of one colour in annotations: a centre, and a point of the edge, tell what a ball covers; nobody sees where an
axis of one of its sides ends."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array
from ...core.model.objects import Component, ObjectModel
from ...core.model.target import Target

if TYPE_CHECKING:
    from .annotations import AnnotatedObject

_CORNERS = 48  # of an outline: a circle but for a three hundredth of its area
_LEAST_PX = 1.0  # of a radius: a smaller one is a slip
_CENTRE, _EDGE = "centre", "edge"


def ball_keypoints(model: ObjectModel) -> list[str]:
    """COMPONENT.centre and .edge of each component that is a ball."""
    return [f"{name}.{end}" for name in Target(model.name, model, 1).balls for end in (_CENTRE, _EDGE)]


def marked_balls(annotated: AnnotatedObject, target: Target) -> Iterator[tuple[Component, Array]]:
    """Each ball of which both keypoints are labelled, and its outline (n, 2), pixels."""
    if not any(name.endswith(f".{_CENTRE}") for name in annotated.points):
        return  # to ask which components are balls takes a while
    around = np.exp(2j * np.pi * np.arange(_CORNERS) / _CORNERS)
    for name in target.balls:
        centre, edge = (annotated.points.get(f"{name}.{end}") for end in (_CENTRE, _EDGE))
        if centre is not None and edge is not None:
            radius_px = np.linalg.norm(edge - centre)
            if radius_px < _LEAST_PX:
                raise ConfigError(
                    f"{annotated.place}: '{name}.{_EDGE}' lies on '{name}.{_CENTRE}'; mark a point of the ball's rim"
                )
            circle = radius_px * around
            yield target.model.component(name), centre + np.stack([circle.real, circle.imag], axis=1)

"""An object as its file has it: drawn with its joints at any values, over what is marked or found, on a sheet, on
pages to be printed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.design.ambiguity import find_ambiguities
from ...core.geometry.transforms import Array
from ...core.model.target import Target
from ...io.learned.annotations import AnnotatedObject, instance_from_axis
from ...io.learned.marked_objects import outline_px
from ...simulation.extent import joints_at
from ...simulation.sheet import object_picture
from ...simulation.simulator import pinhole_camera
from ..model import print_pages, sheet_of
from .examples import axes_of
from .session import Session

_VIEW_DEG, _SIZE = 60.0, (640, 480)  # of a camera that is not known, as `artrec model` supposes it


def joint_ranges(target: Target) -> dict[str, tuple[float, float]]:
    """Joint -> its least and greatest position, radians or metres."""
    return {name: joint.span for name, joint in target.model.joints.items()}


def joint_units(target: Target) -> dict[str, str]:
    """Joint -> 'rad' or 'm'."""
    return {name: joint.unit for name, joint in target.model.joints.items()}


def middle(target: Target) -> dict[str, float]:
    """Every joint in the middle of its range."""
    return joints_at(target.model, 0.0)


def picture(target: Target, joints: Mapping[str, float], azimuth: float, elevation: float) -> NDArray[np.uint8] | None:
    """(H, W, 3) BGR; None where the file does not say where the markers sit. Angles of the camera in degrees."""
    return object_picture(target, joints, azimuth, elevation) if target.model.is_spatial else None


def sheet(session: Session, target: Target) -> NDArray[np.uint8]:
    """(H, W, 3) BGR, as `artrec model OBJECT.yaml --sheet` draws it."""
    camera = session.stills.camera or pinhole_camera(_SIZE, _VIEW_DEG)
    return sheet_of(find_ambiguities(target.model), camera, target.label)


def write_pages(session: Session, target: Target, paper: str) -> Path:
    """The markers at true scale, as `artrec model OBJECT.yaml --print` writes them. :raises ConfigError: no room."""
    path = session.folder / f"{target.model.name}_{paper}.pdf"
    print_pages(path, target.model, target.label, paper)
    return path


def outlines(annotated: AnnotatedObject, target: Target) -> Iterator[tuple[str, Array]]:
    """COMPONENT/MARKER and (n, 2) where the file's outlines lie in the image, by the marked axes."""
    for (component, name), axis in axes_of(annotated, target.model):
        marker = target.model.markers[component, name]
        yield f"{component}/{name}", outline_px(marker, instance_from_axis(component, marker, *axis))

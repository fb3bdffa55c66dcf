"""What speaks against a plane that the scene is said to have."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...core.geometry.field_plane import FieldPlane
from ...core.geometry.scene import Scene
from ...core.geometry.transforms import Array
from ...io.inventory.contents import Item
from ...io.parameters.parameter_file import Setup
from .scene_report import camera_of, samples_of

_MOST_PX = 3.0  # points are clicked or measured to a pixel or so: what takes more of all of them is no such error
_LEAST_PX = 1.0  # no marker that is narrower is seen


def scene_problems(setup: Setup, items: Sequence[Item]) -> Iterator[str]:
    """A line for each, of one parameter file and what lies beside it."""
    said: set[str] = set()
    for sample in samples_of(items) or (None,):
        plane = Scene.of(setup.recognizer.scene, camera_of(items, sample)).plane
        if plane is not None:
            said.update(line for line in (*_askew(plane), *_far(plane, setup)))
    yield from sorted(said)


def _askew(plane: FieldPlane) -> Iterator[str]:
    """Whether the calibrated camera sees a right angle and one unit of length in the plane."""
    if plane.camera is None:
        return
    off, nearby = _skew(plane.matrix[None], plane.camera.matrix)[0], _skew(plane.nearby, plane.camera.matrix)
    by_noise = np.sqrt(((nearby - off) ** 2).sum(axis=0))
    wanted_px = float((np.abs(off) / np.maximum(by_noise, 1e-12)).max()) * plane.config.point_noise_px
    if wanted_px > _MOST_PX:
        yield (
            f"scene.plane: by the calibration its x and y meet at {np.degrees(np.arccos(off[0])):.1f} deg and a metre "
            f"in x is {np.exp(off[1]):.2f} times one in y, as if all points were off by some {wanted_px:.0f} px: check "
            "each of image_points and field_points, and the calibration's focal length"
        )


def _skew(to_plane: Array, K: Array) -> Array:
    """(k, 2) of homographies (k, 3, 3) from the image: the cosine between the plane's x and y, and the logarithm of how
    much longer a unit in x is."""
    axes = (np.linalg.inv(K) @ np.linalg.inv(to_plane))[..., :2]
    length = np.linalg.norm(axes, axis=1)
    cosine = (axes[..., 0] * axes[..., 1]).sum(axis=-1) / length.prod(axis=-1)
    return np.stack([cosine, np.log(length[:, 0] / length[:, 1])], axis=-1)


def _far(plane: FieldPlane, setup: Setup) -> Iterator[str]:
    """Whether markers are of a size to be seen where the points lie."""
    px_per_m = float(np.median(plane.scales(np.reshape(plane.config.image_points, (-1, 2)))))
    for target in setup.targets:
        size_m = max(m.area**0.5 for m in target.model.markers.values())
        if size_m * px_per_m < _LEAST_PX:
            yield (
                f"scene.plane has {px_per_m:.3g} px/m, by which no marker of {target.name} is wider than "
                f"{size_m * px_per_m:.2g} px: are field_points metres?"
            )

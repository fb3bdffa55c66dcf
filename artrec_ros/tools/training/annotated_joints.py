"""Joints of annotated objects: the object file's geometry fitted to the annotated ends of markers' axes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...core.geometry.camera import Camera
from ...core.learning.keypoint_fit import PointFit, Points, fit_points
from ...core.model.kinematics import Kinematics
from ...core.model.objects import ObjectModel
from ...io.learned.annotations import AnnotatedObject

_FOCAL_SHARES = (0.6, 0.8, 1.0, 1.3, 1.7, 2.3, 3.2, 5.0)  # of the image's width: lenses of 80 to 11 degrees
_TRIED = 12  # examples that tell the focal length
_WORST_SHARE = 0.05  # of the object's size in the image: a worse fit is none
_LEAST_WORST_PX = 2.0
_WORST_NOISE_RAD = 0.25  # of a joint that is told


@dataclass(frozen=True)
class JointFitter:
    """Fits one object's joints to annotations. `focal_share`: focal length over image width, None: as calibrated."""

    model: ObjectModel
    kinematics: Kinematics
    camera: Camera | None
    focal_share: float | None

    @classmethod
    def of(cls, model: ObjectModel, objects: Sequence[AnnotatedObject], camera: Camera | None) -> JointFitter | None:
        """None where the object has no place in space, or no joints.

        :param camera: of the annotated images; None: the focal length with which some of the examples fit best.
        """
        if not (model.is_spatial and model.joint_components):
            return None
        kinematics = Kinematics(model)
        if camera is not None:
            return cls(model, kinematics, camera, None)
        step = max(1, len(objects) // _TRIED)
        fitters = [cls(model, kinematics, None, share) for share in _FOCAL_SHARES]
        misfit = []
        for fitter in fitters:
            fits = [fitter._fit(o) for o in objects[::step][:_TRIED]]
            known = [f.rms_px for f in fits if f is not None]
            misfit.append(float(np.median(known)) if len(known) > len(fits) / 2 else np.inf)
        return fitters[int(np.argmin(misfit))]

    def joints(self, objects: Sequence[AnnotatedObject]) -> list[dict[str, float]]:
        """Per object that can be fitted, joint -> its position, of the joints that the points tell."""
        rows = []
        for annotated in objects:
            fit = self._fit(annotated)
            if fit is not None and fit.rms_px <= _worst_px(annotated):
                rows.append(dict(self._told(fit)))
        return [row for row in rows if row]

    def summary(self) -> str:
        """A line about the camera that was used."""
        if self.focal_share is None:
            return "Joints were found with the calibration that was given."
        width_deg = 2 * np.degrees(np.arctan(0.5 / self.focal_share))
        return f"Joints were found as of a lens {width_deg:.0f} degrees wide; --camera-info makes that sure."

    def _told(self, fit: PointFit) -> Iterator[tuple[str, float]]:
        worst = _WORST_NOISE_RAD * self.kinematics.unit
        for n, name in enumerate(self.model.joint_names):
            if fit.q_noise[n] <= worst[n]:
                yield name, float(fit.q[n])

    def _fit(self, annotated: AnnotatedObject) -> PointFit | None:
        points = _points(self.model, annotated)
        camera = self.camera or _assumed_camera(annotated, self.focal_share or 1.0)
        return fit_points(self.kinematics, camera, points)


def _assumed_camera(annotated: AnnotatedObject, focal_share: float) -> Camera:
    """A camera without distortion, its axis through the image's middle."""
    pixels = np.array(list(annotated.points.values()), float).reshape(-1, 2)
    size = annotated.size or tuple(int(v) + 1 for v in pixels.max(axis=0, initial=1.0))
    return Camera.pinhole((size[0], size[1]), focal_share * size[0])


def _worst_px(annotated: AnnotatedObject) -> float:
    pixels = np.array(list(annotated.points.values()), float)
    return max(_LEAST_WORST_PX, _WORST_SHARE * float(np.linalg.norm(np.ptp(pixels, axis=0))))


def _points(model: ObjectModel, annotated: AnnotatedObject) -> Points:
    component, place, normal, pixel = [], [], [], []
    for n, c in enumerate(model.components):
        for marker in c.markers:
            T = marker.T_component_marker
            for end, at in (("tail", marker.tail), ("head", marker.head)):
                known = annotated.points.get(f"{c.name}/{marker.name}.{end}")
                if known is not None and T is not None and marker.disc_radius is None:
                    component.append(n)
                    place.append(T.apply(np.append(at, 0.0)[None])[0])
                    normal.append(T.rotation[:, 2])
                    pixel.append(known)
    shape = (len(pixel), -1) if pixel else (0, 3)
    rows = [np.array(v, float).reshape(shape) for v in (place, normal)]
    return Points(np.array(component, int), rows[0], rows[1], np.array(pixel, float).reshape(-1, 2))

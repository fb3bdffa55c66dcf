"""Camera calibrations: the fields of sensor_msgs/CameraInfo, and calibration files of ROS (camera_calibration)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ...core.base.errors import ConfigError
from ...core.geometry.camera import Camera
from ...core.geometry.transforms import Array
from ..base.kinds import CALIBRATION, mistaken
from ..base.yaml_files import is_finite, load_value, shown

# distortion model -> the numbers of coefficients it may have; OpenCV orders them alike
_MODELS = {"": (0, 4, 5, 8), "plumb_bob": (0, 4, 5), "rational_polynomial": (0, 5, 8)}
_MOST_PX = 1e7  # a focal length or centre beyond it is damage: no lens has such
_VIEW_DEG = 0.5, 170.0  # of a whole image's width, by the focal length alone
_MOST_SKEW = 1e-6  # of the focal length: nothing but rounding, for pixels' rows and columns are perpendicular
_MOST_ASIDE = 2.0  # focal lengths from an image's middle to the optical axis: that is 63 degrees
_MOST_UNLIKE = 10.0  # of two focal lengths, one by the other
_CENTRAL, _MOST_BENT = 0.25, 0.5  # so near the centre, by the corners' distance, no lens bends by such a share


def camera_from_info(
    width: int,
    height: int,
    matrix: Sequence[float],
    distortion: Sequence[float],
    model: str,
    frame_id: str = "",
    binning: tuple[int, int] = (1, 1),
    roi: tuple[int, int, int, int] = (0, 0, 0, 0),
    projection: Sequence[float] | None = None,
) -> Camera:
    """The camera that a CameraInfo message describes, in the units of the image beside it.

    Pixels' centres have integer coordinates, in the full image and in the one beside the message. A pixel of that one
    is a rectangle of full-resolution pixels combined, as CameraInfo defines binning, and its centre is theirs: u = 0 is
    the full image's (b - 1) / 2. image_geometry takes that for 0, which is half a pixel off at most.

    :param width, height: of the full image, pixels. :param matrix: K, nine numbers by rows.
    :param binning: full-resolution pixels per image pixel in x and y; 0 means 1, as in the message.
    :param roi: x_offset, y_offset, width, height of the region of interest in the full image; no width: all of it.
    :param projection: P, twelve numbers by rows, for rectified images: it then holds in place of K, D and their model.
        The baseline in its last column is passed over: poses are this camera's own.
    :raises ConfigError: no calibration (K or P is zero), a model that is not supported, coefficients that don't fit it.
    """
    if projection is None:
        K, D = np.array(matrix, float).reshape(3, 3), _distortion(distortion, model)
    else:
        K, D = np.array(projection, float).reshape(3, 4)[:, :3], np.zeros(0)
    _check_matrix(K, "P, which holds for rectified images, is" if projection is not None else "K is")
    bx, by = (max(1, b) for b in binning)
    x_px, y_px, roi_width, roi_height = roi
    part = roi_width or width, roi_height or height
    size = part[0] // bx, part[1] // by
    if min(size) <= 0:
        raise ConfigError(f"the camera's calibration is for images of {size[0]}x{size[1]} pixels")
    _check_region((x_px, y_px), part, (width, height))
    _check_view(K, D, (width, height))
    K[:2, 2] -= (x_px + (bx - 1) / 2, y_px + (by - 1) / 2)
    K[0] /= bx
    K[1] /= by
    return Camera(matrix=K, distortion=D, size=size, frame_id=frame_id)


def _distortion(coefficients: Sequence[float], model: str) -> Array:
    D = np.array(coefficients, float).reshape(-1)
    if not np.isfinite(D).all():
        raise ConfigError("the camera's distortion holds numbers that are not finite")
    if model not in _MODELS:
        known = ", ".join(m for m in _MODELS if m)
        raise ConfigError(
            f"distortion model {shown(model)} is not supported (supported: {known}); rectify the images, and set "
            "image.rectified"
        )
    if D.size not in _MODELS[model]:
        raise ConfigError(f"distortion model '{model}' cannot have {D.size} coefficients")
    return D


def _check_region(first: tuple[int, int], part: tuple[int, int], whole: tuple[int, int]) -> None:
    if first[0] + part[0] > whole[0] or first[1] + part[1] > whole[1]:
        raise ConfigError(
            f"the camera's region of interest, {part[0]}x{part[1]} pixels from {first} on, reaches beyond its image of "
            f"{whole[0]}x{whole[1]}: width and height are the full image's"
        )


def _check_matrix(K: Array, what: str) -> None:
    if not np.isfinite(K).all():
        raise ConfigError(f"the camera's calibration holds numbers that are not finite ({what} such)")
    if min(K[0, 0], K[1, 1]) < 0:
        raise ConfigError(
            f"the camera's calibration is implausible ({what} of focal lengths {K[0, 0]:g} and {K[1, 1]:g} px; both "
            "are above 0)"
        )
    if K[0, 0] == 0 or K[1, 1] == 0:
        raise ConfigError(f"the camera is not calibrated ({what} without focal length)")
    if max(K[0, 0], K[1, 1], *np.abs(K[:2, 2])) > _MOST_PX or min(K[0, 0], K[1, 1]) < 1 / _MOST_PX:
        raise ConfigError(f"the camera's calibration is implausible ({what} beyond {_MOST_PX:g} px)")
    skew = max(abs(K[0, 1]), abs(K[1, 0]))
    if skew > _MOST_SKEW * K[0, 0]:
        raise ConfigError(f"the camera is no pinhole camera ({what} with a skew of {skew:.3g} px; 0 belongs there)")
    if not np.allclose(K[2], (0, 0, 1), rtol=0, atol=1e-6):  # as a rescaled one may be
        row = ", ".join(f"{v:g}" for v in K[2])
        whose = what.split()[0].rstrip(",")
        raise ConfigError(
            f"the camera's calibration is implausible (the last row of {whose} is {row}; 0, 0, 1 belongs there)"
        )


def _check_view(K: Array, D: Array, size: tuple[int, int]) -> None:
    """Refuses what would place everything wrong, or out of the image, and so find nothing."""
    edges, (low, high) = np.array(size) / 2 / (K[0, 0], K[1, 1]), _VIEW_DEG
    for axis, name in enumerate(("width", "height")):
        view_deg = float(2 * np.degrees(np.arctan(edges[axis])))
        if not low <= view_deg <= high:
            cause = f"was K divided by the image's {name}?" if view_deg > high else "are they those of one image?"
            raise ConfigError(
                f"the camera's calibration is implausible: a focal length of {K[axis, axis]:.3g} px and a {name} of "
                f"{size[axis]} px make {view_deg:.3g} degrees of view; {cause}"
            )
    fx, fy = K[0, 0], K[1, 1]
    if max(fx, fy) > _MOST_UNLIKE * min(fx, fy):
        raise ConfigError(f"the camera's calibration is implausible: focal lengths of {fx:.3g} and {fy:.3g} px")
    off_px = np.abs(K[:2, 2] - np.array(size) / 2)  # of a crop that is a part of a wide image it may be far off that
    if ((off_px > 1.5 * np.array(size)) & (off_px > _MOST_ASIDE * np.array((fx, fy)))).any():
        raise ConfigError(
            f"the camera's calibration is implausible: the optical axis meets an image of {size[0]}x{size[1]} pixels "
            f"at {K[0, 2]:.3g}, {K[1, 2]:.3g}; are these cx and cy, and of this image?"
        )
    k1, k2, p1, p2, k3, k4, k5, k6 = np.pad(D, (0, 8 - D.size))
    r = np.linspace(0, _CENTRAL * np.hypot(*edges), 50)
    r2 = r * r
    with np.errstate(all="ignore"):
        radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        bent = np.abs(radial - 1) + 3 * np.hypot(p1, p2) * r
    if not (bent < _MOST_BENT).all():
        worst = D[np.abs(D).argmax()]
        raise ConfigError(f"the camera's calibration is implausible: no lens has a distortion coefficient of {worst:g}")


def load_camera(path: Path, frame_id: str = "", rectified: bool = False) -> Camera:
    """A calibration file as ROS writes it: image_width, image_height, camera_matrix, distortion_model, ...

    :param rectified: the images are: projection_matrix holds for them.
    :raises ConfigError: naming file and key.
    """
    content = load_value(path, others=True).raw
    if problem := mistaken(content, CALIBRATION):
        raise ConfigError(f"{path}: {problem}")
    if not isinstance(content, dict):
        raise ConfigError(f"{path}: a camera calibration with 'image_width', 'camera_matrix', ... is expected")
    width, height = (int(_numbers(path, content, key, 1)[0]) for key in ("image_width", "image_height"))
    matrix = _numbers(path, content, "camera_matrix", 9)
    has_distortion = "distortion_coefficients" in content
    distortion = _numbers(path, content, "distortion_coefficients", None) if has_distortion else []
    projection = _numbers(path, content, "projection_matrix", 12) if rectified else None
    model, name = str(content.get("distortion_model", "")), str(content.get("camera_name", ""))
    try:
        return camera_from_info(width, height, matrix, distortion, model, frame_id or name, projection=projection)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error


def camera_yaml(camera: Camera) -> str:
    """A calibration file's text; `load_camera` reads it."""

    def matrix(rows: int, values: Any) -> dict[str, Any]:
        numbers = [float(v) for v in np.ravel(values)]
        return {"rows": rows, "cols": len(numbers) // rows, "data": numbers}

    distortion = camera.distortion if camera.distortion.size else np.zeros(5)
    content = {
        "image_width": int(camera.size[0]),
        "image_height": int(camera.size[1]),
        "camera_name": camera.frame_id or "camera",
        "camera_matrix": matrix(3, camera.matrix),
        "distortion_model": "rational_polynomial" if distortion.size > 5 else "plumb_bob",
        "distortion_coefficients": matrix(1, distortion),
        "rectification_matrix": matrix(3, np.eye(3)),
        "projection_matrix": matrix(3, np.column_stack([camera.matrix, np.zeros(3)])),
    }
    return str(yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=120))


def _numbers(path: Path, content: dict[str, Any], key: str, count: int | None) -> list[float]:
    """The numbers under `key`: a plain number, or the `data` of a matrix."""
    if key not in content:
        raise ConfigError(f"{path}: {key}: missing")
    value = content[key]
    if isinstance(value, dict):
        value = value.get("data")
    values = value if isinstance(value, list) else [value]
    if any(isinstance(v, bool) or not isinstance(v, (int, float)) for v in values):
        raise ConfigError(f"{path}: {key}: numbers are expected, not {value!r}")
    if not all(map(is_finite, values)):
        raise ConfigError(f"{path}: {key}: finite numbers are expected")
    if count is not None and len(values) != count:
        raise ConfigError(f"{path}: {key}: {count} number(s) are expected, not {len(values)}")
    return [float(v) for v in values]

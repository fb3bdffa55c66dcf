"""How large a mesh is: the bounding box of an STL file, binary or text."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array

_HEADER, _TRIANGLE = 84, 50  # bytes: 80 and a count; normal, three corners, two bytes more


def stl_bounds(path: Path) -> tuple[Array, Array]:
    """Least and greatest corner (3,) of all triangles, in the file's units. :raises ConfigError: no STL file."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    corners = _binary(data)
    corners = _text(data, path) if corners is None else corners
    if not len(corners) or not np.isfinite(corners).all():
        raise ConfigError(f"{path}: is no STL mesh, or holds no triangle")
    return corners.min(axis=0), corners.max(axis=0)


def _binary(data: bytes) -> Array | None:
    """(n, 3) corners; None: the length is not that of a binary file, which its count of triangles tells."""
    if len(data) < _HEADER or len(data) != _HEADER + _TRIANGLE * struct.unpack_from("<I", data, 80)[0]:
        return None
    rows = np.frombuffer(data, np.uint8, offset=_HEADER).reshape(-1, _TRIANGLE)[:, 12:48]
    return np.ascontiguousarray(rows).view("<f4").reshape(-1, 3).astype(float)


def _text(data: bytes, path: Path) -> Array:
    rows = [line.split()[1:] for line in data.decode("ascii", "replace").splitlines() if line.split()[:1] == ["vertex"]]
    try:
        return np.array(rows, float).reshape(-1, 3)
    except ValueError:
        raise ConfigError(f"{path}: is no STL mesh: a vertex has no three coordinates") from None

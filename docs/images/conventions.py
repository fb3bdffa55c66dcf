"""Draws docs/images/conventions.png: the image, a marker in it, and the frames, projected as the package does."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Array, Pose
from artrec_ros.core.model.objects import Box
from artrec_ros.simulation.simulator import pinhole_camera
from artrec_ros.simulation.surfaces import box_faces

SIZE, AXES = (1000, 560), ((0, 0, 220), (0, 150, 0), (220, 90, 0))  # x red, y green, z blue; BGR
INK = (40, 40, 40)
EYE = np.array([-1.1, -2.1, 1.15])  # from where it is drawn, metres


def look_at(eye: ArrayLike, target: ArrayLike) -> Pose:
    """T_view_world of a camera at `eye` that looks at `target`; the world's z is up."""
    ahead = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(ahead, (0, 0, 1))
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(ahead, right), ahead])
    return Pose(R, -R @ np.asarray(eye, float))


class Drawing:
    """A picture of a world of metres."""

    def __init__(self) -> None:
        self.picture: NDArray[np.uint8] = np.full((SIZE[1], SIZE[0], 3), 255, np.uint8)
        self.camera, self.view = pinhole_camera(SIZE, 40), look_at(EYE, (0.6, 0.0, 0.26))

    def pixels(self, points: ArrayLike) -> Array:
        return project(self.camera, self.view.apply(np.atleast_2d(np.asarray(points, float))))

    def polygon(self, points: ArrayLike, fill: tuple[int, int, int] | None, line: tuple[int, int, int] = INK) -> None:
        corners = np.rint(self.pixels(points)).astype(np.int32)
        if fill is not None:
            cv2.fillPoly(self.picture, [corners], fill, cv2.LINE_AA)
        cv2.polylines(self.picture, [corners], True, line, 1, cv2.LINE_AA)

    def frame(self, T: Pose, length: float, name: str, shift: tuple[int, int]) -> None:
        ends = self.pixels(T.apply(np.vstack([np.zeros(3), np.eye(3) * length])))
        for axis, end, colour in zip("xyz", ends[1:], AXES, strict=True):
            cv2.arrowedLine(self.picture, _at(ends[0]), _at(end), colour, 3, cv2.LINE_AA, tipLength=0.12)
            self.text(axis, end + 0.12 * (end - ends[0]) + (-4, 5), colour, 0.6)
        self.text(name, ends[0] + shift)

    def text(self, words: str, at: Array, colour: tuple[int, int, int] = INK, scale: float = 0.55) -> None:
        cv2.putText(self.picture, words, _at(at), cv2.FONT_HERSHEY_SIMPLEX, scale, colour, 1, cv2.LINE_AA)


def _at(pixel: Array) -> tuple[int, int]:
    return int(round(pixel[0])), int(round(pixel[1]))


def main() -> None:
    d = Drawing()
    # the world: x along the line of sight, y left, z up; the camera at the left, an object before it
    optical = Pose(np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]]), np.array([0.0, 0, 0.35]))  # T_world_camera
    body = Pose(np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]), np.array([1.3, 0.0, 0.2]))  # x to the camera's right
    image_at = 0.55  # metres ahead of the lens
    corners = np.array([[-0.3, -0.22, 1], [0.3, -0.22, 1], [0.3, 0.22, 1], [-0.3, 0.22, 1]]) * image_at
    for corner in optical.apply(corners * 2.2):
        d.polygon([optical.position, corner], None, (205, 205, 205))
    for face in box_faces(Box(Pose.identity(), np.array([0.5, 0.3, 0.24])), 0):
        flat = face.moved(body)
        if flat.normal @ (EYE - flat.corners[0]) > 0:
            d.polygon(flat.corners, (238, 238, 238), (150, 150, 150))
    # on its right side, which the camera sees
    patch = Pose(np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]), np.array([0.0, -0.151, 0.0]))
    T_world_marker = body @ patch
    outline = np.array([[-0.16, -0.09, 0], [0.16, -0.09, 0], [0.16, 0.02, 0], [0.05, 0.09, 0], [-0.16, 0.09, 0]])
    d.polygon(T_world_marker.apply(outline), (190, 200, 255))
    seen = optical.inverse().apply(T_world_marker.apply(outline))
    d.polygon(optical.apply(corners), (250, 246, 236))
    d.polygon(optical.apply(seen / seen[:, 2:] * image_at), (190, 200, 255))
    ends = optical.inverse().apply(T_world_marker.apply([[-0.16, 0, 0], [0.16, 0, 0]]))
    tail, head = d.pixels(optical.apply(ends / ends[:, 2:] * image_at))
    cv2.arrowedLine(d.picture, _at(tail), _at(head), INK, 2, cv2.LINE_AA, tipLength=0.15)
    origin, along_x, along_y = d.pixels(
        optical.apply([corners[0], corners[0] + (0.16, 0, 0), corners[0] + (0, 0.16, 0)])
    )
    for end, name, colour in ((along_x, "x, px", AXES[0]), (along_y, "y, px", AXES[1])):
        cv2.arrowedLine(d.picture, _at(origin), _at(end), colour, 2, cv2.LINE_AA, tipLength=0.15)
        d.text(name, end + (-14, -8) if name[0] == "x" else end + (8, 6), colour)
    d.text("image", d.pixels(optical.apply(corners[3:4]))[0] + (-24, 40))
    d.frame(optical, 0.28, "camera's optical frame", (-175, 46))
    d.frame(body, 0.42, "object: x forward, y left, z up", (-60, 120))
    d.frame(T_world_marker, 0.2, "marker: z towards the camera", (-172, -112))
    cv2.imwrite(str(Path(__file__).with_suffix(".png")), d.picture)


if __name__ == "__main__":
    main()

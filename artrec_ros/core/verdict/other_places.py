"""How sure the places are of flat objects whose seen parts look like other parts of them, laid otherwise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.transforms import Array, Pose
from ..model.found import Detection, ImagePose, Instance, OtherPlace
from ..pose.exchanges import OFF
from ..pose.finder import WholeObjectFinder
from ..pose.other_layouts import Layouts
from ..pose.poses import Poses
from ..pose.surface_model import SpatialModel


def beside_other_places(
    finder: WholeObjectFinder,
    camera: Camera,
    layouts: Layouts,
    names: Sequence[int | None],
    detections: Sequence[Detection],
) -> list[Detection]:
    """H detections, whose scores count how probable each is among its layouts, with the likeliest other one beside it;
    a component's score counts all those that leave it where it is. Who is turned about a lone component is where it is
    seen, whichever way: that share is one of `as_told`.

    :param names: of each its identity; None: of any.
    """
    surface, shares, h = finder.surface, layouts.shares(names), len(detections)
    places = _places(surface, camera, layouts.poses)
    off_px = np.linalg.norm(places[h:, :, :2] - places[layouts.of, :, :2], axis=2)
    same = off_px < OFF * (np.sqrt(surface.area[surface.markers]) * places[layouts.of, :, 3])
    stays = np.repeat(shares[:h, None], places.shape[1], axis=1)
    np.add.at(stays, layouts.of, same * shares[h:, None])
    out = list(detections)
    for n in sorted(set(layouts.of[layouts.by_seen].tolist())):
        d, others = detections[n], h + np.flatnonzero(layouts.of == n)
        parts = tuple(replace(c, score=c.score * float(stays[n, _row(surface, c)])) for c in d.components)
        best, told = int(others[np.argmax(shares[others])]), float(shares[n])
        lies = _laid(finder, d, places[best])
        place = OtherPlace(lies, float(shares[best]))
        if len(others) == 1 == len(d.components):
            pose = layouts.poses[best : best + 1]
            place = replace(place, told=_turned_there(finder, d, lies, places[best], pose, camera))
        likely = place.probability > finder.config.verdict.least_other_turn * (place.probability + told)
        out[n] = replace(
            d,
            score=d.score * told,
            as_told=d.as_told * (told if len(d.components) == 1 else 1.0),  # about a lone one it turns: that is there
            components=parts,
            other_place=place if likely else None,
        )
    return out


def _laid(finder: WholeObjectFinder, detection: Detection, places: Array) -> ImagePose:
    """The required component's place. :param places: (M, 4) of all markers."""
    shown = detection.instance_of(finder.target.model.required.name)
    root = finder.surface.markers.tolist().index(finder.surface.markers_of[finder.root][0])
    return ImagePose(*places[root if shown is None else _row(finder.surface, shown)].tolist())


def _turned_there(
    finder: WholeObjectFinder, d: Detection, image: ImagePose, places: Array, pose: Poses, camera: Camera
) -> Detection:
    """An object of which one component is told, as it is told there. :param places: (M, 4) of all markers."""
    surface, (width, height) = finder.surface, camera.size
    names = [c.name for c in surface.model.components]
    at = {names[c]: row for row, c in reversed(list(enumerate(surface.component[surface.markers].tolist())))}
    missing = [replace(m, x=float(places[at[m.component], 0]), y=float(places[at[m.component], 1])) for m in d.missing]
    (part,) = d.components
    x, y, theta, scale = places[_row(surface, part)].tolist()
    return replace(
        d,
        image=image,
        pose=None if d.pose is None else Pose(pose.R[0], pose.t[0]),
        components=(replace(part, x=x, y=y, theta=theta, scale=scale),),
        missing=tuple(
            replace(m, state="not seen" if 0 <= m.x < width and 0 <= m.y < height else "out of view") for m in missing
        ),
    )


def _row(surface: SpatialModel, part: Instance) -> int:
    """Which of all markers shows a component."""
    names = [c.name for c in surface.model.components]
    shown = ((surface.patches[p].component, surface.patches[p].marker) for p in surface.markers.tolist())
    return next(
        row
        for row, (c, marker) in enumerate(shown)
        if marker is not None and (names[c], marker.name) == (part.component, part.marker)
    )


def _places(surface: SpatialModel, camera: Camera, poses: Poses) -> Array:
    """(H, M, 4) x, y, theta and scale of all markers, as of `Instance`."""
    frames = surface.kinematics.seen(poses.R, poses.t, poses.q)
    points = np.concatenate([surface.patches[p].drawn[:3] for p in surface.markers.tolist()])
    X = surface.place(frames, points, np.repeat(surface.component[surface.markers], 3))
    pixels = project(camera, X).reshape(len(poses), -1, 3, 2)
    along = pixels[:, :, 2] - pixels[:, :, 1]
    turn, scale = np.arctan2(along[..., 1], along[..., 0]), camera.focal_px / X[:, ::3, 2]
    return np.concatenate([pixels[:, :, 0], turn[..., None], scale[..., None]], axis=2)

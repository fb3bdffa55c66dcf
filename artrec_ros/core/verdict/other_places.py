"""How sure the places are of objects whose seen parts look like other parts of them, laid otherwise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.transforms import Array, Pose
from ..image.image_frame import ImageFrame
from ..model.found import Detection, ImagePose, Instance, OtherPlace
from ..pose.exchanges import OFF
from ..pose.finder import WholeObjectFinder
from ..pose.laid_otherwise import LaidOtherwise
from ..pose.other_layouts import Layouts
from ..pose.poses import Poses
from ..pose.surface_model import SpatialModel
from ..pose.unseen import in_view


def beside_other_places(
    finder: WholeObjectFinder,
    frame: ImageFrame,
    layouts: Layouts,
    names: Sequence[int | None],
    detections: Sequence[Detection],
) -> list[Detection]:
    """H detections found flat, each beside its layouts by what is seen. :param names: of each its identity; None: of
    any."""
    shares, h, out = layouts.shares(names), len(detections), list(detections)
    for n in sorted(set(layouts.of[layouts.by_seen].tolist())):
        rows = [n, *(h + np.flatnonzero(layouts.of == n)).tolist()]
        out[n] = _beside(finder, frame, layouts.poses[rows], shares[rows], out[n])
    return out


def beside_laid_otherwise(
    finder: WholeObjectFinder, frame: ImageFrame, pose: Poses, laid: LaidOtherwise | None, detection: Detection
) -> Detection:
    """One that is found in space; or one that faces the camera, whose long markers' ends may be elsewhere."""
    if laid is None:
        return detection
    if finder.facing:
        return _beside_ends(finder, frame, Poses.concatenate([pose, laid.poses]), laid.shares(), detection)
    return _beside(finder, frame, Poses.concatenate([pose, laid.poses]), laid.shares(), detection)


def beside_its_rivals(
    finder: WholeObjectFinder, camera: Camera, poses: Poses, shares: Array, d: Detection
) -> Detection:
    """A detection that may be another object of its target. :param poses, shares: as of `_beside`; all shares need not
    be 1 together."""
    return _laid_beside(finder, _places(finder.surface, camera, poses), shares, d, there=True)[0]


def _beside(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, shares: Array, d: Detection) -> Detection:
    """A detection whose score counts how probable it is among its layouts, with the likeliest other one beside it; a
    component's score counts all those that leave it where it is. What faces the camera and is turned about a lone
    component is where that is seen, whichever way: that share is one of `as_told`.

    :param poses: the one that is told, and the others. :param shares: probability of each.
    """
    places, turns = _places(finder.surface, frame.camera, poses), finder.facing and len(d.components) == 1
    out, best = _laid_beside(finder, places, shares, d, there=turns)
    place = out.other_place
    if turns and len(poses) == 2 and place is not None and place is not d.other_place:
        there = _turned_there(finder, d, place.image, places[best], poses[best : best + 1], frame)
        out = replace(out, other_place=replace(place, told=there))
    return out


def _laid_beside(
    finder: WholeObjectFinder, places: Array, shares: Array, d: Detection, *, there: bool
) -> tuple[Detection, int]:
    """As `_beside`, and which of its places is the likeliest other one.

    :param places: (H, M, 4) of all markers. :param there: whether there is one in any case.
    """
    surface = finder.surface
    off_px = np.linalg.norm(places[:, :, :2] - places[0, :, :2], axis=2)
    stays = shares @ (off_px < OFF * (np.sqrt(surface.area[surface.markers]) * places[0, :, 3]))
    parts = tuple(replace(c, score=c.score * float(stays[_row(surface, c)])) for c in d.components)
    best, told = 1 + int(np.argmax(shares[1:])), float(shares[0])
    place = OtherPlace(_laid(finder, d, places[best]), float(shares[best]), there=there)
    likely = place.probability > finder.config.verdict.least_other_turn * (place.probability + told)
    as_told = d.as_told * (told if there else 1.0)
    out = replace(d, score=d.score * told, as_told=as_told, components=parts)
    return replace(out, other_place=place) if likely else out, best


def _beside_ends(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, shares: Array, d: Detection) -> Detection:
    """As `_beside`. It is there, and so are its components, be they smaller or larger."""
    best, told = 1 + int(np.argmax(shares[1:])), float(shares[0])
    lies = _laid(finder, d, _places(finder.surface, frame.camera, poses)[best])
    place = OtherPlace(lies, float(shares[best]), there=True)
    likely = place.probability > finder.config.verdict.least_other_turn * (place.probability + told)
    return replace(d, score=d.score * told, as_told=d.as_told * told, other_place=place if likely else d.other_place)


def _laid(finder: WholeObjectFinder, detection: Detection, places: Array) -> ImagePose:
    """The required component's place. :param places: (M, 4) of all markers."""
    shown = detection.instance_of(finder.target.model.required.name)
    root = finder.surface.markers.tolist().index(finder.surface.markers_of[finder.root][0])
    return ImagePose(*places[root if shown is None else _row(finder.surface, shown)].tolist())


def _turned_there(
    finder: WholeObjectFinder, d: Detection, image: ImagePose, places: Array, pose: Poses, frame: ImageFrame
) -> Detection:
    """An object of which one component is told, as it is told there. :param places: (M, 4) of all markers."""
    surface, (width, height) = finder.surface, frame.camera.size
    names = [c.name for c in surface.model.components]
    at = {names[c]: row for row, c in reversed(list(enumerate(surface.component[surface.markers].tolist())))}
    missing = [replace(m, x=float(places[at[m.component], 0]), y=float(places[at[m.component], 1])) for m in d.missing]
    bare = in_view(finder, frame, pose, finder.voter.judge(frame, pose, occlusion=True)).lacking[0]
    (part,) = d.components
    x, y, theta, scale = places[_row(surface, part)].tolist()
    return replace(
        d,
        image=image,
        pose=None if d.pose is None else Pose(pose.R[0], pose.t[0]),
        components=(replace(part, x=x, y=y, theta=theta, scale=scale),),
        missing=tuple(
            replace(m, state="not seen" if bare[at[m.component]] or in_image else "out of view")
            for m, in_image in ((m, 0 <= m.x < width and 0 <= m.y < height) for m in missing)
        ),
    )


def may_lie_as(finder: WholeObjectFinder, camera: Camera, pose: Poses, d: Detection) -> bool:
    """Whether a detection of which components may lie on other blobs has all its components, or these blobs, where
    another pose puts them; what they carry goes along."""
    parent, names = finder.surface.kinematics.parent, [c.name for c in finder.target.model.components]
    elsewhere = {names.index(m.component): (m.x, m.y) for m in d.missing if d.instance_of(m.component) is not None}
    if not elsewhere:
        return False
    surface, (places,) = finder.surface, _places(finder.surface, camera, pose)
    for part in d.components:
        component, row = names.index(part.component), _row(surface, part)
        above, at = parent[component], [(part.x, part.y), *([elsewhere[component]] if component in elsewhere else ())]
        while above >= 0 and above not in elsewhere:
            above = parent[above]
        off_px = np.linalg.norm(np.array(at) - places[row, :2], axis=1).min()
        if above < 0 and off_px > OFF * (np.sqrt(surface.area[surface.markers[row]]) * places[row, 3]):
            return False
    return True


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

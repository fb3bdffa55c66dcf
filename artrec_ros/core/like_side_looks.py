"""Second looks at rigid objects with like sides that leave blobs unexplained: for another side in the place of the one
that is seen, which has something of the object where these blobs are."""

from __future__ import annotations

from collections.abc import Sequence

from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .model.kinematics import Frames
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .verdict.left_over import LeftOvers
from .verdict.verdicts import Verdict


def by_other_sides(
    finder: WholeObjectFinder,
    left_overs: LeftOvers,
    verdict: Verdict,
    frame: ImageFrame,
    accepted: Sequence[Verdict],
    blobs: Sequence[Blob],
) -> Poses:
    """Poses through the middles of what is seen and of what is left over, the few with most votes."""
    sides, camera = finder.like_sides, frame.camera
    others = sides.of(verdict.claim.poses)
    stand = frame.scene.may_stand(others.poses.R, others.poses.t, finder.config.guesses.standing_slack)
    confirmed = frozenset(c for c, yes in enumerate(verdict.confirmed) if yes)
    seen = [sides.seen_as(k, confirmed) if up else set() for k, up in zip(others.side.tolist(), stand, strict=True)]
    frames = finder.surface.kinematics.seen(others.poses.R, others.poses.t, others.poses.q)
    # its body explains nothing: that lies otherwise, then
    rivals, blobs = [v for v in accepted if v is not verdict], left_overs.beside(blobs, verdict, camera)
    left = left_overs.of(seen, frames, frame, blobs, rivals, _turned_away(finder, frames))
    found = [finder.surface.no_poses]
    for h in (h for h, one in enumerate(left) if one.blobs):
        shown = [finder.surface.markers_of[c][0] for c in sorted(seen[h])]
        for some in left[h].choices:
            middles = left_overs.middles(others.poses[h : h + 1], shown, left[h], camera, some)
            found.append(finder.through_middles.begun(camera, others.poses[h : h + 1], middles))
    search = finder.config.search
    return finder.fit_all(frame, Poses.concatenate(found)).best(search.flip_keep, search).poses


def _turned_away(finder: WholeObjectFinder, frames: Frames) -> list[set[int]]:
    """Of each of some objects the components of which no marker faces the camera."""
    surface, m = finder.surface, finder.surface.markers
    of = surface.component[m]
    normals = (frames.R[:, of] @ surface.normal[m][..., None])[..., 0]
    faces = (normals * surface.place(frames, surface.centre[m], of)).sum(axis=-1) < 0
    return [set(of.tolist()) - set(of[row].tolist()) for row in faces]

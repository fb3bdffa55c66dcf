"""What the search of one image has found, and what of the image that leaves."""

from __future__ import annotations

from functools import cache, partial

from .base.config import SearchConfig
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .verdict.claims import silhouette
from .verdict.judge import Judge


class Finds:
    """Hypotheses of all targets. :ivar frame: without the pixels of sure objects."""

    def __init__(self, frame: ImageFrame, judge: Judge, config: SearchConfig) -> None:
        self.frame = frame
        self._judge, self._config = judge, config
        self._found: dict[WholeObjectFinder, list[Poses]] = {}
        self._left: dict[WholeObjectFinder, ImageFrame] = {}  # without the pixels of its likely objects, too

    @property
    def candidates(self) -> list[tuple[WholeObjectFinder, Poses]]:
        """All of each target."""
        return [(finder, Poses.concatenate(poses)) for finder, poses in self._found.items()]

    def left_to(self, finder: WholeObjectFinder) -> ImageFrame:
        """The frame in which a target's further objects are looked for."""
        return self._left.get(finder, self.frame)

    def keep(self, finder: WholeObjectFinder, poses: Poses) -> None:
        """Hypotheses that take no pixels, the best one first."""
        self._found.setdefault(finder, []).append(poses)

    def take(self, finder: WholeObjectFinder, poses: Poses, least: float | None = None) -> bool:
        """Keep hypotheses, the best one first; whether that is a sure object, which takes its pixels.

        A likely one may share them with a rival, but its own target's is not sought for them again. One whose required
        component has no place of its own takes none: whose it lies across is yet to be found.

        :param least: trust that makes it sure; what has less is not kept: its blobs are looked at again.
        """
        trust, placed = self._judge.trust_and_place(finder, poses, self.frame)
        sure = placed and trust > (self._config.sure if least is None else least)
        if least is not None and not sure:
            return False
        self.keep(finder, poses)
        if placed and (sure or trust > self._config.likely):
            self._hide(finder, poses[:1], sure=sure)
        return sure

    def _hide(self, finder: WholeObjectFinder, pose: Poses, *, sure: bool) -> None:
        rest = cache(partial(ImageFrame.without, solids=silhouette(finder.surface, self.frame.camera, pose)))
        self._left.setdefault(finder, self.frame)
        for other in self._left if sure else (finder,):
            self._left[other] = rest(self._left[other])  # several finders may still share one
        if sure:
            self.frame = rest(self.frame)

    def explains(self, blob: Blob, to: WholeObjectFinder | None = None) -> bool:
        """Whether sure objects own a blob's pixels. :param to: or likely ones of this target."""
        frame = self.frame if to is None else self.left_to(to)
        return frame.field.owned_share(blob.contour) > self._config.explained

"""Whether parameters leave anything of images in which objects could be looked for."""

from __future__ import annotations

from collections.abc import Iterator

from ...core.blobless import blobless
from ...core.geometry.scene import Scene
from ...core.image.blobs import centres, find_blobs
from ...core.image.contour_kernels import outlines
from ...core.image.segmentation import Segmenter
from ...io.inventory.contents import Sample
from ...io.parameters.parameter_file import Setup
from ..getting_ready import tell_of_compiling


def nothing_left(setup: Setup, sample: Sample) -> Iterator[str]:
    """Where none of a sample's images has a blob to look at: why, of the first; a line for each object.

    :raises ImageError: the images are not of the kind that the parameters name.
    """
    segmenter, config, scene = Segmenter(setup.image), setup.recognizer, Scene.of(setup.recognizer.scene)
    wanted = {label for t in setup.targets for label in t.labels}
    tell_of_compiling(outlines)
    read = [segmenter.labels(image) for image in sample.images]
    for labels in read:
        if scene.inside(centres(find_blobs(labels, wanted, config, segmenter.blank))).any():
            return
    for labels in read[:1]:
        for rejection in blobless(labels, setup.targets, config.min_blob_px, segmenter.blank, scene):
            yield f"'{rejection.object}' has nothing to be found in: {rejection.reason}"

"""Recognisers of what is found marker by marker, with the tests' own parameters."""

from cranes import CRANE, RED
from scene import crane
from settings import settings

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer

SIZE = (420, 240)


def recognizer(*targets, **options):
    """Of some targets, or of the crane."""
    targets = targets or (Target("crane", crane(), RED, CRANE),)
    return Recognizer(targets, settings(**options), Segmenter(ImageConfig()))

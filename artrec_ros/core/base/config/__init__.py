"""Every tunable value, once: default, unit, range and meaning. The node's parameters, the YAML
reader and the tools' options derive from these dataclasses; nothing repeats a default."""

from .alignment import AlignmentConfig
from .blobs import BlobsConfig
from .constraints import ConstraintsConfig
from .covariance import CovarianceConfig
from .design import DesignConfig
from .existence import ExistenceConfig
from .facing import FacingConfig
from .fit import FitConfig
from .grouping import GroupingConfig
from .guesses import GuessesConfig
from .image import GREATEST_LABEL, ClassConfig, ImageConfig
from .learning import LearningConfig
from .middles import MiddlesConfig
from .node import NodeConfig
from .paper import PaperConfig
from .params import PATHS, param, room, rooms_of, validate
from .recall import RecallConfig
from .recognition import ObjectConfig, RecognizerConfig
from .scene import FloorConfig, PlaneConfig, SceneConfig
from .seams import SeamsConfig
from .search import SearchConfig
from .sightings import SightingsConfig
from .time import TimeConfig
from .tracking import TrackingConfig
from .verdict import VerdictConfig
from .votes import VotesConfig

__all__ = [
    "GREATEST_LABEL",
    "PATHS",
    "AlignmentConfig",
    "BlobsConfig",
    "ClassConfig",
    "ConstraintsConfig",
    "CovarianceConfig",
    "DesignConfig",
    "ExistenceConfig",
    "FacingConfig",
    "FitConfig",
    "FloorConfig",
    "GroupingConfig",
    "GuessesConfig",
    "ImageConfig",
    "LearningConfig",
    "MiddlesConfig",
    "NodeConfig",
    "ObjectConfig",
    "PaperConfig",
    "PlaneConfig",
    "RecallConfig",
    "RecognizerConfig",
    "SceneConfig",
    "SeamsConfig",
    "SearchConfig",
    "SightingsConfig",
    "TimeConfig",
    "TrackingConfig",
    "VerdictConfig",
    "VotesConfig",
    "param",
    "room",
    "rooms_of",
    "validate",
]

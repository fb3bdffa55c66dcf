"""What to look for, and how."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..errors import ConfigError
from .alignment import AlignmentConfig
from .blobs import BlobsConfig
from .constraints import ConstraintsConfig
from .covariance import CovarianceConfig
from .facing import FacingConfig
from .fit import FitConfig
from .grouping import GroupingConfig
from .guesses import GuessesConfig
from .image import GREATEST_LABEL
from .middles import MiddlesConfig
from .paper import PaperConfig
from .params import param, room, validate
from .recall import RecallConfig
from .scene import SceneConfig
from .seams import SeamsConfig
from .search import SearchConfig
from .time import TimeConfig
from .verdict import VerdictConfig
from .votes import VotesConfig


@dataclass(frozen=True)
class ObjectConfig:
    """One object to look for."""

    object_file: str = param("", "what the object is; a path relative to the parameter file, or package://PACKAGE/PATH")
    constraint_file: str = param("", "what was learned about it by artrec train; empty: nothing, poses in space only")
    label: int = param(
        0,
        "class number of its pixels, where its components have none of their own; told in any case",
        low=1,
        high=GREATEST_LABEL,
    )


@dataclass(frozen=True)
class RecognizerConfig:
    """The recogniser's parameters: what users understand, then each room's own, which only experts change."""

    profile: str = param(
        "default", "default, or paper: the published method with its values", choices=("default", "paper")
    )
    whole_object: bool = param(
        True,
        "find objects as a whole where all markers have places: in space where the camera is calibrated, else flat "
        "ones in the image plane",
        paths=("plane", "space", "facing"),
    )
    time_budget_ms: float = param(
        5000.0, "a frame's search ends here with what was found by then", unit="ms", low=1, high=600000
    )
    min_blob_px: int = param(
        8,
        "blobs with fewer pixels are specks, and markers that show fewer say nothing",
        unit="px^2",
        low=1,
        high=1000000,
    )
    min_components: int = param(
        0,
        "least components found (no more than the object has); 0: two of what is found part by part, the required "
        "one included, the required one of what is found as a whole",
        low=0,
        high=100,
    )
    required: str = param(
        "strict",
        "strict: there is no object without its required component, of which part will do where others are seen; "
        "visible: where that is turned away, hidden, out of the image or without labels the others may suffice",
        choices=("strict", "visible"),
        paths=("space", "facing"),
    )
    min_scale: float = param(0.0, "least scale to look for", unit="px/m", low=0, paths=("plane", "space", "facing"))
    max_scale: float = param(
        0.0, "greatest scale to look for; 0: any", unit="px/m", low=0, paths=("plane", "space", "facing")
    )
    min_range_m: float = param(
        0.0,
        "least distance to look for, of the middle of the required component, along the optical axis; the z of a pose "
        "is that of the object's own frame and may be less or more; calibrated images only",
        unit="m",
        low=0,
        paths=("plane", "space"),
        calibrated=True,
    )
    max_range_m: float = param(
        0.0,
        "greatest distance to look for, measured as min_range_m; 0: any; calibrated images only",
        unit="m",
        low=0,
        paths=("plane", "space"),
        calibrated=True,
    )
    max_slant_deg: float = param(
        0.0,
        "markers may be turned out of the image plane by so much and be seen squeezed; 0: none is",
        unit="deg",
        low=0,
        high=75,
        paths=("plane",),
    )
    min_match: float = param(
        0.55, "least share of a shape's visible outline that must match", low=0, high=1, paths=("plane",)
    )
    min_probability: float = param(
        0.4,
        "least probability of a whole object by what is seen of it; its score may be less, where patches like its own "
        "lie about, or blobs are left that may be parts of it (as_told)",
        low=0,
        high=1,
        paths=("space", "facing"),
    )
    min_component_probability: float = param(
        0.4,
        "least probability that a component of an object found as a whole lies on its own marker, where the "
        "object's pose is right; others, and joints that no component tells, are left out",
        low=0,
        high=1,
        paths=("space", "facing"),
    )
    min_identity_probability: float = param(
        0.8,
        "least probability, against the next best, of which one of several like objects it is; below it none is told",
        low=0.5,
        high=1,
        paths=("space", "facing"),
    )
    min_class_seen: float = param(
        0.7,
        "least share of a class's components, or joints, that an object must show to be of it",
        low=0,
        high=1,
        paths=("plane", "space", "facing"),
    )
    min_class_confidence: float = param(
        0.5, "least confidence of a class; below it there is none", low=0, high=1, paths=("plane", "space", "facing")
    )
    memory: bool = param(
        True,
        "what frames before told of an object, its name and turn counts, too; of what is found as a whole its place is "
        "looked at first, and in space blobs that were searched in vain wait their turn; else each frame is judged by "
        "itself",
        paths=("plane", "space", "facing"),
    )
    refresh_s: float = param(
        1.0,
        "what is remembered of each blob is searched in full again within this time",
        unit="s",
        low=0.001,
        high=3600,
        paths=("space", "facing"),
    )
    threads: int = param(
        0,
        "so many look at a frame's blobs and known objects side by side, with the same results; 0: one for each core",
        low=0,
        high=1024,
        paths=("space",),
    )
    scene: SceneConfig = field(default_factory=SceneConfig)
    time: TimeConfig = room(TimeConfig)
    blobs: BlobsConfig = room(BlobsConfig)
    seams: SeamsConfig = room(SeamsConfig)
    alignment: AlignmentConfig = room(AlignmentConfig)
    constraints: ConstraintsConfig = room(ConstraintsConfig)
    grouping: GroupingConfig = room(GroupingConfig)
    guesses: GuessesConfig = room(GuessesConfig)
    middles: MiddlesConfig = room(MiddlesConfig)
    facing: FacingConfig = room(FacingConfig)
    votes: VotesConfig = room(VotesConfig)
    search: SearchConfig = room(SearchConfig)
    fit: FitConfig = room(FitConfig)
    covariance: CovarianceConfig = room(CovarianceConfig)
    verdict: VerdictConfig = room(VerdictConfig)
    recall: RecallConfig = room(RecallConfig)
    paper: PaperConfig = room(PaperConfig)

    @property
    def min_in_plane(self) -> int:
        """Least components of an object in the image plane."""
        return self.min_components or 2

    @property
    def in_doubt(self) -> bool:
        """Whether scores are probabilities, to which what other frames say is added."""
        return self.profile == "default" and self.memory

    def __post_init__(self) -> None:
        validate(self, "recognizer.")
        for least, most, unit in (("min_scale", "max_scale", "px/m"), ("min_range_m", "max_range_m", "m")):
            low, high = getattr(self, least), getattr(self, most)
            if 0 < high < low:
                raise ConfigError(f"recognizer.{most}: {high} {unit} is below {least} {low}; 0 means any")

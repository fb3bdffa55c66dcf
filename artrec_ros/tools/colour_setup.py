"""The objects whose colours `artrec learn-colours` learns, from a parameter file that has no colours yet."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from ..core.base.config import ClassConfig, ImageConfig, PlaneConfig, RecognizerConfig
from ..core.base.errors import ConfigError
from ..core.model.target import Target
from ..io.parameters.parameter_file import image_from_flat, setup_from_flat
from ..io.parameters.sections import read_files
from .colour_samples import GIVEN

_READ = "image.blank", *(f"image.{name}" for name in GIVEN)


@dataclass(frozen=True)
class ColourSetup:
    """The objects, and the rectangles to ignore.

    :param labels: of the classes that axes show, by name: those of markers, and of bodies of what lies flat.
    :param bodies: those of them that are of bodies alone.
    :param hidden: of the classes that axes do not show: those of other bodies alone, and of no object.
    :param ranged: classes that the files give by ranges of hue, saturation and value, which stay as they are.
    :param plane: on which objects lie. :param camera: how images are smoothed and evened, and what is known of them.
    :param gamma_known: whether somebody has told their gamma. :param min_scale, min_blob_px: of `RecognizerConfig`.
    """

    targets: tuple[Target, ...]
    labels: Mapping[str, int]
    blank: tuple[int, ...]
    bodies: frozenset[str] = frozenset()
    hidden: Mapping[str, int] = field(default_factory=dict)
    ranged: Mapping[str, ClassConfig] = field(default_factory=dict)
    plane: PlaneConfig = PlaneConfig()
    camera: ImageConfig = ImageConfig()
    gamma_known: bool = False
    min_scale: float = RecognizerConfig.min_scale
    min_blob_px: int = RecognizerConfig.min_blob_px

    def in_label_images(self) -> ColourSetup:
        """The same where all classes are seen, those of any bodies, too."""
        labels, bodies = {**self.labels, **self.hidden}, self.bodies | {*self.hidden}
        return replace(self, labels=labels, bodies=bodies, hidden={})


def load_colour_setup(paths: Sequence[Path], more: Mapping[str, int]) -> ColourSetup:
    """From a node's parameter files; of their `image` only names, labels and ranges of classes, and what `_READ` lists,
    are read.

    A class is named by `more` (name -> label), by `image.classes`, or by the object or component whose label it is.
    """
    flat, folder, source = read_files(*paths)
    classes = [
        *(flat.get("image.classes") or []),
        *(name for name in more if name not in flat.get("image.classes", [])),
    ]
    kept = {k: v for k, v in flat.items() if k.split(".")[0] != "image" and not k.endswith(".constraint_file")}
    kept |= {k: flat[k] for k in (*_READ, *_of_classes(classes, flat)) if k in flat}
    kept |= {f"image.{name}.label": label for name, label in more.items()}
    kept |= {"image.classes": classes} if classes else {}
    if more and "objects" not in flat:  # what is known of the camera alone
        image = image_from_flat({k: v for k, v in kept.items() if k.startswith("image.")}, source)
        labels = {name: cls.label for name, cls in image.classes.items()}
        return ColourSetup((), labels, image.blank, camera=_camera(image), gamma_known="image.gamma" in flat)
    setup = setup_from_flat(kept, folder, source)
    named = {cls.label: name for name, cls in reversed(setup.image.classes.items())} | {n: k for k, n in more.items()}
    labels, hidden = dict[str, int](), dict[str, int]()
    ranged = {name: cls for name, cls in setup.image.classes.items() if not cls.is_bare}
    on_markers = set[str]()
    for name, label, shown, body in _classes(setup.targets):
        name = named.setdefault(label, name)
        if {**labels, **hidden}.get(name, label) != label or name in vars(ImageConfig()):
            raise ConfigError(
                f"{source}: label {label} has no name for its class; give one with --classes NAME={label}"
            )
        (labels if shown else hidden)[name] = label
        on_markers |= set() if body else {name}
    hidden |= {name: cls.label for name, cls in setup.image.classes.items()}  # of no object: who draws it wants it
    hidden = {name: label for name, label in hidden.items() if name not in {*labels, *ranged}}
    labels = {name: label for name, label in labels.items() if name not in ranged}
    bodies = frozenset(labels) - on_markers
    image, plane, known = setup.image, setup.recognizer.scene.plane, "image.gamma" in flat
    sizes = setup.recognizer.min_scale, setup.recognizer.min_blob_px
    return ColourSetup(setup.targets, labels, image.blank, bodies, hidden, ranged, plane, _camera(image), known, *sizes)


def _of_classes(names: Sequence[str], flat: Mapping[str, object]) -> Iterator[str]:
    """Parameters of classes that are read: labels, and ranges of those without reference colours, which are learned
    anew."""
    for name in names:
        ranges = () if flat.get(f"image.{name}.rgb") else ("hue", "saturation", "value")
        yield from (f"image.{name}.{key}" for key in ("label", *ranges))


def _camera(image: ImageConfig) -> ImageConfig:
    return ImageConfig(**{name: getattr(image, name) for name in GIVEN})


def _classes(targets: tuple[Target, ...]) -> Iterator[tuple[str, int, bool, bool]]:
    """A name for each label that an object may have, in the objects' order, whether axes show its class, and whether it
    is a body's."""
    for target in targets:
        for component in target.model.components:
            if component.classes:
                known = component.classes.items()
                yield from ((name, label, True, False) for name, label in known if label is not None)
            elif component.label is None:
                yield target.name, target.label, True, False
            else:
                yield component.name, component.label, True, False
            if component.body_label is not None:
                yield f"{component.name}_body", component.body_label, target.model.is_flat, True

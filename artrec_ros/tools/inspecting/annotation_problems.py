"""Whether annotations are of the objects that are there, and tell what is to be learned from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from ...core.base.errors import ConfigError
from ...core.model.identities import identities_of
from ...core.model.objects import ObjectModel
from ...io.base.yaml_files import few
from ...io.learned.annotations import IDENTITY, AnnotatedObject, Annotations
from ...io.learned.marked_objects import unknown_identity


def annotation_problems(path: Path, coco: Annotations, models: Mapping[str, ObjectModel]) -> Iterator[str]:
    """A line for each. :param path: of the annotations.

    :param models: by the files that tell of them; those of parameters as FILE: NAME, by the parameters' file and their
        own names.
    """
    missing = sorted({o.image for o in coco.objects if not o.image.is_file()})
    if missing:
        yield f"{path}: {len(missing)} of its images are not there, such as {missing[0]}"
    if not coco.objects and not any(coco.bare.values()):
        yield f"{path}: holds no annotation with keypoints"
    named = {c: [key for key, model in models.items() if _is_named(c, key, model)] for c in coco.categories}
    strange, fit = dict[str, str](), False
    for category, own in named.items() if models else ():
        reasons = []
        for key in (*own, *(key for key in models if key not in own)):  # several may have the same keypoints
            try:
                coco.of([category]).examples(models[key])
                if own or not any(named.values()):
                    yield from _identities([o for o in coco.objects if o.category == category], models[key])
                fit = True
                break
            except ConfigError as error:
                reasons.append(str(error))
        else:
            strange[category] = reasons[0]
    for category, reason in strange.items():
        if not fit or named[category]:  # else it is another object's
            yield f"{path}: category '{category}' is of none of the objects: {reason}"


def _is_named(category: str, key: str, model: ObjectModel) -> bool:
    """Whether a category is, or begins with, an object's name, or is, or ends with, one of its identities.

    :param key: of the model, as of `annotation_problems`.
    """
    name = key.rpartition(": ")[2] if ": " in key else model.name  # files alone are named by their paths
    identities = {i.name for i in identities_of(model)}
    told = category in identities or any(category.endswith(f"_{one}") for one in identities)
    return told or category == name or category.startswith(f"{name}_")


def _identities(annotated: Sequence[AnnotatedObject], model: ObjectModel) -> Iterator[str]:
    """Whether annotations tell which one of several like objects each is: by an attribute, or their category's end."""
    names, parts = sorted(i.name for i in identities_of(model)), {c.name for c in model.components if c.classes}
    silent = []
    for o in annotated if names else ():
        called = (name for name in names if o.category == name or o.category.endswith(f"_{name}"))
        told = o.attributes.get(IDENTITY, next(called, None))
        if told is None and not parts <= set(o.attributes):
            silent.append(o)
        elif told is not None and told not in names:
            yield unknown_identity(o, model.name, told, names)
    if silent:
        yield (
            f"{silent[0].place}: it is not told which one it is, of {len(silent)} of {len(annotated)} objects: give "
            f"the attribute identity ({few(names)})"
        )

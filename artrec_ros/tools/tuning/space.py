"""A search space: which parameters may change, within which limits. Read from a file `format: artrec_search/1`."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...core.base.config import TrackingConfig, rooms_of
from ...core.base.errors import ConfigError
from ...io.base.yaml_files import Value, load_yaml
from ...io.parameters.parameter_file import Setup, hint
from ...io.parameters.specs import EXPERT, Spec, moved

FORMAT = "artrec_search/1"
_DIGITS = 4  # significant ones of a value: more would only look exact
_ELEMENT = re.compile(r"(.+)\[(\d+)\]")
_TRACKING = tuple(f"{EXPERT}{room}." for room in rooms_of(TrackingConfig))
_SEARCHED = ("image.", "recognizer.", EXPERT)


@dataclass(frozen=True)
class Dimension:
    """One parameter that is searched, or one element of a list.

    :param name: as the file has it. :param element: its place in the list; None: the whole parameter.
    :param low, high: inclusive, where there are no `choices`. :param log: steps are factors.
    :param step: values are low, low + step, ...; None: any. :param choices: values, whatever their type.
    """

    name: str
    spec: Spec
    element: int | None = None
    low: float = 0.0
    high: float = 0.0
    log: bool = False
    step: float | None = None
    choices: tuple[Any, ...] = ()

    def rounded(self, value: float) -> float:
        """A number as it is used and written."""
        return min(max(float(f"{value:.{_DIGITS}g}"), self.low), self.high)

    def of(self, parameters: Mapping[str, Any]) -> Any:
        """Its value among flat parameters; None where a list is too short."""
        value = parameters.get(self.spec.name, list(self.spec.default) if self.spec.is_list else self.spec.default)
        if self.element is None:
            return value
        return value[self.element] if self.element < len(value) else None

    def changes(self, value: Any, parameters: Mapping[str, Any]) -> dict[str, Any]:
        """What it changes among flat parameters."""
        if self.element is None:
            return {self.spec.name: value}
        items = list(parameters[self.spec.name])
        items[self.element] = value
        return {self.spec.name: items}


def load_space(path: Path, setup: Setup) -> tuple[Dimension, ...]:
    """:raises ConfigError: an unknown parameter (it names the nearest), or limits that are none."""
    fields = load_yaml(path, FORMAT).fields(required=("parameters",))
    specs = setup.specs
    entries = fields["parameters"].entries()
    if not entries:
        raise fields["parameters"].error("names no parameter; such as recognizer.min_match: {low: 0.4, high: 0.8}")
    return tuple(_dimension(name, value, specs, setup) for name, value in entries.items())


def _dimension(name: str, value: Value, specs: Mapping[str, Spec], setup: Setup) -> Dimension:
    match = _ELEMENT.fullmatch(name)
    base, element = (match[1], int(match[2])) if match else (name, None)
    searched = {n: s for n, s in specs.items() if n.startswith(_SEARCHED) and not n.endswith((".classes", ".label"))}
    searched = {n: s for n, s in searched.items() if not n.startswith(_TRACKING)}
    if base not in specs:
        new_name = moved(base, specs)
        if new_name is not None:
            raise value.error(f"this parameter is one for experts now: give it as {new_name}")
        raise value.error(f"unknown parameter{hint(base, searched)}")
    if base not in searched:
        raise value.error("does not change what is found in a frame; parameters of image, recognizer and expert do")
    spec = searched[base]
    fields = value.fields(optional=("low", "high", "log", "step", "choices"))
    dimension = Dimension(name, spec, element)
    if element is not None and (not spec.is_list or dimension.of(setup.resolved) is None):
        raise value.error(f"the parameter file's {base} has no element {element} (the first is 0)")
    if "choices" in fields:
        return _of_choices(dimension, value, fields)
    if spec.type not in (int, float) or (spec.is_list and element is None):
        raise value.error("needs choices: it is no number" + (f"; or name an element, {base}[0]" * spec.is_list))
    return _of_numbers(dimension, value, fields)


def _of_choices(d: Dimension, value: Value, fields: Mapping[str, Value]) -> Dimension:
    if len(fields) > 1:
        raise value.error("has choices, so it has no low, high, log or step")
    items = fields["choices"].items()
    if len(items) < 2:
        raise fields["choices"].error("needs two choices or more")
    one = Spec(**{**vars(d.spec), "is_list": False}) if d.element is not None else d.spec
    read = [one.read(item) for item in items]
    return Dimension(d.name, d.spec, d.element, choices=tuple(list(v) if isinstance(v, tuple) else v for v in read))


def _of_numbers(d: Dimension, value: Value, fields: Mapping[str, Value]) -> Dimension:
    limits = {}
    for key in ("low", "high"):
        if key not in fields:
            raise value.error(f"{key} is missing; it needs low and high, or choices")
        whole = d.spec.type is int
        read = fields[key].integer if whole else fields[key].number
        limits[key] = read(d.spec.low, d.spec.high)
    if not limits["low"] < limits["high"]:
        raise value.error(f"low {limits['low']} is not below high {limits['high']}")
    log = fields["log"].boolean() if "log" in fields else False
    step = fields["step"].number(above=0) if "step" in fields else None
    if log and (step is not None or limits["low"] <= 0):
        raise value.error("log: needs a low above 0, and no step")
    if step is not None and d.spec.type is int and step != int(step):
        raise fields["step"].error("must be a whole number: the parameter is one")
    return Dimension(d.name, d.spec, d.element, limits["low"], limits["high"], log, step)


def distributions(space: tuple[Dimension, ...]) -> dict[str, Any]:
    """As Optuna has them; choices by their JSON text, which may be lists."""
    import optuna.distributions as od

    found: dict[str, Any] = {}
    for d in space:
        if d.choices:
            found[d.name] = od.CategoricalDistribution([json.dumps(c) for c in d.choices])
        elif d.spec.type is int:
            found[d.name] = od.IntDistribution(int(d.low), int(d.high), d.log, int(d.step or 1))
        else:
            found[d.name] = od.FloatDistribution(d.low, d.high, d.log, d.step)
    return found


def values_of(space: tuple[Dimension, ...], suggested: Mapping[str, Any]) -> dict[str, Any]:
    """Values by the dimensions' names, from what Optuna suggests."""
    values: dict[str, Any] = {}
    for d in space:
        value = suggested[d.name]
        values[d.name] = json.loads(value) if d.choices else value if d.spec.type is int else d.rounded(value)
    return values


def suggested_of(space: tuple[Dimension, ...], parameters: Mapping[str, Any]) -> dict[str, Any] | None:
    """What Optuna would have suggested for these flat parameters; None where they lie outside the space."""
    suggested: dict[str, Any] = {}
    for d in space:
        value = d.of(parameters)
        suggested[d.name] = json.dumps(value) if d.choices else value
        inside = value in d.choices if d.choices else value is not None and d.low <= value <= d.high
        on_grid = d.step is None or abs((value - d.low) / d.step - round((value - d.low) / d.step)) < 1e-9
        if not (inside and on_grid):
            return None
    return suggested


def changed(setup: Setup, space: tuple[Dimension, ...], values: Mapping[str, Any]) -> Setup:
    """The set-up with these values. :raises ConfigError: they do not go together."""
    before = {**setup.resolved, **{d.spec.name: setup.value(d.spec.name) for d in space}}
    flat = dict(before)
    for d in space:
        flat.update(d.changes(values[d.name], flat))
    changes = {key: value for key, value in flat.items() if before[key] != value}
    try:
        return setup.changed(changes)
    except ConfigError as error:
        raise ConfigError(f"these values do not go together: {error}") from error

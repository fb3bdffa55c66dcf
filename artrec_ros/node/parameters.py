"""ROS parameters from io's parameter specs: declared with description and range, changed as a whole or not at all."""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..core.base.errors import ArtrecError, ConfigError
from ..core.geometry.camera import Camera
from ..core.geometry.range_limits import range_limits
from ..io.base.shared_files import SCHEME
from ..io.parameters.parameter_file import NO_FILE, Setup, hint, setup_from_flat
from ..io.parameters.sections import check_own, check_sections, names_file
from ..io.parameters.specs import Spec, moved
from ..io.parameters.unread import unread

_ARRAYS = {
    bool: Parameter.Type.BOOL_ARRAY,
    int: Parameter.Type.INTEGER_ARRAY,
    float: Parameter.Type.DOUBLE_ARRAY,
    str: Parameter.Type.STRING_ARRAY,
}
_STAND_IN = "no_image_after_s"  # any that may be changed


def _read_overrides(node: Node) -> dict[str, Any]:
    """What the user set, by parameter files, -p or launch, before any declaration.

    rclpy has no public way to see parameters that nobody declared; a misspelt one would be dropped in silence.
    An empty list has no type in ROS and comes as None: its parameter keeps its default.
    """
    return {name: p.value for name, p in node._parameter_overrides.items() if p.value is not None}


def parameter_files(argv: Sequence[str]) -> list[Path]:
    """The files that the command line names with --params-file."""
    return [Path(value).absolute() for flag, value in zip(argv, argv[1:], strict=False) if flag == "--params-file"]


def base_directory(overrides: Mapping[str, Any], files: Sequence[Path]) -> Path:
    """Where relative names start of files that lie beside no parameter file: `config_dir`, else a folder in which
    others of them lie."""
    given = overrides.get("config_dir")
    if given:
        return Path(str(given)).expanduser().absolute()
    folders = [f.parent for f in files]
    paths = [v for k, v in overrides.items() if k.endswith(".object_file") and isinstance(v, str)]
    relative = [p for p in paths if not p.startswith(SCHEME)]
    # launch adds files of its own in a temporary folder: prefer the folder where the named files are
    fitting = [d for d in folders if any((d / p).is_file() for p in relative)]
    return [*fitting, *folders, Path.cwd()][0]


def beside_files(overrides: Mapping[str, Any], files: Sequence[Path]) -> dict[str, Any]:
    """Parameters with relative names of files as absolute ones where such a file lies beside a parameter file, beside
    the last one of several: ROS does not say which of them gave a name, and launch adds files of its own in a temporary
    folder. With `config_dir` all stay as they are."""
    out = dict(overrides)
    for key, name in overrides.items() if not overrides.get("config_dir") else ():
        if names_file(key) and isinstance(name, str) and not name.startswith(SCHEME):
            there = [f.parent / name for f in files if (f.parent / name).is_file()]
            out[key] = str(there[-1]) if there else name
    return out


def initial_setup(node: Node, argv: Sequence[str]) -> Setup:
    """The set-up that the node was started with. Unknown parameters are warned about: a file may serve several nodes;
    and so are those that change nothing here.

    :raises ConfigError: a value, or a file that it names, is not valid.
    """
    overrides, files = _read_overrides(node), parameter_files(argv)
    if "objects" not in overrides and not files:
        raise ConfigError("no object to look for is named: give a parameter file (--ros-args --params-file FILE.yaml)")
    single = [flag for flag in ("-p", "--param") if flag in argv]  # a value may be theirs
    source = ", ".join([*map(str, files), *single]) or NO_FILE
    warn = node.get_logger().warning
    for file in files:
        check_own(file, node.get_fully_qualified_name())
    if "objects" not in overrides:
        check_sections(files, node.get_fully_qualified_name())
    setup = setup_from_flat(beside_files(overrides, files), base_directory(overrides, files), source, warn=warn)
    for line in unread(setup):
        warn(line)
    return setup


class LiveParameters:
    """Declares a set-up's parameters on a node and keeps the two in step. Those for experts only where they are given.

    A batch of changes is taken whole or refused whole with the reason. `on_change` gets the set-up that a batch led to
    once it is taken. All that could speak against one is checked before, which takes milliseconds: objects are read
    from files only at the start, and what can be changed later has its range and its sense in core/config.
    `calibrated` says which images there are, `camera` which one took the last, as far as that is known.
    """

    def __init__(
        self,
        node: Node,
        setup: Setup,
        on_change: Callable[[Setup], None],
        calibrated: Callable[[], Collection[bool]],
        camera: Callable[[], Camera | None],
    ) -> None:
        self._node, self._specs = node, setup.specs
        self._setup = setup
        self._on_change, self._calibrated, self._camera = on_change, calibrated, camera
        self._checked: Setup | None = None
        self._refusal = ""  # of the batch whose names were looked at last
        for spec in self._specs.values():
            if spec.is_expert and spec.name not in setup.resolved:
                continue
            _declare(node, spec, setup.resolved.get(spec.name, []))
        node.add_pre_set_parameters_callback(self._to_declared_types)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._take)

    @property
    def setup(self) -> Setup:
        """The set-up that the parameters stand for now."""
        return self._setup

    def read_again(self) -> Setup:
        """The same with all files read anew.

        :raises ConfigError: one of them is not valid any more.
        """
        self._setup = setup_from_flat(self._setup.resolved, Path())
        return self._setup

    def _to_declared_types(self, parameters: list[Parameter]) -> list[Parameter]:
        """Also sees to it that a batch with an unknown name is refused with a reason; rclpy alone gives none."""
        self._refusal = ""  # of a batch that rclpy refused itself `_check` was never asked
        unknown = [p.name for p in parameters if not self._node.has_parameter(p.name)]
        known = [coerce(self._specs[p.name], p) if p.name in self._specs else p for p in parameters]
        if not unknown:
            return known
        self._refusal = f"{unknown[0]}: {self._why_unknown(unknown[0])}"
        # `_check` is asked only about parameters that there are, and about one at least
        return [p for p in known if p.name not in unknown] + [self._node.get_parameter(_STAND_IN)]

    def _why_unknown(self, name: str) -> str:
        if name in self._specs:
            return "can be changed only where it was given at the start: put it into the parameter file"
        new_name = moved(name, self._specs)
        return f"is {new_name} now" if new_name else f"unknown parameter{hint(name, self._specs)}"

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        self._checked = None
        refusal, self._refusal = self._refusal, ""
        if refusal:
            return SetParametersResult(successful=False, reason=refusal)
        ours = {p.name: p.value for p in parameters if p.name in self._specs}
        if not ours:
            return SetParametersResult(successful=True)
        deleted = [name for name, value in ours.items() if value is None]
        if deleted:
            return SetParametersResult(successful=False, reason=f"{deleted[0]}: cannot be deleted, only changed")
        try:
            changed = self._setup.changed(ours)
            if (camera := self._camera()) is not None and changed.recognizer != self._setup.recognizer:
                range_limits(changed.recognizer, camera)
        except ArtrecError as error:
            return SetParametersResult(successful=False, reason=str(error).removeprefix(f"{NO_FILE}: "))
        self._checked = changed
        return SetParametersResult(successful=True)

    def _take(self, parameters: list[Parameter]) -> None:
        if self._checked is not None:
            there = self._calibrated()
            told = _oddities(self._setup, there)
            self._setup, self._checked = self._checked, None
            self._on_change(self._setup)
            for line in _oddities(self._setup, there):
                if line not in told:
                    self._node.get_logger().warning(line)


def _oddities(setup: Setup, calibrated: Collection[bool]) -> list[str]:
    """What is allowed, and seldom meant: values that nothing reads, classes without a colour, what cannot be found."""
    return [*unread(setup, calibrated), *setup.lacks()]


def coerce(spec: Spec, parameter: Parameter) -> Parameter:
    """The parameter in its declared type where nothing is lost by it: 15 for 15.0, and [] of any type."""
    value = parameter.value
    if spec.is_list:
        empty = value is not None and not isinstance(value, (str, bool, int, float)) and len(value) == 0
        if empty or (spec.type is float and parameter.type_ == Parameter.Type.INTEGER_ARRAY):
            return Parameter(parameter.name, _ARRAYS[spec.type], [spec.type(v) for v in value])
    elif spec.type is float and parameter.type_ == Parameter.Type.INTEGER:
        return Parameter(parameter.name, Parameter.Type.DOUBLE, float(value))
    return parameter


def to_parameter(spec: Spec, value: Any) -> Parameter:
    """A value as the parameter that it is declared as."""
    if spec.is_list:
        return Parameter(spec.name, _ARRAYS[spec.type], [spec.type(v) for v in value])
    return Parameter(spec.name, value=spec.type(value))


def describe(spec: Spec) -> ParameterDescriptor:
    """What tools show of a parameter."""
    unit = f" [{spec.unit}]" if spec.unit else ""
    descriptor = ParameterDescriptor(description=spec.description + unit, read_only=not spec.is_live)
    if spec.choices:
        descriptor.additional_constraints = f"one of: {', '.join(spec.choices)}"
    if spec.low is None and spec.high is None:
        return descriptor
    if spec.is_list:
        descriptor.additional_constraints = f"each within {_text(spec.low)} .. {_text(spec.high)}"
    elif spec.type is int:
        low = -(2**63) if spec.low is None else int(spec.low)
        high = 2**63 - 1 if spec.high is None else int(spec.high)
        descriptor.integer_range = [IntegerRange(from_value=low, to_value=high, step=0)]
    else:
        low_f = -sys.float_info.max if spec.low is None else float(spec.low)
        high_f = sys.float_info.max if spec.high is None else float(spec.high)
        descriptor.floating_point_range = [FloatingPointRange(from_value=low_f, to_value=high_f, step=0.0)]
    return descriptor


def _text(bound: float | None) -> str:
    return "any" if bound is None else f"{bound:g}"


def _declare(node: Node, spec: Spec, value: Any) -> None:
    if not spec.is_list:
        node.declare_parameter(spec.name, spec.type(value), describe(spec), ignore_override=True)
    elif value:
        node.declare_parameter(spec.name, [spec.type(v) for v in value], describe(spec), ignore_override=True)
    else:  # rclpy takes [] for bytes: give the type first, and then a value, or whoever reads all gets nothing
        node.declare_parameter(spec.name, _ARRAYS[spec.type], ignore_override=True)
        node.set_parameters([Parameter(spec.name, _ARRAYS[spec.type], [])])
        descriptor = describe(spec)
        descriptor.type = _ARRAYS[spec.type].value
        node.set_descriptor(spec.name, descriptor)

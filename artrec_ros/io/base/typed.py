"""Plain values, as of JSON, read by type hints: what does not fit is told by its key and what would.

Hints are those of TypedDicts and dataclasses: numbers (finite ones), text, lists, mappings, `None`, literals, and
`Annotated` with `Between`. Keys that nobody asks for are passed over.
"""

from __future__ import annotations

import dataclasses
import math
import types
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import repeat
from typing import Annotated, Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints, is_typeddict

import numpy as np

from .yaml_files import shown

T = TypeVar("T")
_Reader = Callable[[Any], Any]


class UnfitError(ValueError):
    """A value that is none of its kind; its text begins with the key."""

    def __init__(self, message: str, key: str = "") -> None:
        super().__init__(f"{key}: {message}" if key else message)
        self.message, self.key = message, key

    def inside(self, key: str) -> UnfitError:
        joint = "." if self.key and not self.key.startswith("[") else ""
        return UnfitError(self.message, f"{key}{joint}{self.key}")


@dataclass(frozen=True)
class Between:
    """Limits of a number."""

    low: float = -math.inf
    high: float = math.inf


Share = Annotated[float, Between(0, 1)]
Amount = Annotated[float, Between(0)]
Stamp = Annotated[int, Between(-(2**63), 2**63 - 1)]

_MOST_WHOLE = 2**53  # up to which a float holds every whole number
_MOST = 1e100  # of a number: what is squared stays finite


def typed(raw: Any, hint: type[T]) -> T:
    """What `raw` is by the hint; dataclasses are made of mappings, lists become tuples.

    :raises UnfitError: it is none.
    """
    return cast(T, _reader(cast(Hashable, hint))(raw))


@cache
def _reader(hint: Hashable) -> _Reader:
    origin, args = get_origin(hint), get_args(hint)
    if hint is Any:
        return lambda raw: raw
    if hint in _PLAIN:
        return _PLAIN[hint]
    if origin is Annotated:
        return _bounded(_reader(args[0]), args[1])
    if origin is Literal:
        return _one_of(args)
    if origin in (Union, types.UnionType):
        kind = next(a for a in args if a is not types.NoneType)
        return _optional(lambda raw: _reader(kind)(raw))  # which may hold another one of the same kind
    if origin is np.ndarray:
        return _array
    if origin in (tuple, list, Sequence):
        endless = origin is not tuple or args[-1] is Ellipsis
        return _listed([_reader(a) for a in args if a is not Ellipsis], endless)
    if origin in (dict, Mapping):
        return _mapping(_reader(args[1]))
    return _record(hint)


def _wanted(wanted: str, raw: Any) -> UnfitError:
    return UnfitError(f"must be {wanted}, not {shown(raw)}")


def _number(raw: Any) -> float:
    if isinstance(raw, bool) or not isinstance(raw, (int, float)) or not -_MOST <= raw <= _MOST:
        raise _wanted("a finite number", raw)
    return float(raw)


def _integer(raw: Any) -> int:
    if isinstance(raw, float) and raw.is_integer():  # as tables of numbers are written
        if abs(raw) > _MOST_WHOLE:
            raise _wanted("a whole number without point or exponent: with one, those beyond 2^53 lose digits", raw)
        return int(raw)
    if isinstance(raw, bool) or not isinstance(raw, int):
        raise _wanted("a whole number", raw)
    return raw


def _text(raw: Any) -> str:
    if not isinstance(raw, str):
        raise _wanted("text", raw)
    return raw


def _boolean(raw: Any) -> bool:
    if not isinstance(raw, bool):
        raise _wanted("true or false", raw)
    return raw


_PLAIN: dict[Any, _Reader] = {float: _number, int: _integer, str: _text, bool: _boolean}


def _array(raw: Any) -> Any:
    if not isinstance(raw, np.ndarray):
        raise _wanted("an array", raw)
    return raw


def _bounded(inner: _Reader, limits: Between) -> _Reader:
    def read(raw: Any) -> Any:
        value = inner(raw)
        if not limits.low <= value <= limits.high:
            least, most = f"at least {limits.low:g}", "" if math.isinf(limits.high) else f" and at most {limits.high:g}"
            raise _wanted(f"{least}{most}", raw)
        return value

    return read


def _one_of(choices: tuple[Any, ...]) -> _Reader:
    def read(raw: Any) -> Any:
        if raw not in choices:
            raise _wanted(f"one of {', '.join(map(repr, choices))}", raw)
        return raw

    return read


def _optional(inner: _Reader) -> _Reader:
    return lambda raw: None if raw is None else inner(raw)


def _listed(readers: Sequence[_Reader], endless: bool) -> _Reader:
    """:param endless: any number of items, all by the first reader."""

    def read(raw: Any) -> Any:
        if not isinstance(raw, (list, tuple)) or not (endless or len(raw) == len(readers)):
            raise _wanted("a list" if endless else f"a list of {len(readers)}", raw)
        items: list[Any] = []
        try:
            for reader, item in zip(repeat(readers[0]) if endless else readers, raw):  # noqa: B905
                items.append(reader(item))
        except UnfitError as unfit:
            raise unfit.inside(f"[{len(items)}]") from None
        return tuple(items)

    return read


def _mapping(inner: _Reader) -> _Reader:
    def read(raw: Any) -> Any:
        if not isinstance(raw, Mapping):
            raise _wanted("a mapping {key: value}", raw)
        return {key: _entry(key, value, inner) for key, value in raw.items()}

    return read


def _entry(key: str, value: Any, reader: _Reader) -> Any:
    try:
        return reader(value)
    except UnfitError as unfit:
        raise unfit.inside(key if key.isprintable() else repr(key)) from None


def _record(kind: Any) -> _Reader:
    """Of a TypedDict or a dataclass; one that is made already is looked through."""
    readers = {key: _reader(hint) for key, hint in get_type_hints(kind, include_extras=True).items()}
    if is_typeddict(kind):
        needed: frozenset[str] = kind.__required_keys__
        make: Any = dict
    else:
        fields = [f for f in dataclasses.fields(kind) if f.init]
        readers = {f.name: readers[f.name] for f in fields}
        unset = dataclasses.MISSING
        needed = frozenset(f.name for f in fields if f.default is unset and f.default_factory is unset)
        make = kind

    def read(raw: Any) -> Any:
        given = vars(raw) if make is not dict and isinstance(raw, kind) else raw
        if not isinstance(given, Mapping):
            raise _wanted("a mapping {key: value}", raw)
        if missing := [key for key in readers if key in needed and key not in given]:
            raise UnfitError("this key is missing", missing[0])
        content = {key: _entry(key, given[key], reader) for key, reader in readers.items() if key in given}
        return raw if given is not raw else make(**content)

    return read

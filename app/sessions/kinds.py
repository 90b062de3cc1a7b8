"""Whether values are of the kinds that a dataclass declares for its fields."""

import dataclasses
from collections.abc import Callable
from functools import cache
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

NUMBERS: dict[Any, tuple[type, ...]] = {
    float: (float, int, np.floating, np.integer),
    int: (int, np.integer),
    bool: (bool, np.bool_),
}
TRUTH = (bool, np.bool_)  # which is an int to Python
Check = Callable[[Any], bool]  # whether a value is of a kind


def require_fields(kind: type, fields: dict[str, Any]) -> None:
    """Raises ValueError for a field that is missing, unknown or of another kind than the dataclass declares."""
    checks, optional = _declared(kind)
    if fields.keys() | optional != checks.keys():
        raise ValueError(f"other fields than a {kind.__name__} has")
    for name, value in fields.items():
        if not checks[name](value):
            raise ValueError(f"{name} of a {kind.__name__} is a {type(value).__name__}")


def fits(value: Any, hint: Any) -> bool:
    """Whether a value is of the kind that a type says; true for a type of which this knows no way to tell."""
    return _check_of(hint)(value)


@cache  # thousands of values a session are checked, by few types, which take longer to read than to ask
def _check_of(hint: Any) -> Check:
    while hasattr(alias := get_origin(hint) or hint, "__value__"):  # a name for a type, as numpy's NDArray may be
        hint = alias.__value__
    origin, inside = get_origin(hint), get_args(hint)
    if hint is Any:
        return lambda value: True
    if origin in (Union, UnionType):
        checks = tuple(map(_check_of, inside))
        return lambda value: any([check(value) for check in checks])
    if origin is Literal:
        return lambda value: value in inside
    if origin is tuple:
        return _check_of_tuple(inside)
    if hint in NUMBERS:
        numbers, refused = NUMBERS[hint], () if hint is bool else TRUTH
        return lambda value: isinstance(value, numbers) and not isinstance(value, refused)
    kind = origin or hint
    if not isinstance(kind, type):
        return lambda value: True
    if kind is np.ndarray:  # numpy makes scalars of arrays without dimensions
        return lambda value: isinstance(value, np.generic) or kind in type(value).__mro__
    return lambda value: kind in type(value).__mro__


def _check_of_tuple(inside: tuple[Any, ...]) -> Check:
    if inside[1:] == (...,):
        every = _check_of(inside[0])
        return lambda value: isinstance(value, tuple) and all(map(every, value))
    checks = tuple(map(_check_of, inside))
    return lambda value: (
        isinstance(value, tuple) and len(value) == len(checks) and all(check(one) for check, one in zip(checks, value))
    )


@cache
def fields_of(kind: type, wanted: type) -> tuple[str, ...]:
    """Names of a dataclass's fields that are declared as one type, or as that or None."""
    return tuple(name for name, hint in get_type_hints(kind).items() if wanted in (hint, *get_args(hint)))


@cache
def _declared(kind: type) -> tuple[dict[str, Check], frozenset[str]]:
    """Checks of a dataclass's fields, and the names of those that it has a value for."""
    hints, fields = get_type_hints(kind), dataclasses.fields(kind)
    given = (dataclasses.MISSING,)
    optional = frozenset(one.name for one in fields if (one.default, one.default_factory) != given * 2)
    return {one.name: _check_of(hints[one.name]) for one in fields}, optional

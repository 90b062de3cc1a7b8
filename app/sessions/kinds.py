"""Whether values are of the kinds that a dataclass declares for its fields."""

import dataclasses
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


def require_fields(kind: type, fields: dict[str, Any]) -> None:
    """Raises ValueError for a field that is missing, unknown or of another kind than the dataclass declares."""
    hints, optional = _declared(kind)
    if fields.keys() | optional != hints.keys():
        raise ValueError(f"other fields than a {kind.__name__} has")
    for name, value in fields.items():
        if not fits(value, hints[name]):
            raise ValueError(f"{name} of a {kind.__name__} is a {type(value).__name__}")


def fits(value: Any, hint: Any) -> bool:
    """Whether a value is of the kind that a type says; true for a type of which this knows no way to tell."""
    while hasattr(alias := get_origin(hint) or hint, "__value__"):  # a name for a type, as numpy's NDArray may be
        hint = alias.__value__
    origin, inside = get_origin(hint), get_args(hint)
    if hint is Any:
        return True
    if origin in (Union, UnionType):
        return any(fits(value, one) for one in inside)
    if origin is Literal:
        return value in inside
    if origin is tuple:
        each = inside[:1] * len(value) if inside[1:] == (...,) and isinstance(value, tuple) else inside
        return isinstance(value, tuple) and len(value) == len(each) and all(map(fits, value, each))
    if hint in NUMBERS:
        return isinstance(value, NUMBERS[hint]) and (hint is bool or not isinstance(value, TRUTH))
    kind = origin or hint
    if kind is np.ndarray and isinstance(value, np.generic):  # numpy makes these of arrays without dimensions
        return True
    return kind in type(value).__mro__ if isinstance(kind, type) else True


@cache
def _declared(kind: type) -> tuple[dict[str, Any], frozenset[str]]:
    """The types of a dataclass's fields, and the names of those that it has a value for."""
    hints, fields = get_type_hints(kind), dataclasses.fields(kind)
    given = (dataclasses.MISSING,)
    optional = frozenset(one.name for one in fields if (one.default, one.default_factory) != given * 2)
    return {one.name: hints[one.name] for one in fields}, optional

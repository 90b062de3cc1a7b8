"""Checks of what a browser sent: anything may come."""

from collections.abc import Mapping
from typing import Protocol

import numpy as np


class Titled(Protocol):
    @property
    def title(self) -> str: ...


def number(value) -> float:
    """A finite number. Raises ValueError."""
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        found = np.nan
    if not np.isfinite(found):
        raise ValueError(f"{str(value)[:40]!r} is not a number")
    return found


def choice(value, options: Mapping, what: str):
    """What an option stands for. Raises ValueError."""
    if not isinstance(value, str) or value not in options:
        raise ValueError(f"no {what} {str(value)[:40]!r}")
    return options[value]


def named(value, entries: Mapping[str, Titled], what: str) -> str:
    """The name of an entry of a registry, by its title. Raises ValueError."""
    return choice(value, {entry.title: name for name, entry in entries.items()}, what)


def switch(value) -> bool:
    """Raises ValueError."""
    if not isinstance(value, bool):
        raise ValueError(f"{str(value)[:40]!r} is neither on nor off")
    return value


def words(value, what: str) -> str:
    """Raises ValueError."""
    if not isinstance(value, str):
        raise ValueError(f"no {what} {str(value)[:40]!r}")
    return value

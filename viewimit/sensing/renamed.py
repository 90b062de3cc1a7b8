"""Names of earlier versions. They are still read for one version, with a warning that gives the new name."""

import sys
import warnings
from collections.abc import Mapping
from typing import Any

SETTINGS = {"camera": "sensor", "quantum_deg": "encoder_step_deg"}  # fields of `Settings`: old -> new
SETTING_VALUES = {"sensor": {"points": "projected"}}  # values of such a field
CALIBRATION = {"camera": "sensor"}  # arrays of a file that `viewimit rehearse` has written
OPTIONS = {  # of the command line
    "--body": "--calibration",
    "--camera": "--sensor",
    "--points": "--n-points",
    "--quantum-deg": "--encoder-step-deg",
    "--l": "--demo-left",
    "--r": "--demo-right",
    "--L": "--own-left",
    "--R": "--own-right",
}


def current_keys(given: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """The same values by their names of today. names: old -> new. Warns of each old name."""
    return {_current(name, names): value for name, value in given.items()}


def current_settings(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of `Settings` by their names of today, with values of today. Warns of each old name and value."""
    found = current_keys(fields, SETTINGS)
    for name, values in SETTING_VALUES.items():
        if isinstance(found.get(name), str):
            found[name] = _current(found[name], values)
    return found


def current_option(word: str) -> str:
    """A word of a command line, such as `--camera=rendered`, with the option's name of today. Warns of an old name."""
    name, *value = word.split("=", 1)
    return "=".join([_current(name, OPTIONS), *value])


def _current(name: str, names: Mapping[str, str]) -> str:
    if name not in names:
        return name
    message = f"{name} is now called {names[name]}; the old name will be gone"
    warnings.warn(message, FutureWarning, stacklevel=level_outside())
    return names[name]


def level_outside() -> int:
    """How far up the stack, for `warnings.warn` in the caller, the first line outside this package is."""
    frame, level, package = sys._getframe(1), 1, __name__.partition(".")[0]
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == package:
        frame, level = frame.f_back, level + 1
    return level

"""Which of the library's methods the lab has: assets/lab/methods.json, which its modules read as well."""

from functools import cache
from typing import Any

import msgspec
from viewimit.assets import ROOT


class LabMethods(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the lab says of each method, by its name; the first stands in for others."""

    servos: dict[str, dict[str, Any]]
    transfers: dict[str, dict[str, Any]]


@cache
def lab_methods() -> LabMethods:
    """Return the methods of the lab."""
    return msgspec.json.decode(ROOT.joinpath("lab", "methods.json").read_bytes(), type=LabMethods)

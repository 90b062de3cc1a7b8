"""What the lab and the Workbench offer to try: one list, of assets/presets.toml."""

from dataclasses import dataclass
from typing import Any

import msgspec
from viewimit.assets import ROOT

from viewimit.loop.settings import Settings, convert_fields
from viewimit.sensing.files import parse_toml

USUAL_SPEED = 2.0  # steps a second


@dataclass(frozen=True)
class Preset:
    """motions_per_second: 0 is as fast as it computes; key: in links; where: "lab" or "workbench", if only there."""

    name: str
    settings: Settings
    motions_per_second: float = USUAL_SPEED
    says: str = ""
    key: str = ""
    where: str = ""


class _Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A preset as the file has it."""

    key: str
    name: str
    says: str
    settings: dict[str, Any] = {}
    best: bool = False
    where: str = ""
    speed: float = USUAL_SPEED


def _preset(entry: _Entry) -> Preset:
    base = Settings if entry.best else Settings.paper
    settings = base(**convert_fields(entry.settings))
    return Preset(entry.name, settings, entry.speed, entry.says, entry.key, entry.where)


def read_presets(data: bytes) -> list[Preset]:
    """Read a file like assets/presets.toml. Raises msgspec.ValidationError for an unknown field or a wrong type."""
    return [_preset(entry) for entry in msgspec.convert(parse_toml(data)["preset"], list[_Entry])]


_ALL = read_presets(ROOT.joinpath("presets.toml").read_bytes())
PRESETS = [preset for preset in _ALL if preset.where != "lab"]
LAB_PRESETS = [preset for preset in _ALL if preset.where != "workbench"]

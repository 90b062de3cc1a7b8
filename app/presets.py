"""What the lab and the Workbench offer to try: one list, of assets/presets.toml."""

from dataclasses import dataclass
from typing import Any

from viewimit.assets import ROOT

from viewimit.loop.settings import Settings, convert_fields
from viewimit.sensing.files import parse_toml

USUAL_SPEED = 2.0  # steps a second


@dataclass(frozen=True)
class Preset:
    """name: as listed; motions_per_second: 0 is as fast as it computes; key: in links; where: "lab" or "workbench", if
    only that has it."""

    name: str
    settings: Settings
    motions_per_second: float = USUAL_SPEED
    says: str = ""
    key: str = ""
    where: str = ""


def _preset(entry: dict[str, Any]) -> Preset:
    """A preset as the file has it."""
    base, speed = Settings if entry.pop("best", False) else Settings.paper, entry.pop("speed", USUAL_SPEED)
    settings = base(**convert_fields(entry.pop("settings", {})))
    return Preset(settings=settings, motions_per_second=speed, **entry)


_ALL = [_preset(entry) for entry in parse_toml(ROOT.joinpath("presets.toml").read_bytes())["preset"]]
PRESETS = [preset for preset in _ALL if preset.where != "lab"]
LAB_PRESETS = [preset for preset in _ALL if preset.where != "workbench"]

"""What a page was before an entry of the glossary was shown: it is given back, whatever has been done since."""

from dataclasses import dataclass

from ..presets import Preset
from ..state import View
from .past import Left


@dataclass(frozen=True, eq=False)
class BeforeWord:
    """key: of the entry that is shown, by a preset; left: what was there, and playing; past: what had been left behind
    before; view: as it was."""

    key: str
    preset: Preset
    left: Left
    past: tuple[Left, ...]
    view: View
    playing: bool

"""The sliders of the folder Disturbances: what each stands for in the settings, in the units of the page."""

from dataclasses import dataclass

from viewimit.loop.settings import FIELDS, Setting, Settings, disturbances
from viewimit.simulation.disturbances import ArmDisturbance, Disturbance, SightDisturbance

from .checks import number


@dataclass(frozen=True)
class Amount:
    """name: in `Settings`; label, low, high, step, hint: of its slider; per: so many on the page are one there."""

    name: str
    label: str
    low: float
    high: float
    step: float
    per: float
    hint: str

    def shown(self, settings: Settings) -> float:
        """The slider's value."""
        value = getattr(settings, self.name) * self.per
        return round(value) if isinstance(self.step, int) else round(value, 6)

    def asked(self, value: object) -> float:
        """What the slider's value, sent by a browser, is in the settings. Raises ValueError for what is no number."""
        return number(value) / self.per


@dataclass(frozen=True)
class Count(Amount):
    """An amount of whole things. Each takes time, so no more may be asked for than the slider has."""

    def asked(self, value: object) -> int:
        found = round(number(value))
        if not self.low <= found <= self.high:
            raise ValueError(f"{self.label.lower()} must be between {self.low} and {self.high}, got {found}")
        return found


def _amounts(kind: type[Disturbance]) -> list[Amount]:
    return [
        Amount(name, it.label, *it.slider_range, it.slider_scale, it.description)
        for name, it in disturbances(kind).items()
    ]


_FRAMES = FIELDS["frames"]
assert isinstance(_FRAMES, Setting)
FRAMES = Count("frames", _FRAMES.label, *_FRAMES.slider_range, 1, _FRAMES.description)
OF_IMAGES: tuple[Amount, ...] = (*_amounts(SightDisturbance), FRAMES)
OF_ARMS: tuple[Amount, ...] = (*_amounts(ArmDisturbance),)

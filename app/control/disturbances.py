"""The sliders of the folder Disturbances: what each stands for in the settings, in the units of the page."""

from dataclasses import dataclass

from viewimit.settings import Settings

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


DISTURBANCES = {
    amount.name: amount
    for amount in (
        Amount("noise_px", "Noise px", 0.0, 2.0, 0.05, 1, "of every image coordinate, standard deviation"),
        Amount("missing", "Missing %", 0, 50, 1, 100, "points that an image does not show"),
        Amount("outliers", "Wrong %", 0, 30, 1, 100, "points that are found at a wrong place"),
        Count(
            "frames", "Frames", 1, 50, 1, 1, "images averaged at each posture; gross errors among them are set aside"
        ),
        Amount("gain_error", "Gain err. %", -20, 20, 1, 100, "the arm moves by so much more than it is told"),
        Amount("quantum_deg", "Steps °", 0.0, 2.0, 0.1, 1, "the arm stands at multiples of this only"),
    )
}

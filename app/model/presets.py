"""Presets: situations worth seeing, as data. Those that break the method say how."""

from dataclasses import dataclass

from viewimit.loop.settings import Settings
from viewimit.loop.simulated_robot import complete


@dataclass(frozen=True)
class Preset:
    """name: as listed; settings: all that it sets; motions_per_second: 0 is as fast as it computes."""

    name: str
    settings: Settings
    motions_per_second: float
    lesson: str


PRESETS = (
    Preset(
        "Paper, Section 5.3",
        Settings.paper(),
        2,
        "Ten points in four images: where their conflict E is least, arms nearly agree.",
    ),
    Preset(
        "Beyond the paper",
        Settings(),
        2,
        "No bias, a handful of motions: it asks for E of images that it predicts.",
    ),
    Preset(
        "The paper's own law",
        Settings.paper(servo="gradient", start_deg=(30, -60)),
        0,
        "Eq. (13) as printed: u fades with E, and the learned gradient goes stale.",
    ),
    Preset(
        "The paper's law, retuned",
        Settings.paper(servo="gradient-retuned", start_deg=(25, -45)),
        0,
        "More gain, bounded steps, dither: near in hundreds of motions, never at rest.",
    ),
    Preset(
        "Linear combination of views",
        Settings.paper(transfer="linear", start_deg=(75, -150)),
        2,
        "No lines are intersected, so none can be parallel; it ends as near.",
    ),
    Preset(
        "Seven joints",
        Settings(
            joints=tuple(range(1, 8)),
            points=16,
            demonstrator_deg=(10, 40, -10, -80, 15, 100, 30),
            start_deg=(-10, 25, 10, -50, -15, 75, 60),
        ),
        2,
        "More unknowns, the same method. The wrist moves its points least.",
    ),
    Preset(
        "Verged cameras",
        Settings.paper(scene="panda-verged", start_deg=(25, -45), rectify="off"),
        2,
        "Each camera looks at the gaze point itself: E is least at a wrong posture.",
    ),
    Preset(
        "Toed-in cameras",
        Settings(scene="panda-toed", start_deg=(25, -45)),
        2,
        "Unlike eyes, turned inwards: their matches alone tell how to rectify them.",
    ),
    Preset(
        "Demonstrator faces the learner",
        Settings.paper(scene="panda-facing", start_deg=(25, -45)),
        2,
        "Turned by 180°, near and far swap: E is least many degrees off, and far from 0.",
    ),
    Preset(
        "Few points",
        Settings.paper(points=5, start_deg=(25, -45)),
        2,
        "Five are the least for which E is not always 0: too few to tell a joint by.",
    ),
    Preset(
        "Nearly coplanar points",
        Settings.paper(scene="panda-flat", start_deg=(25, -45)),
        2,
        "Points near one plane leave one coordinate to chance: watch σ₁/σ₃.",
    ),
    Preset(
        "Half a pixel of noise",
        Settings.paper(noise_px=0.5, start_deg=(25, -45)),
        2,
        "The minimum itself moves by degrees: the transfer amplifies the noise.",
    ),
    Preset(
        "Points get lost",
        Settings.paper(points=16, missing=0.15, start_deg=(25, -45), transfer="linear"),
        2,
        "A point counts only if all four views see it; below five the arm holds still.",
    ),
    Preset(
        "Points without names",
        Settings(points=16, noise_px=0.1, matched=False, start_deg=(25, -45)),
        2,
        "The demonstrator's points come in any order: after two probes it names them.",
    ),
    Preset(
        "KUKA iiwa",
        Settings.paper(scene="iiwa", start_deg=(25, -25)),
        2,
        "Another body, the same method: nothing in it knows the robot.",
    ),
    Preset(
        "Camera images",
        Settings(sensor="rendered"),
        2,
        "Pictures of arms that wear coloured balls: only balls detected in them count.",
    ),
)

AS_STARTED = "As started"


def presets_from(asked: Settings) -> dict[str, Preset]:
    """By name, the one to begin with first: what the command line asked for, if no preset is that."""
    begun = next((preset for preset in PRESETS if preset.settings == asked), Preset(AS_STARTED, asked, 2, ""))
    return {preset.name: preset for preset in (begun, *PRESETS)}


class Presets:
    """Which a page offers, by name, and which it has begun with last. asked: by the command line."""

    def __init__(self, asked: Settings):
        self.offered = presets_from(asked)
        self.chosen = next(iter(self.offered.values()))
        self._complete: tuple[Preset, Settings] | None = None  # those of the chosen one, as a session has them

    def differ(self, settings: Settings) -> bool:
        """Whether a session's settings are others than those of the chosen one."""
        if self._complete is None or self._complete[0] is not self.chosen:
            self._complete = self.chosen, complete(self.chosen.settings)
        return settings != self._complete[1]

"""Presets: situations worth seeing, as data. Those that break the method say how."""

from dataclasses import dataclass

from viewimit.language import _
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
        _("Paper, Section 5.3"),
        Settings.paper(),
        2,
        _("Ten points, four pictures. Press Play and watch the conflict shrink."),
    ),
    Preset(
        _("Beyond the paper"),
        Settings(),
        2,
        _("Our best method: exact in 5 to 10 steps, as it predicts images before it moves."),
    ),
    Preset(
        _("The paper's own law"),
        Settings.paper(servo="gradient", start_deg=(30, -60)),
        0,
        _("The paper's law as printed. Its steps shrink with E, so it slows to a crawl."),
    ),
    Preset(
        _("The paper's law, retuned"),
        Settings.paper(servo="gradient-retuned", start_deg=(25, -45)),
        0,
        _("With a larger gain it comes near in hundreds of steps, but never stands still."),
    ),
    Preset(
        _("Linear combination of views"),
        Settings.paper(transfer="linear", start_deg=(75, -150)),
        2,
        _("Just as accurate. It intersects no lines, so parallel ones cannot spoil it."),
    ),
    Preset(
        _("Seven joints"),
        Settings(
            joints=tuple(range(1, 8)),
            points=16,
            demonstrator_deg=(10, 40, -10, -80, 15, 100, 30),
            start_deg=(-10, 25, 10, -50, -15, 75, 60),
        ),
        2,
        _("Seven unknowns. The wrist is hardest to see, as it moves its points least."),
    ),
    Preset(
        _("Verged cameras"),
        Settings.paper(scene="panda-verged", start_deg=(25, -45), rectify="off"),
        2,
        _("Each camera looks at the gaze point itself. The lowest E is at a wrong pose."),
    ),
    Preset(
        _("Toed-in cameras"),
        Settings(scene="panda-toed", start_deg=(25, -45)),
        2,
        _("Two different cameras, toed in. Matched points alone rectify their images."),
    ),
    Preset(
        _("Demonstrator faces the learner"),
        Settings.paper(scene="panda-facing", start_deg=(25, -45)),
        2,
        _("Near and far swap for a demonstrator that faces the learner: far from exact."),
    ),
    Preset(
        _("Few points"),
        Settings.paper(points=5, start_deg=(25, -45)),
        2,
        _("With four points E is always 0. With five it is nearly flat: no joint is found."),
    ),
    Preset(
        _("Nearly coplanar points"),
        Settings.paper(scene="panda-flat", start_deg=(25, -45)),
        2,
        _("The points nearly lie in one plane, so one coordinate is left to chance."),
    ),
    Preset(
        _("Half a pixel of noise"),
        Settings.paper(noise_px=0.5, start_deg=(25, -45)),
        2,
        _("Noise moves the minimum itself by degrees, because the transfer amplifies it."),
    ),
    Preset(
        _("Points get lost"),
        Settings.paper(points=16, missing=0.15, start_deg=(25, -45), transfer="linear"),
        2,
        _("A point counts if all four images show it. Below five, the arm holds still."),
    ),
    Preset(
        _("Points without names"),
        Settings(points=16, noise_px=0.1, matched=False, start_deg=(25, -45)),
        2,
        _("The points come in any order. After two test moves the learner names them."),
    ),
    Preset(
        _("KUKA iiwa"),
        Settings.paper(scene="iiwa", start_deg=(25, -25)),
        2,
        _("Another robot, the same method: it knows no robot."),
    ),
    Preset(
        _("Camera images"),
        Settings(sensor="rendered"),
        2,
        "Pictures of arms that wear coloured balls: only balls detected in them count.",
    ),
)

AS_STARTED = _("As started")


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

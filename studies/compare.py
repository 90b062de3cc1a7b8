"""The study `compare`: all servo laws from the same draws. Those that descend once begin again by `Restarts`.

Run it with

    python studies/compare.py bench compare --csv docs/comparison.csv
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from calibrated import ORACLES, CalibratedServo
from generative import Generative
from restarts import Restarts

from viewimit import Session, Settings
from viewimit.commands.cli import main
from viewimit.experiments.bench import GROUPS, Case, Draw, Group
from viewimit.experiments.bench.cases import SEVEN, any_head, on_surface, posed
from viewimit.servo import SERVOS, ServoMethod

PAPER_LAW = "gradient"
SERVOS["generative"] = ServoMethod(servo=Generative(), predicts=True)
for name, oracle in ORACLES.items():
    SERVOS[name] = ServoMethod(servo=CalibratedServo(oracle), mirror_columns=True)


def every_law(transfer: str | None, servos: Sequence[str]) -> list[tuple[str, str]]:
    """Return the paper's law, with which the others are compared, and all others or those given."""
    return [(transfer or Settings().transfer, law) for law in dict.fromkeys([PAPER_LAW, *(servos or SERVOS)])]


def as_compared(draw: Draw, opened: Callable[[Draw], Session]) -> Session:
    """Open a session with an oracle that knows it, or with a law that begins again."""
    name, seed = draw.settings.servo, (draw.seed, draw.number)
    method = draw.law or SERVOS[name]
    if name in ORACLES:
        oracle = CalibratedServo(ORACLES[name], seed)
        draw.law = replace(method, servo=oracle)
        session = opened(draw)
        oracle.attach(session)
        return session
    if name == "generative" or not method.predicts:  # the others begin again by themselves
        draw.law = ServoMethod(servo=Restarts(method, seed, draw.max_motions), mirror_columns=True, predicts=True)
    return opened(draw)


GROUPS["compare"] = Group(
    "All servo laws side by side, from the same draws; an oracle is given the URDF and the calibrated cameras.",
    tuple(
        Case(name, partial(as_compared, opened=opened), max_motions=200, max_runs=most)
        for name, opened, most in (
            ("default scene", posed, None),
            ("toed-in heads", any_head, None),
            ("noise 0.5 px, 25 frames", partial(posed, noise_px=0.5, frames=25), None),
            ("20 points, hidden by surfaces", partial(on_surface, count=20, hidden=0.0), None),
            ("seven joints, ±30°, 16 points", partial(posed, offset_deg=30.0, **SEVEN), 96),
        )
    ),
    Settings.paper(),
    every_law,
    in_scene=True,
)
if __name__ == "__main__":
    sys.exit(main())

"""Runs without one special case of the trust region: python tests/servo/special_cases.py [NAME ...]

For each name, or all, it prints how seeded random runs end with the special case and without it: how many of them are
within 0.5°, how many claim to have arrived, how many of these are off by more than three times the error that they
expect, and the mean number of motions. One takes a few seconds to a minute.
"""

import sys
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from typing import Any
from unittest.mock import patch

import numpy as np

from viewimit import Session, Settings
from viewimit.servo import SERVOS, TrustRegionOptions, trust_region_method
from viewimit.servo.trust_region import algorithm, rules, state

POINTS = {"points": 16, "frames": 1}
LADDER = TrustRegionOptions().ladder


@dataclass(frozen=True)
class SpecialCase:
    """How to run without a special case: with other options, or with functions replaced by `name: function`."""

    settings: Mapping[str, Any]  # of the runs in which it matters
    options: Mapping[str, Any] = field(default_factory=dict)
    module: Any = None
    functions: Mapping[str, Callable] = field(default_factory=dict)
    runs: int = 12


def never(*given: Any) -> bool:
    return False


def short_step(now, context):
    """As `take_step`, which never goes beyond its target here."""
    region = replace(now.region, predicted_reduction=float(context.plan.E - context.plan.minimum.E))
    return rules.move(replace(now, region=region), context, context.plan.minimum.theta)


SPECIAL_CASES = {
    "swap": SpecialCase({"points": 16, "swapped": 0.2}, {"swap_search_at": ()}),
    "kinematics": SpecialCase({**POINTS, "missing": 0.3}, {"fit_kinematics_at": ()}),
    "ladder": SpecialCase({**POINTS, "outliers": 0.05, "noise_px": 0.25}, {"ladder": LADDER[:1]}),
    "mismatch": SpecialCase({"encoder_step_deg": 1.0}, module=state, functions={"contradicts_command": never}),
    "noise-floor": SpecialCase({"noise_px": 0.5}, module=rules, functions={"noise_floor": lambda context: 0.0}),
    "overshoot": SpecialCase({}, module=algorithm, functions={"take_step": short_step}),
}


def ends(settings: Mapping[str, Any], runs: int) -> str:
    """How runs from anywhere to anywhere end."""
    off, expected, claimed, motions = [], [], [], []
    for k in range(runs):
        shown, start = np.random.default_rng([7, k]).uniform((0, -180), (90, 0), (2, 2)).tolist()
        last = Session(Settings(demonstrator_deg=shown, start_deg=start, seed=k, **settings)).run(80).last
        off.append(np.degrees(np.abs(last.theta - last.theta_demo).max()))
        expected.append(np.nan if last.expected_error is None else np.degrees(last.expected_error))
        claimed.append(last.status == "converged")
        motions.append(last.motion)
    arrived, wrong = np.array(off) < 0.5, np.array(claimed) & (np.array(off) > 3 * np.array(expected))
    return (
        f"{arrived.sum()} of {runs} within 0.5°, {sum(claimed)} claim it, {wrong.sum()} of these wrongly; "
        f"{np.mean(motions):.1f} motions"
    )


def main(names: list[str]) -> None:
    for name in names or SPECIAL_CASES:
        case = SPECIAL_CASES[name]
        print(f"{name}\n  with it     {ends(case.settings, case.runs)}")
        method = trust_region_method(replace(TrustRegionOptions(), **case.options))
        changed = patch.multiple(case.module, **case.functions) if case.functions else nullcontext()
        with patch.dict(SERVOS, {"trust-region": method}), changed:
            print(f"  without it  {ends(case.settings, case.runs)}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

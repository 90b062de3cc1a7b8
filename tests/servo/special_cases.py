"""Runs without one special case of the trust region: python tests/servo/special_cases.py [NAME ...]

For each name, or all, it prints how seeded random runs end with the special case and without it: how many of them are
within 0.5°, how many claim to have arrived, how many of these are off by more than three times the error that they
expect, and the mean number of motions. One takes a few seconds to a minute.
"""

import sys
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
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
    hidden: bool = False  # whether points are hidden beyond the rim of surfaces, instead of with the settings


def never(*given: Any) -> bool:
    return False


RESTART = rules.restart


def fewer_points_compete(state, context, goal, min_points):
    """As `restart`, after which visits where fewer points are visible may still be the best."""
    return RESTART(state, context, goal, 0)


SPECIAL_CASES = {
    "swap": SpecialCase({"points": 16, "swapped": 0.2}, {"swap_search_at": ()}),
    "kinematics": SpecialCase({**POINTS, "missing": 0.3}, {"fit_kinematics_at": ()}),
    "ladder": SpecialCase({**POINTS, "outliers": 0.05, "noise_px": 0.25}, {"ladder": LADDER[:1]}),
    "mismatch": SpecialCase({"encoder_step_deg": 1.0}, module=state, functions={"contradicts_command": never}),
    "noise-floor": SpecialCase({"noise_px": 0.5}, module=rules, functions={"noise_floor": lambda context: 0.0}),
    "trusted": SpecialCase({}, module=state, functions={"_is_confirmed": never}),
    "min-points": SpecialCase({}, {}, algorithm, {"restart": fewer_points_compete}, runs=160, hidden=True),
    "more-points": SpecialCase({}, {}, algorithm, {"more_points_elsewhere": never}, runs=160, hidden=True),
}


def session(case: SpecialCase, k: int) -> Session:
    """Return one from anywhere to anywhere."""
    if case.hidden:
        from test_hidden_points import session_with

        return session_with([900, 24 + k])
    shown, start = np.random.default_rng([7, k]).uniform((0, -180), (90, 0), (2, 2)).tolist()
    return Session(Settings(demonstrator_deg=shown, start_deg=start, seed=k, **case.settings))


def ends(case: SpecialCase) -> str:
    """How the runs of a special case end."""
    off, expected, claimed, motions, runs = [], [], [], [], case.runs
    for k in range(runs):
        last = session(case, k).run(80).last
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
        print(f"{name}\n  with it     {ends(case)}")
        method = trust_region_method(replace(TrustRegionOptions(), **case.options))
        changed = patch.multiple(case.module, **case.functions) if case.functions else nullcontext()
        with patch.dict(SERVOS, {"trust-region": method}), changed:
            print(f"  without it  {ends(case)}", flush=True)


if __name__ == "__main__":
    sys.path.append(str(Path(__file__).parents[1]))  # for helpers of tests
    main(sys.argv[1:])

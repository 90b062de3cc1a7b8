"""How a servo arrives when images and arm are not perfect, and with more joints: a table, seeded.

Two joints start and are shown anywhere in their range; all seven within DEMO_DEG of rest, the start so far from there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from ...loop.session import Session
from ...loop.settings import Settings
from ..executors.study import Study, each
from .success import Share

DEMO_DEG = 20.0
NEAR_DEG = (0.5, 1.0, 3.0)
SURELY = 3.0  # standard deviations
PATIENCE = 20  # looks in a row with too few points, after which a learner is given up
SEVEN = tuple(range(1, 8))
SEVEN_16, SEVEN_REHEARSED = {"joints": SEVEN, "points": 16}, 12


@dataclass(frozen=True)
class Case:
    """changes: of the settings; offset_deg: of the start from the demonstrator, None for anywhere; rehearsed: postures
    within reach of all starts in which the learner has watched itself before."""

    name: str
    changes: dict
    offset_deg: float | None = None
    rehearsed: int = 0


CASES = (
    Case("undisturbed", {}),
    *(Case(f"noise {noise} px, 25 frames", {"noise_px": noise, "frames": 25}) for noise in (0.25, 0.5, 1.0)),
    *(
        Case(f"{what} {share:.0%}, {images}", {what: share, "frames": frames})
        for what, share in (("missing", 0.1), ("missing", 0.3), ("outliers", 0.1))
        for frames, images in ((1, "1 frame"), (5, "5 frames"))
    ),
    Case("all of these: 0.5 px, 10%, 10%, 25 frames", {"noise_px": 0.5, "missing": 0.1, "outliers": 0.1, "frames": 25}),
    *(Case(f"swapped {share:.0%}", {"swapped": share}) for share in (0.1, 0.2)),
    Case("gain error 5 %", {"gain_error": 0.05}),
    Case("steps of 0.2°", {"encoder_step_deg": 0.2}),
    *(Case(f"pictures {late} late", {"delay": late}) for late in (1, 3)),
    *(
        Case(f"seven joints, ±{offset:g}°, {points} points", {"joints": SEVEN, "points": points}, offset)
        for points in (16, 20)
        for offset in (30.0, 60.0)
    ),
    Case(f"seven joints, ±30°, 16 points, {SEVEN_REHEARSED} rehearsed", SEVEN_16, 30.0, SEVEN_REHEARSED),
)


@dataclass(frozen=True)
class Outcome:
    """Of a case: rms_deg of the largest joint error at the end, expected_deg by the servo's own account;
    claimed_rms_deg: of claims, None without any; ended: by NEAR_DEG; claimed_falsely: beyond 0.5° and SURELY times
    what the servo expects."""

    case: str
    runs: int
    rms_deg: float
    expected_deg: float
    claimed_rms_deg: float | None
    ended: dict[float, Share]
    motions_median: float
    motions_95: float
    claimed: Share
    claimed_falsely: Share


def run(
    settings: Settings,
    cases: Sequence[Case] = CASES,
    runs: int = 200,
    seed: int = 0,
    max_motions: int = 80,
    workers: int | Study | None = None,
    tell: Callable[[float], None] = lambda share: None,
) -> list[Outcome]:
    """Every case from the same draws. settings: scene, layout, transfer and servo. tell(share done)."""
    tasks = [
        (msgspec.structs.replace(settings, **case.changes), case, [seed, k], max_motions)
        for case in cases
        for k in range(runs)
    ]
    found = []
    for ended in each(run_once, tasks, workers):
        found.append(ended)
        tell(len(found) / len(tasks))
    return [_outcome(case.name, found[k * runs : (k + 1) * runs]) for k, case in enumerate(cases)]


def run_once(settings: Settings, case: Case, seed: list[int], max_motions: int) -> tuple[float, float, int, bool]:
    """Largest joint error at the end and the one that the servo expects, degrees; motions; claimed. settings: the
    case's."""
    offset_deg = case.offset_deg
    session, rng = Session(settings), np.random.default_rng(seed)
    low, high = np.transpose(session.scene.range_deg)
    if offset_deg is None:
        demo, start = rng.uniform(low, high, (2, len(low)))
    else:
        rest = np.array(session.scene.posture_deg)[session.scene.moving]
        demo = np.clip(rest + rng.uniform(-DEMO_DEG, DEMO_DEG, len(low)), low, high)
        start = np.clip(demo + rng.uniform(-offset_deg, offset_deg, len(low)), low, high)
    noise_seed = int(rng.integers(2**32))
    postures = {"demonstrator_deg": tuple(demo.tolist()), "start_deg": tuple(start.tolist())}
    if case.rehearsed:
        rest_deg = tuple(np.array(session.scene.posture_deg)[session.scene.moving].tolist())
        session.begin(msgspec.structs.replace(settings, start_deg=rest_deg))
        session.calibrate(case.rehearsed, noise_seed, None if offset_deg is None else DEMO_DEG + offset_deg)
    session.begin(msgspec.structs.replace(settings, seed=noise_seed, **postures))
    last = session.run(max_motions, PATIENCE).last
    error = np.degrees(np.abs(last.theta - last.theta_demo)).max()
    expected = np.degrees(last.expected_error or 0.0)
    return float(error), float(expected), last.motion, last.status.is_claim


def _outcome(name: str, found: Sequence[tuple[float, float, int, bool]]) -> Outcome:
    error, expected, motions, claimed = (np.array(column) for column in zip(*found))
    rms = lambda degrees: float(np.sqrt((degrees**2).mean()))
    return Outcome(
        name,
        len(found),
        rms(error),
        rms(expected),
        rms(error[claimed]) if claimed.any() else None,
        {near: Share.of(error <= near) for near in NEAR_DEG},
        float(np.median(motions)),
        float(np.percentile(motions, 95)),
        Share.of(claimed),
        Share.of(claimed & (error > np.maximum(NEAR_DEG[0], SURELY * expected))),
    )

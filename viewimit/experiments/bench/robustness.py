"""How a servo copes with imperfect images and arms, with more joints, and with points detected in pictures.

Two joints start and are shown anywhere in their range. All seven joints are shown within DEMO_DEG of the scene's
posture, and start near that.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import msgspec
import numpy as np

from ...estimation.transfers import TRANSFERS
from ...estimation.views import VIEWS
from ...loop.session import Session
from ...loop.settings import SENSORS, Settings
from ...simulation.eyes import require_eyes
from ...simulation.scene import load_scene
from .benchmark import (
    N_SIGMA,
    PATIENCE,
    WITHIN_DEG,
    CaseOptions,
    Context,
    MethodOptions,
    Progress,
    RunOptions,
    SceneOptions,
    Share,
    as_json,
    error_deg,
    expected_deg,
    option,
    rms,
    run_cases,
    shares_within,
    table,
)
from .draws import DEMO_DEG, draw_postures
from .success import quick_servos

MAX_MOTIONS = 80
SEVEN = tuple(range(1, 8))
SEVEN_16, SEVEN_REHEARSED = {"joints": SEVEN, "points": 16}, 12
WRONG_DETECTION_PX = 3.0  # a marker's radius: a detection farther from its marker is of something else


@dataclass(frozen=True)
class Case:
    """A condition under which runs are made."""

    name: str
    changes: dict[str, Any]  # of the settings
    offset_deg: float | None = None  # largest distance of the start from the demonstrator; None: anywhere
    rehearsed: int = 0  # postures of a rehearsal, within reach of all starts


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
    Case("seven joints, ±30°, 16 points, noise 0.25 px, 25 frames", SEVEN_16 | {"noise_px": 0.25, "frames": 25}, 30.0),
    Case(f"seven joints, ±30°, 16 points, {SEVEN_REHEARSED} rehearsed", SEVEN_16, 30.0, SEVEN_REHEARSED),
)


@dataclass(frozen=True)
class Outcome:
    """The runs of one case."""

    case: str
    runs: int
    rms_deg: float  # of the largest joint error at the end
    expected_deg: float  # rms of what the servo expects of it
    claimed_rms_deg: float | None  # of claims, None without any
    ended: dict[float, Share]  # by degrees: shares of runs that ended so near
    motions_median: float
    motions_95: float
    claimed: Share
    claimed_falsely: Share


@dataclass(frozen=True, kw_only=True)
class RobustnessBenchmark(SceneOptions, RunOptions, MethodOptions, CaseOptions):
    """Robustness: with noise, missing, wrong and swapped points, an inexact arm, and seven joints."""

    cases = CASES

    def run(self, context: Context) -> tuple[Any, str]:
        """See `Benchmark.run`."""
        _, points = self.load()
        settings = self.method(scene=self.scene, points=points)
        cases = self.chosen_cases()
        found = run(settings, cases, self.runs, self.seed, context=context)
        heading = f"{self.runs} random runs a case, seed {self.seed}, largest joint error to the demonstrator"
        return as_json(found), f"{heading}\n{robustness_table(found)}"


def run(
    settings: Settings,
    cases: Sequence[Case] = CASES,
    runs: int = 200,
    seed: int = 0,
    max_motions: int = MAX_MOTIONS,
    context: Context | None = None,
) -> list[Outcome]:
    """Run every case from the same draws. settings: scene, layout, transfer and servo. See also `run_cases`."""
    tasks = [
        [(msgspec.structs.replace(settings, **case.changes), case, [seed, k], max_motions) for k in range(runs)]
        for case in cases
    ]
    found = run_cases(run_once, tasks, context, "robustness")
    return [_outcome(case.name, of_case) for case, of_case in zip(cases, found)]


def run_once(settings: Settings, case: Case, seed: list[int], max_motions: int) -> tuple[float, float, int, bool]:
    """Run once with the case's settings.

    Returns the largest joint error at the end and the one that the servo expects, degrees; the number of motions; and
    whether it claims to have converged.
    """
    session, rng = Session(settings), np.random.default_rng(seed)
    postures = draw_postures(session.scene, rng, case.offset_deg)
    noise_seed = int(rng.integers(2**32))
    if case.rehearsed:
        rest_deg = tuple(np.array(session.scene.posture_deg)[session.scene.moving].tolist())
        session.begin(msgspec.structs.replace(settings, start_deg=rest_deg))
        reach_deg = None if case.offset_deg is None else DEMO_DEG + case.offset_deg
        session.calibrate(case.rehearsed, noise_seed, reach_deg)
    session.begin(msgspec.structs.replace(settings, seed=noise_seed, **postures))
    last = session.run(max_motions, PATIENCE).last
    return error_deg(last), expected_deg(last, 0.0), last.motion, last.status.is_claim


def _outcome(name: str, found: Sequence[tuple[float, float, int, bool]]) -> Outcome:
    error, expected, motions, claimed = (np.array(column) for column in zip(*found))
    return Outcome(
        name,
        len(found),
        rms(error),
        rms(expected),
        rms(error[claimed]) if claimed.any() else None,
        shares_within(error),
        float(np.median(motions)),
        float(np.percentile(motions, 95)),
        Share.of(claimed),
        Share.of(claimed & (error > np.maximum(WITHIN_DEG[0], N_SIGMA * expected))),
    )


def robustness_table(outcomes: Sequence[Outcome]) -> str:
    """Lay out the outcomes for people, a row for each case."""
    columns = [
        *(("rms", 9), ("expected", 10), ("of claims", 11), ("ended ≤0.5°", 18), ("ended ≤1°", 18), ("motions", 9)),
        *(("95 %", 7), ("claimed", 18), ("falsely", 16)),
    ]
    rows = []
    for o in outcomes:
        claims_rms = None if o.claimed_rms_deg is None else f"{o.claimed_rms_deg:.2f}°"
        errors = f"{o.rms_deg:.2f}°", f"{o.expected_deg:.2f}°", claims_rms, o.ended[0.5], o.ended[1.0]
        motions = f"{o.motions_median:.0f}", f"{o.motions_95:.0f}"
        rows.append((o.case, (*errors, *motions, o.claimed, o.claimed_falsely)))
    return table(columns, rows)


@dataclass(frozen=True)
class Detection:
    """Detection of markers in rendered pictures of both arms in random postures."""

    scene: str
    pictures: int
    markers: int
    in_sight: float  # share of markers the middle of whose face is visible
    found: float  # share of all markers
    found_in_sight: float  # share of those in sight
    error_px: tuple[float, float, float, float]  # median, 95th and 99th percentile, largest
    rms_px: float  # of a coordinate
    bias_px: tuple[float, float]  # mean error in x and y
    false: int  # detections farther than WRONG_DETECTION_PX from their marker
    detections: int
    usable: tuple[int, float]  # fewest and median number of markers found in all four pictures


@dataclass(frozen=True, kw_only=True)
class PicturesBenchmark(SceneOptions, RunOptions, MethodOptions):
    """Rendered pictures: how well markers are detected in them, and how the servos do on them and on points."""

    def run(self, context: Context) -> tuple[Any, str]:
        """See `Benchmark.run`."""
        scene, points = self.load()
        with option("--scene"):
            require_eyes("rendered", scene)
        with context.progress("detection") as progress:
            detected = run_detection(self.scene, self.runs, self.seed, progress)
        outcomes: list[Outcome] = []
        for transfer in [self.transfer] if self.transfer else TRANSFERS:
            for servo in [self.servo] if self.servo else quick_servos():
                settings = Settings.paper(scene=self.scene, points=points, transfer=transfer, servo=servo)
                cases = [Case(f"{transfer}, {servo}, {sensor}", {"sensor": sensor}) for sensor in SENSORS]
                outcomes += run(settings, cases, self.runs, self.seed, context=context)
        heading = f"{self.runs} random runs, seed {self.seed}, largest joint error to the demonstrator"
        found = {"detection": asdict(detected), "servos": as_json(outcomes)}
        return found, f"{detection_table(detected)}\n{heading}\n{robustness_table(outcomes)}"


def run_detection(scene: str, pairs: int, seed: int, progress: Progress) -> Detection:
    """Detect markers in four pictures for each pair of random postures, of demonstrator and learner."""
    from ...simulation.rendering import RenderedEyes  # loads pybullet and OpenCV

    eyes, rng = RenderedEyes(load_scene(scene)), np.random.default_rng(seed)
    low, high = eyes.world.scene.lower, eyes.world.scene.upper
    offsets, sights, finds, usable = [], [], [], []
    for k in range(pairs):
        demo, own = rng.uniform(low, high, (2, len(low)))
        eyes.demo_images(demo)
        eyes.own_images(own)
        eyes.look_at("lr")  # once more, because both arms have reached their postures only now
        eyes.look_at("LR")
        for view in VIEWS:
            image, in_sight = eyes.truth(view)
            offsets.append(eyes.detections[view].points - image)
            sights.append(in_sight)
            finds.append(eyes.detections[view].found)
        usable.append(int(np.all(finds[-len(VIEWS) :], 0).sum()))
        progress((k + 1) / pairs)
    in_sight, found = np.array(sights), np.array(finds)
    errors = np.array(offsets)[found]
    distance = np.linalg.norm(errors, axis=-1)
    right = errors[distance <= WRONG_DETECTION_PX]
    median, p95, p99 = np.percentile(distance, (50, 95, 99)).tolist()
    bias_x, bias_y = right.mean(0).tolist()
    return Detection(
        scene=scene,
        pictures=len(VIEWS) * pairs,
        markers=found.shape[1],
        in_sight=float(in_sight.mean()),
        found=float(found.mean()),
        found_in_sight=float(found[in_sight].mean()),
        error_px=(median, p95, p99, float(distance.max())),
        rms_px=rms(right),
        bias_px=(bias_x, bias_y),
        false=int((distance > WRONG_DETECTION_PX).sum()),
        detections=int(found.sum()),
        usable=(min(usable), float(np.median(usable))),
    )


def detection_table(found: Detection) -> str:
    """Lay out the detection for people."""
    median, p95, p99, largest = found.error_px
    bias_x, bias_y = found.bias_px
    fewest, typical = found.usable
    return f"""{found.pictures} pictures of {found.scene}, {found.markers} markers an arm, random postures
  in sight                     {found.in_sight:8.1%}
  found, of all                {found.found:8.1%}
  found, of those in sight     {found.found_in_sight:8.1%}
  error of the middle          median {median:.3f} px, 95 % {p95:.3f}, 99 % {p99:.3f}, most {largest:.2f}
  of a coordinate              rms {found.rms_px:.3f} px, mean {bias_x:+.3f}, {bias_y:+.3f}
  false identities             {found.false} of {found.detections}
  in all four pictures         median {typical:.0f}, fewest {fewest}"""

"""How closely a learner tracks a moving demonstrator: both make one motion in turn."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...loop.session import Session
from ...loop.settings import Settings
from .benchmark import RUNS, CaseOptions, Context, SceneOptions, as_json, rms, run_cases

SWING_DEG, PERIODS = 25.0, (1.0, 0.7)  # amplitude of the path; its periods for each joint, repeated for more joints
STEPS, SETTLING_STEPS, MAX_APPROACH = 150, 10, 200  # of the path; not counted at its start; motions before it
PAPER = Settings.paper(servo="gradient")


@dataclass(frozen=True)
class Case:
    """A condition under which runs are made. Tracking begins once the learner rests."""

    name: str
    settings: Settings
    deg_per_step: float  # of the demonstrator's fastest joint


CASES = (
    *(Case(f"{rate:g}° a step", Settings(), rate) for rate in (0.5, 1.0, 3.0)),
    *(Case(f"1° a step, noise {noise} px", Settings(noise_px=noise), 1.0) for noise in (0.25, 0.5)),
    Case("1° a step, noise 0.25 px, 1 frame", Settings(noise_px=0.25, frames=1), 1.0),
    Case("1° a step, epipolar, broyden", Settings.paper(), 1.0),
    Case("1° a step, epipolar, gradient", PAPER, 1.0),
)


@dataclass(frozen=True)
class Outcome:
    """Largest joint errors of one case, after each step of the demonstrator and the learner's next motion."""

    case: str
    runs: int
    rms_deg: float
    most_deg: float


@dataclass(frozen=True, kw_only=True)
class TrackingBenchmark(SceneOptions, CaseOptions):
    """Tracking of a moving demonstrator, along random paths."""

    runs: Annotated[int, dataclasses.replace(RUNS, description="random paths")] = 8
    cases = CASES

    def run(self, context: Context) -> tuple[Any, str]:
        """See `Benchmark.run`."""
        _, points = self.load()
        cases = self.chosen_cases()
        found = run(self.scene, points, cases, self.runs, self.seed, context)
        heading = f"{self.runs} paths, seed {self.seed}, {points} points of {self.scene}: largest joint error"
        rows = (f"  {o.case:<36}{o.rms_deg:8.2f}°{o.most_deg:8.2f}°" for o in found)
        return as_json(found), "\n".join([heading, f"{'demonstrator, learner':<38}{'rms':>9}{'most':>9}", *rows])


def run(
    scene: str = Settings().scene,
    points: int = Settings().points,
    cases: Sequence[Case] = CASES,
    runs: int = 8,
    seed: int = 0,
    context: Context | None = None,
) -> list[Outcome]:
    """Run every case along the same paths. See also `run_cases`."""
    tasks = []
    for case in cases:
        settings = msgspec.structs.replace(case.settings, scene=scene, points=points)
        tasks.append([(settings, case.deg_per_step, [seed, k]) for k in range(runs)])
    errors = [np.concatenate(found) for found in run_cases(run_once, tasks, context, "tracking")]
    return [Outcome(case.name, runs, rms(found), float(found.max())) for case, found in zip(cases, errors)]


def run_once(settings: Settings, deg_per_step: float, seed: list[int]) -> NDArray:
    """Track one path. Return the largest joint errors, (STEPS - SETTLING_STEPS,) degrees."""
    rng, session = np.random.default_rng(seed), Session(settings)
    demonstrator = path(session, deg_per_step, rng)
    noise_seed, demo_deg = int(rng.integers(2**32)), tuple(np.degrees(demonstrator[0]))
    session.begin(msgspec.structs.replace(session.settings, seed=noise_seed, demonstrator_deg=demo_deg))
    session.run(MAX_APPROACH, patience=1)
    errors = []
    for theta in demonstrator[1:]:
        session.step()
        session.pose(theta)
        errors.append(np.degrees(np.abs(session.snapshot.theta - theta)).max())
    return np.array(errors[SETTLING_STEPS:])


def path(session: Session, deg_per_step: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw a path, (STEPS + 1, m) rad: swings about the scene's demonstrator. The fastest joint's speed is constant."""
    scene = session.scene
    centre = np.radians(np.array(scene.posture_deg)[scene.moving])
    swing = np.minimum(np.radians(SWING_DEG), (scene.upper - scene.lower) / 2)
    centre = np.clip(centre, scene.lower + swing, scene.upper - swing)
    periods, phase = np.resize(PERIODS, len(centre)), rng.uniform(0, 2 * np.pi, len(centre))
    fine = np.linspace(0, 400, 200_000)[:, None]
    curve = centre + swing * np.sin(phase + periods * fine)
    length = np.concatenate([[0.0], np.abs(np.diff(curve, axis=0)).max(1).cumsum()])
    distance = np.radians(deg_per_step) * np.arange(STEPS + 1)
    return np.stack([np.interp(distance, length, joint) for joint in curve.T], -1)

"""How far behind a demonstrator that does not wait a learner stays: a motion of each in turn, seeded."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...loop.session import Session
from ...loop.settings import Settings
from ..executors.study import Study, each

SWING_DEG, TURNS = 25.0, (1.0, 0.7)  # of the path, each joint; rounds a joint, repeated for more joints
STEPS, SETTLING, MOST_BEFORE = 150, 10, 200
PAPER = Settings.paper(servo="gradient")


@dataclass(frozen=True)
class Case:
    """deg_a_step: of the demonstrator's fastest joint. The learner begins to follow once it rests."""

    name: str
    settings: Settings
    deg_a_step: float


CASES = (
    *(Case(f"{rate:g}° a step", Settings(), rate) for rate in (0.5, 1.0, 3.0)),
    *(Case(f"1° a step, noise {noise} px", Settings(noise_px=noise), 1.0) for noise in (0.25, 0.5)),
    Case("1° a step, noise 0.25 px, 1 frame", Settings(noise_px=0.25, frames=1), 1.0),
    Case("1° a step, epipolar, broyden", Settings.paper(), 1.0),
    Case("1° a step, epipolar, gradient", PAPER, 1.0),
)


@dataclass(frozen=True)
class Outcome:
    """Largest joint error against the demonstrator after each of its steps and the learner's next motion, degrees."""

    case: str
    runs: int
    rms_deg: float
    most_deg: float


def run(
    scene: str = "panda",
    points: int = 10,
    cases: Sequence[Case] = CASES,
    runs: int = 8,
    seed: int = 0,
    workers: int | Study | None = None,
    tell: Callable[[float], None] = lambda share: None,
) -> list[Outcome]:
    """Every case along the same paths. tell(share done)."""
    tasks = [
        (msgspec.structs.replace(case.settings, scene=scene, points=points), case.deg_a_step, [seed, k])
        for case in cases
        for k in range(runs)
    ]
    errors = []
    for found in each(run_once, tasks, workers):
        errors.append(found)
        tell(len(errors) / len(tasks))
    together = [np.concatenate(errors[k * runs : (k + 1) * runs]) for k in range(len(cases))]
    return [
        Outcome(case.name, runs, float(np.sqrt((found**2).mean())), float(found.max()))
        for case, found in zip(cases, together)
    ]


def run_once(settings: Settings, deg_a_step: float, seed: list[int]) -> NDArray:
    """(STEPS - SETTLING,) degrees."""
    rng, session = np.random.default_rng(seed), Session(settings)
    demonstrator = path(session, deg_a_step, rng)
    session.begin(
        msgspec.structs.replace(
            session.settings,
            seed=int(rng.integers(2**32)),
            demonstrator_deg=tuple(np.degrees(demonstrator[0])),
        )
    )
    session.run(MOST_BEFORE, patience=1)
    errors = []
    for theta in demonstrator[1:]:
        session.step()
        session.pose(theta)
        errors.append(np.degrees(np.abs(session.snapshot.theta - theta)).max())
    return np.array(errors[SETTLING:])


def path(session: Session, deg_a_step: float, rng: np.random.Generator) -> NDArray:
    """(STEPS + 1, m) rad: swings about the scene's demonstrator, its fastest joint always at the one speed."""
    scene = session.scene
    centre = np.radians(np.array(scene.posture_deg)[scene.moving])
    swing = np.minimum(np.radians(SWING_DEG), (scene.upper - scene.lower) / 2)
    centre = np.clip(centre, scene.lower + swing, scene.upper - swing)
    turns, begin = np.resize(TURNS, len(centre)), rng.uniform(0, 2 * np.pi, len(centre))
    fine = np.linspace(0, 400, 200_000)[:, None]
    curve = centre + swing * np.sin(begin + turns * fine)
    along = np.concatenate([[0.0], np.abs(np.diff(curve, axis=0)).max(1).cumsum()])
    asked = np.radians(deg_a_step) * np.arange(STEPS + 1)
    return np.stack([np.interp(asked, along, joint) for joint in curve.T], -1)

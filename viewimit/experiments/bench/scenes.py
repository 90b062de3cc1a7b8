"""The trust of a transfer and a servo over random scenes: with parallel, equal cameras and with any head, with and
without rectification and noise, beside the Cramér-Rao bound."""

import math
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...loop.session import Session
from ...loop.settings import Settings
from ...simulation.eyes import ProjectedEyes, SimulatedEyes
from ...simulation.scene import Scene
from ..executors.study import Study, each
from .bound import bound
from .claims import TIMES
from .random_scenes import Drawn, draw, resize, write
from .success import FALSE_DEG, WITHIN_DEG, Share

PATIENCE = 20  # looks in a row with too few points, after which a learner is given up


@dataclass(frozen=True)
class Row:
    """any_head: of the scenes; changes: of the settings."""

    name: str
    any_head: bool
    changes: dict


NOISY = {"noise_px": 0.25, "frames": 25}
ROWS = (
    Row("parallel, equal cameras", False, {}),
    Row("any head, not rectified", True, {"rectify": "off"}),
    Row("any head, rectified", True, {}),
    Row("any head, not rectified, 0.25 px, 25 frames", True, {"rectify": "off", **NOISY}),
    Row("any head, rectified, 0.25 px, 25 frames", True, NOISY),
)


@dataclass(frozen=True)
class Outcome:
    """Of a row: shares of runs that ended within so many degrees, largest joint error; rms_deg of all joints' errors,
    beside what the Cramér-Rao bound leaves to them: bound_deg if own images without noise are granted everywhere,
    bound_as_seen_deg if all that is known of the own body is what was seen on the way. at_most, at_most_as_seen: the
    share within so many degrees of an estimator without bias that reaches these bounds with normal errors, by the worst
    joint alone; beyond: claimed, FALSE_DEG off or more;
    falsely: and more than TIMES what the learner itself expects."""

    row: str
    runs: int
    ended: dict[float, Share]
    motions_median: float
    motions_95: float
    motions_most: int
    claimed: Share
    beyond: Share
    falsely: Share
    rms_deg: float
    bound_deg: float
    bound_as_seen_deg: float
    at_most: dict[float, float]
    at_most_as_seen: dict[float, float]


def run(
    settings: Settings,
    scenes: int,
    pairs: int,
    seed: int,
    max_motions: int,
    rows: Sequence[Row] = ROWS,
    workers: int | Study | None = None,
    tell: Callable[[float], None] = lambda share: None,
) -> list[Outcome]:
    """The settings' transfer and servo in that many scenes a row, from that many starts to demonstrators in each."""
    tasks = [
        (msgspec.structs.replace(settings, **row.changes), row.any_head, [seed, k], pairs, max_motions)
        for row in rows
        for k in range(scenes)
    ]
    runs: list[Run] = []
    for found in each(run_scene, tasks, workers):
        runs.extend(found)
        tell(len(runs) / (len(tasks) * pairs))
    of_row = scenes * pairs
    return [outcome(row.name, runs[k * of_row : (k + 1) * of_row]) for k, row in enumerate(rows)]


@dataclass(frozen=True)
class Run:
    """error, bound, bound_as_seen: (m,) degrees, of all joints; motions made; claimed: the servo says that it has
    converged; expected: degrees, what it says of the worst joint's error, inf if nothing."""

    error: NDArray
    bound: NDArray
    bound_as_seen: NDArray
    motions: int
    claimed: bool
    expected: float


def run_scene(settings: Settings, any_head: bool, seed: list[int], pairs: int, max_motions: int) -> list[Run]:
    """In one scene, drawn here, from that many starts to demonstrators."""
    rng, runs = np.random.default_rng(seed), []
    drawn = draw(rng, any_head)
    with written(drawn) as path:
        for start, demonstrator in _pairs(rng, drawn.scene, pairs):
            asked = msgspec.structs.replace(
                settings,
                scene=path,
                points=drawn.points,
                start_deg=tuple(start),
                demonstrator_deg=tuple(demonstrator),
                seed=int(rng.integers(2**32)) if any_head else settings.seed,
            )
            runs.append(run_once(asked, drawn.size, max_motions))
    return runs


@contextmanager
def written(drawn: Drawn) -> Iterator[str]:
    """The path of a scene, for as long as that is needed."""
    with tempfile.TemporaryDirectory() as folder:
        yield str(write(drawn.scene, Path(folder), "drawn"))


def run_once(settings: Settings, size: float, max_motions: int) -> Run:
    session = Session(settings, partial(open_resized, size=size))
    last = session.run(max_motions, PATIENCE).last
    least = partial(bound, session.world, last.theta_demo, session.observer.image_noise_std(settings))
    left = least()
    left_as_seen = least([moment.theta for moment in session.history]) if settings.noise_px else left
    error = np.degrees(np.abs(last.theta - last.theta_demo))
    expected = np.inf if last.expected_error is None else float(np.degrees(last.expected_error))
    return Run(error, np.degrees(left), np.degrees(left_as_seen), last.motion, last.status.is_claim, expected)


def open_resized(camera: str, scene: Scene, points: int, size: float) -> SimulatedEyes:
    """Eyes of a learner that is so many times as large."""
    eyes = ProjectedEyes(scene, points)
    resize(eyes.world, size)
    return eyes


def outcome(name: str, runs: Sequence[Run]) -> Outcome:
    error, left, left_as_seen, motions, claimed, expected = (
        np.array([getattr(run, field) for run in runs])
        for field in ("error", "bound", "bound_as_seen", "motions", "claimed", "expected")
    )
    largest = error.max(1)
    beyond = claimed & (largest > FALSE_DEG)
    return Outcome(
        name,
        len(runs),
        {near: Share.of(largest <= near) for near in WITHIN_DEG},
        float(np.median(motions)),
        float(np.percentile(motions, 95)),
        int(motions.max()),
        Share.of(claimed),
        Share.of(beyond),
        Share.of(beyond & (largest > TIMES * expected)),
        rms_deg=_rms(error),
        bound_deg=_rms(left),
        bound_as_seen_deg=_rms(left_as_seen),
        at_most=_at_most(left.max(1)),
        at_most_as_seen=_at_most(left_as_seen.max(1)),
    )


def _rms(degrees: NDArray) -> float:
    return float(np.sqrt((degrees**2).mean()))


def _at_most(worst: NDArray) -> dict[float, float]:
    return {near: float(np.mean([_normal_within(near, deviation) for deviation in worst])) for near in WITHIN_DEG}


def _normal_within(near: float, deviation: float) -> float:
    return math.erf(near / (math.sqrt(2) * deviation)) if deviation > 0 else 1.0


def _pairs(rng: np.random.Generator, scene: Scene, count: int) -> list[list[list[float]]]:
    """Starts and demonstrators, count x 2 x 2 degrees."""
    low, high = np.transpose(scene.range_deg)
    return rng.uniform(low, high, (count, 2, 2)).tolist()

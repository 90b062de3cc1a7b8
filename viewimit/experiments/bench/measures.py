"""What cases measure at the end of a run, beside its error: bounds, the transfer's own minimum, right names."""

import math
from collections.abc import Sequence
from functools import lru_cache, partial
from itertools import product
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape, conflict_of_images, grid_axes, landscape_over, seen_from
from ...loop.session import Session
from ...loop.simulated_robot import demo_order
from ...simulation.world import World
from .bound import bound
from .engine import FALSE_DEG, HIGH_PERCENTILE, NEAR_DEG, WITHIN_DEG, Draw, Measures, Run
from .intervals import Share, rms, share_of

COARSE_STEP_DEG, FINER_STEP_DEG, FINE_STEP_DEG = 4.0, 0.25, 0.05  # of the grids on which a minimum is searched
SEARCH_RADII_DEG = 5.0, 1.5, 0.4  # of each finer grid
GRID_PER_JOINT = 9  # postures in which a learner may see a point of its own, evenly over the range
SAME_PX = 1.0  # distance of two points in both images, up to which their names mean the same


def values(runs: Sequence[Run], name: str) -> NDArray[np.float64]:
    """Return a measure of the runs that have it."""
    return np.array([run.measures[name] for run in runs if name in run.measures], float)


def share(name: str, of: str = "") -> Any:
    """Return a column: the share of runs with this measure, of all or of those with the measure `of`."""
    return lambda runs: share_of([bool(run.measures[name]) for run in runs if name in run.measures
                                  and (not of or run.measures[of])])  # fmt: skip


def within(name: str, limit: float) -> Any:
    """Return a column: the share of runs whose measure is at most a limit."""
    return lambda runs: share_of(values(runs, name) <= limit)


def over(name: str, statistic: Any) -> Any:
    """Return a column: a statistic of a measure, None where no run has it."""
    return lambda runs: float(statistic(found)) if len(found := values(runs, name)) else None


def minimum(session: Session, draw: Draw) -> dict[str, float]:
    """Distances [degrees] from the transfer's own minimum: at the end, at the nearest, and to the demonstrator."""
    target, last = own_minimum(session), session.snapshot
    visited = np.array([snapshot.theta for snapshot in session.history])
    off = lambda theta, target: np.degrees(np.abs(theta - target)).max(-1)
    return {
        "own_deg": float(off(last.theta, target)),
        "nearest_own_deg": float(off(visited, target).min()),
        "nearest_deg": float(off(visited, last.theta_demo).min()),
        "bias_deg": float(off(target, last.theta_demo)),
    }


OF_MINIMUM: Measures = {
    **{f"own_minimum_{limit:g}": within("own_deg", limit) for limit in WITHIN_DEG},
    "came_own_minimum_3": within("nearest_own_deg", WITHIN_DEG[-1]),
    "came_3": within("nearest_deg", WITHIN_DEG[-1]),
    "claimed_off_own_minimum": lambda runs: Share.of(
        run.claimed and run.measures["own_deg"] > FALSE_DEG for run in runs
    ),
    "bias_deg": over("bias_deg", np.median),
    "bias_95_deg": over("bias_deg", lambda found: np.percentile(found, HIGH_PERCENTILE)),
}


HEADINGS = {  # in tables, of names that say too little
    **{f"own_minimum_{deg:g}": f"≤{deg:g}° of least E" for deg in WITHIN_DEG},
    "came_own_minimum_3": "once ≤3° of least E",
    "came_3": "once ≤3° of the demonstrator",
    "claimed_off_own_minimum": f"claimed, >{FALSE_DEG:g}° off least E",
    "bias_deg": "least E off by",
    "bias_95_deg": "95 % off by less than",
}


def own_minimum(session: Session) -> NDArray[np.float64]:
    """Find the posture with the smallest E for the demonstrator as now seen, (2,) rad, on a grid of FINE_STEP_DEG.

    Finer grids around the local minima of a coarse one are searched. NaN if too few points are seen.
    """
    seen = seen_from(session.world, session.snapshot)
    over = lambda axes: landscape_over(*seen, axes)
    degrees, axes, images = _grids(session.world)
    places = Landscape(axes, *conflict_of_images(seen.fit, seen.demo, seen.demo_visible, *images)).local_minima()
    if not len(places):
        return np.full(2, np.nan)
    about = [
        over(tuple(a[np.abs(a - at) <= np.radians(SEARCH_RADII_DEG[0])] for a, at in zip(degrees, p))) for p in places
    ]
    lowest = min(about, key=lambda found: np.nanmin(found.E)).minimum
    for step, around in zip((FINER_STEP_DEG, FINE_STEP_DEG), SEARCH_RADII_DEG[1:]):
        offsets = np.radians(np.arange(-around, around + step / 2, step))
        lowest = over(
            tuple(
                np.unique(np.clip(at + offsets, low, high))
                for at, low, high in zip(lowest, session.scene.lower, session.scene.upper)
            )
        ).minimum
    return lowest


@lru_cache(1)  # the same for every run of a study
def _grids(world: World) -> tuple[tuple[NDArray, NDArray], tuple[NDArray, NDArray], tuple[NDArray, NDArray]]:
    """Axes of grids of 1° and of COARSE_STEP_DEG, rad, and the learner's images over the latter."""
    coarse = grid_axes(world, step_deg=COARSE_STEP_DEG)
    return grid_axes(world), coarse, world.own_images((coarse[0][:, None], coarse[1]))


def of_scene(session: Session, draw: Draw) -> dict[str, float]:
    """Cramér-Rao bounds [degrees]: by E with noise-free own images, with those seen, and with one head."""
    last, noise_px = session.snapshot, session.settings.noise_px
    bound_of = partial(bound, session.world, last.theta_demo, session.observer.image_noise_std(session.settings))
    visited = [moment.theta for moment in session.history]
    granted = bound_of()
    seen, one_head = (bound_of(visited), bound_of(visited, one_head=True)) if noise_px else [granted] * 2
    found = {"bound": granted, "bound_as_seen": seen, "bound_one_head": one_head}
    return {
        f"{name}_{kind}": float(of(np.degrees(one)))
        for name, one in found.items()
        for kind, of in (("deg", rms), ("worst_deg", np.max))
    }


def _at_best(name: str) -> Any:
    """Share within NEAR_DEG of an unbiased estimator with normal errors at a bound, from the worst joint alone."""
    within = lambda std: math.erf(NEAR_DEG / (math.sqrt(2) * std)) if std > 0 else 1.0
    return over(f"{name}_worst_deg", lambda worst: np.mean([within(std) for std in worst]))


OF_SCENE: Measures = {"all_joints_rms_deg": lambda runs: rms([run.errors_deg for run in runs])} | {
    key: column
    for name in ("bound", "bound_as_seen", "bound_one_head")
    for key, column in ((f"{name}_deg", over(f"{name}_deg", rms)), (f"{name}_at_best", _at_best(name)))
}


def of_claim(session: Session, draw: Draw) -> dict[str, float]:
    """Bound [degrees], inf if a joint is unobservable, from points that the learner sees of itself anywhere."""
    last, eyes, scene = session.snapshot, session.eyes, session.scene
    _, shown = eyes.demo_images(last.theta_demo)
    known = np.logical_not(shown.any(1))
    for theta in product(*np.linspace(scene.lower, scene.upper, GRID_PER_JOINT).T):
        if known.all():
            break
        known = known | eyes.own_images(theta)[1].all(-1)
    noise_px = session.settings.noise_px / np.sqrt(session.settings.frames)
    per_px = bound(session.world, last.theta_demo, 1.0, seen=shown & known[:, None]).max()
    return {"bound_deg": float(np.degrees(per_px * noise_px)) if np.isfinite(per_px) else np.inf}


def _observable(run: Run) -> bool:
    return bool(np.isfinite(run.measures["bound_deg"]))


OF_CLAIM: Measures = {
    "observable": lambda runs: Share.of(map(_observable, runs)),
    "near_of_observable": lambda runs: share_of([run.error_deg <= NEAR_DEG for run in runs if _observable(run)]),
    "claimed_if_bound_1": lambda runs: share_of(
        [run.claimed for run in runs if run.measures["bound_deg"] <= FALSE_DEG]
    ),
    "bound_deg": over("bound_deg", np.median),
}


def of_misfit(session: Session, draw: Draw, word: str, other_links: bool) -> dict[str, float]:
    """Whether the learner notices a misfit and names it, and the bound of another body's worst joint [degrees]."""
    last, found = session.snapshot, {}
    said = "" if last.misfit is None else str(last.misfit.kind)
    if said or not last.status.is_claim:
        found["right"] = float(said == word)
    if other_links:
        noise_px = session.settings.noise_px / np.sqrt(session.settings.frames)
        visited = [moment.theta for moment in session.history]
        earlier = draw.notes.get("earlier", ())
        of_joints = bound(session.world, last.theta_demo, noise_px, visited, another_body=True, earlier=earlier)
        found["bound_deg"] = float(np.degrees(of_joints.max()))
    return found


def _over_bound(runs: Sequence[Run]) -> float | None:
    """Median error over that of an estimate with the bound's standard deviation."""
    ratios = [
        run.error_deg / run.measures["bound_deg"] / _median_of_largest(len(run.errors_deg))
        for run in runs
        if "bound_deg" in run.measures
    ]
    return float(np.median(ratios)) if ratios else None


def _median_of_largest(m: int) -> float:
    """Median of the largest of m |x|, x standard normal, to four digits: Φ(median) = (1 + 2^(-1/m)) / 2."""
    return round(NormalDist().inv_cdf((1 + 2 ** (-1 / m)) / 2), 4)


OF_MISFIT: Measures = {
    "noticed": lambda runs: Share.of("right" in run.measures for run in runs),
    "word_right": share("right"),
    "over_bound": _over_bound,
}


def of_names(session: Session, draw: Draw) -> dict[str, float]:
    """Whether the learner finds which of the demonstrator's points is which, and says where it may not have."""
    last = session.snapshot
    if last.settings.matched:
        return {}
    naming, (nameable, wrong) = last.naming, judge(session)
    uncertain = naming is not None and bool((~naming.certain & (naming.names >= 0)).any())
    two_answers = naming is not None and naming.is_ambiguous
    moved = getattr(last.servo_state, "n_naming_motions", 0)  # laws that name nothing have no such number
    said = wrong == 0 or uncertain or two_answers or wrong == nameable
    found = {"named": wrong == 0, "acknowledged": said, "more_motions": moved > 0, "two_answers": two_answers}
    return {name: float(value) for name, value in found.items()}


OF_NAMES: Measures = {name: share(name) for name in ("named", "acknowledged", "more_motions", "two_answers")}


def judge(session: Session) -> tuple[int, int]:
    """Count the points with a partner, and the wrong names: other points' names, and partners that were not found."""
    last = session.snapshot
    images, visible = session.eyes.demo_images(last.theta_demo)
    own_seen = np.asarray(last.views.visible[:, 2:].all(-1))
    order = demo_order(last.settings, len(images))
    partner = np.where(visible.all(-1) & own_seen, np.argsort(order), -1)
    nameable = int((partner >= 0).sum())
    if last.naming is None or not last.naming.accepted:
        return nameable, nameable
    names = last.naming.names
    wrong = names != partner
    for point in np.flatnonzero(wrong & (partner >= 0) & (names >= 0)):
        distance = (images[order[names[point]]] - images[point]).reshape(2, 2)
        wrong[point] = np.linalg.norm(distance, axis=1).max() > SAME_PX
    return nameable, int(wrong[: len(own_seen)].sum())

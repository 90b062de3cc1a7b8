"""Records of steps that compare postures: runs of servos, maps of E, minima, clouds of estimates, places in a room. All
is computed from a step's situation, and kept for equal situations. `plain` makes data for JSON of it."""

import dataclasses
from collections.abc import Mapping
from functools import cache
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from viewimit.analysis.landscape import Landscape, conflict_at, grid_axes, landscape_over, seen_from
from viewimit.analysis.minima import Minima, local_minima
from viewimit.analysis.observability import joint_uncertainty, residual_jacobian, sample_estimates
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.views import FourViews, Pairs
from viewimit.loop.session import Session
from viewimit.servo import Certificate, ServoStatus

from .situation import Situation

Array = NDArray[np.float64]
MAX_MOTIONS = 400  # of a run
BROWSER_SERVOS = ("gradient", "gradient-retuned", "broyden")  # of app/lab/engine/servo.js
MAP_STEP_DEG = 3.0  # of maps
CLAIM_DEG = 1.0  # within which a claim has all joints
DISTANCES = (1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 17.0, 30.0)  # times the distance of the eyes
RUNS, FRAMES = 300, (1, 25)  # estimates in a cloud, and images that are averaged for each
PAIRS, PAIR_SEED, MIN_DIFFERENCE_DEG = 356, 3, 20.0  # of random postures; largest difference of their joints
MORE_POINTS = 20  # layout of the scene that is compared with its layout of ten
# Demonstrator postures off the middle of the sliders, with one minimum of E, which is below LEAST_E: ranges of both
# joints, degrees.
REGIONS = (((10, 25), (-160, -120)), ((65, 80), (-160, -110)), ((65, 80), (-70, -60)))
MAX_TRIED = 200  # postures that are tried for each sample
LEAST_E, START_DIFFERENCE_DEG = 2.0, 20.0  # px²; of start and demonstrator, in each joint
RACE_STARTS, RACE_SEED, RACE_GOAL = 16, 5, 3.0  # random starts over which servos are compared; px²


def plain(values: ArrayLike, digits: int = 4) -> Any:
    """Round numbers to significant digits, nested as they are; None for NaN and infinity."""
    array = np.asarray(values, float)
    if array.ndim:
        return [plain(row, digits) for row in array]
    return float(f"{array:.{digits}g}") if np.isfinite(array) else None


def degrees_off(theta: Array, truth: Array) -> float:
    """Degrees between two postures, of the joint that is farthest off."""
    return float(np.degrees(np.abs(theta - truth).max()))


@cache
def run(situation: Situation, servo: str, max_motions: int = MAX_MOTIONS) -> Session:
    """Run a servo from the step's start until it rests."""
    session = situation.session(servo=servo)
    session.run(max_motions)
    return session


def motions_to(session: Session, goal: float) -> float:
    """Return the number of motions after which E was below the goal for the first time; NaN if it never was."""
    return next((float(moment.motion) for moment in session.history if moment.E < goal), np.nan)


def claim_probability(certificate: Certificate) -> float:
    """Return the probability that all joints are within an angle, for independent normal errors: Π (2 Φ(w/σ) - 1)."""
    ratio = [np.radians(CLAIM_DEG) / error if error > 0 else np.inf for error in certificate.std_error]
    return float(np.prod([2 * NormalDist().cdf(one) - 1 if np.isfinite(one) else 1.0 for one in ratio]))


def claim_record(session: Session) -> dict[str, Any]:
    """How a run ended, as a page tells it by the verdict of its status, and which points were taken for swapped."""
    last, known = session.snapshot, session.snapshot.certificate
    return {
        "status": str(last.status if last.status.is_at_rest else ServoStatus.MAX_MOTIONS),
        "seen": int(last.usable.sum()),
        "unobservable": [] if known is None else known.unobservable_joints,
        "expectedOffDeg": None if known is None else plain(np.degrees(known.simultaneous_std_error)),
        "swapped": [list(pair) for pair in last.exchanged],
    }


def run_record(session: Session) -> dict[str, Any]:
    """A run as the page has it: postures in rad, E in px², probes and how it ended."""
    return {
        "postures": plain([moment.theta for moment in session.history], 6),
        "E": plain([moment.E for moment in session.history]),
        "probes": [bool(moment.probe) for moment in session.history],
        "claim": claim_record(session),
    }


def races(situation: Situation) -> dict[str, Any]:
    """Runs of the step's servos, by name; those that the browser can compute are left out."""
    return {servo: run_record(run(situation, servo)) for servo in situation.race if servo not in BROWSER_SERVOS}


@cache
def landscape(situation: Situation, step_deg: float = MAP_STEP_DEG, transfer: str | None = None) -> Landscape:
    """Compute E over both joints, for the demonstrator in the images at the start."""
    return landscape_over(*seen_from(situation.world, situation.start, transfer), grid_axes(situation.world, step_deg))


@cache
def minima(situation: Situation, transfer: str | None = None) -> Minima:
    """Find the local minima of E, between a coarse grid's postures as well."""
    seen = seen_from(situation.world, situation.start, transfer)
    E_at = lambda theta: conflict_at(*seen, theta)[0]
    return local_minima(landscape(situation, 2 * MAP_STEP_DEG, transfer), E_at)


def bias_deg(situation: Situation, transfer: str | None = None) -> float:
    """Degrees from the posture with the smallest E to the demonstrator's; NaN where there is no E."""
    found = minima(situation, transfer)
    return degrees_off(found.theta[0], situation.start.theta_demo) if len(found) else np.nan


def biases(situation: Situation) -> dict[str, Any]:
    """Degrees from the smallest E to the demonstrator's posture, by transfer, at all DISTANCES."""
    at = [situation.with_eyes(distance=times) for times in DISTANCES]
    return {
        "times": list(DISTANCES),
        "degrees": {name: plain([bias_deg(one, name) for one in at]) for name in TRANSFERS},
    }


@cache
def clouds(situation: Situation) -> Mapping[int, Array]:
    """Draw postures in which E is smallest under noise, (RUNS, 2) rad, by the number of images that are averaged."""
    rng, settings, start = np.random.default_rng(situation.settings.seed), situation.settings, situation.start
    return {
        frames: sample_estimates(situation.world, start.fit, start.theta_demo, settings.noise_px, frames, RUNS, rng)
        for frames in FRAMES
    }


def clouds_record(situation: Situation) -> dict[str, Any]:
    """Clouds as the page has them: of one image, and of an average of many, rad."""
    one, averaged = (clouds(situation)[frames] for frames in FRAMES)
    return {"one": plain(one, 6), "averaged": plain(averaged, 6)}


@cache
def costs(situation: Situation) -> Array:
    """Standard error of each joint for 1 px of noise in the own images, at the demonstrator's posture: (m,) rad/px."""
    world, theta = situation.world, situation.start.theta_demo
    demo, visible = world.demo_images(theta)
    found = joint_uncertainty(world, situation.start.fit, demo, visible, theta)
    return np.full(len(theta), np.inf) if found is None else found


def shown_px(situation: Situation, joint: int, by_arrows: bool) -> float:
    """How far a degree of a joint moves the arrows, or the own images, at the demonstrator: px, root mean square."""
    J = np.radians(1) * jacobian(situation, by_arrows)[:, joint]
    return float(np.sqrt(2 * np.mean(J**2)))


def jacobian(situation: Situation, of_arrows: bool) -> Array:
    """Of the arrows, or of the own images, by the joints at the demonstrator's posture."""
    world, start = situation.world, situation.start
    demo, _ = world.demo_images(start.theta_demo)

    def at(postures: Array) -> Array:
        own, _ = world.own_images(postures.T)
        views = FourViews(demo, own, np.ones(1, bool))
        return start.fit(views).residual(views) if of_arrows else own

    return residual_jacobian(at, start.theta_demo)


def signpost_cosine(views: FourViews, recovered: Array, goal: Array) -> float:
    """Cosine between all arrows, followed from dot to diamond, and the ways to the goal, (…, N, 4) px each."""
    arrows, ways = recovered - views.own, goal - views.own
    return float((arrows * ways).sum() / np.sqrt((arrows**2).sum() * (ways**2).sum()))


@cache
def signposts(situation: Situation) -> Array:
    """Cosines of arrows with the ways to the goal, (PAIRS,), for pairs of postures at random."""
    world, rng = situation.world, np.random.default_rng(PAIR_SEED)
    low, high = world.scene.lower, world.scene.upper
    found: list[float] = []
    while len(found) < PAIRS:
        theta_demo, theta = rng.uniform(low, high, (2, len(low)))
        views, alike = world.look(theta_demo, theta), world.look(theta_demo, theta_demo)
        if degrees_off(theta, theta_demo) >= MIN_DIFFERENCE_DEG and views.complete and alike.complete:
            transfer = situation.start.fit(views)
            found.append(signpost_cosine(views, transfer.recover(views.demo_left, views.demo_right), alike.own))
    return np.array(found)


def true_pairs(situation: Situation) -> Pairs:
    """Pairs of points that are swapped in the demonstrator's images: each lies where the other should."""
    start = situation.start
    true, _ = situation.world.demo_images(start.theta_demo)
    order = np.linalg.norm(start.views.demo[:, None] - true, axis=-1).argmin(1).tolist()
    return tuple((i, j) for i, j in enumerate(order) if i < j and order[j] == i)


def rectified(situation: Situation) -> Mapping[str, Situation]:
    """The step as it is seen, with rectified images, and with more points but not rectified."""
    return {
        "as seen": situation.with_settings(rectify="off"),
        "rectified": situation.with_settings(rectify="auto"),
        "more points": situation.with_settings(rectify="off", points=MORE_POINTS),
    }


def rectification_record(situation: Situation) -> dict[str, Any]:
    """The homographies that rectify both pairs of images, row by row."""
    found = rectified(situation)["rectified"].start.rectification
    if found is None:
        raise ValueError("these images ask for no rectification")
    return {"left": plain(found.left.ravel(), 8), "right": plain(found.right.ravel(), 8)}


# Postures that are sampled, with seeds that are passed in; and starts over which servos are compared


def sample_postures(situation: Situation, count: int, seed: int) -> list[Situation]:
    """Sample postures of both arms from which E can be brought below the situation's goal, if it has one, and whose
    start is far from it. Raises ValueError if too few are found."""
    found: list[Situation] = []
    rng = np.random.default_rng(seed)
    tried = 0
    low, high = np.array(situation.scene.range_deg, float).T
    while len(found) < count:
        tried += 1
        if tried > MAX_TRIED * count:
            raise ValueError(
                f"of {tried - 1} random postures only {len(found)} begin far above the goal and have one minimum: "
                "choose another goal, or no `randomise`"
            )
        region = np.array(REGIONS[len(found) % len(REGIONS)], float)
        demo = rng.uniform(*region.T).round()
        start = rng.uniform(low, high).round()
        if np.abs(start - demo).min() < START_DIFFERENCE_DEG:
            continue
        sample = situation.with_settings(demonstrator_deg=tuple(demo), start_deg=tuple(start))
        if is_fair(sample):
            found.append(sample)
    return found


def race_starts(situation: Situation) -> list[Situation]:
    """Sample the starts over which servos are compared."""
    return sample_postures(dataclasses.replace(situation, goal=RACE_GOAL, race=()), RACE_STARTS, RACE_SEED)


def is_fair(situation: Situation) -> bool:
    """Whether E has one minimum, below LEAST_E, and is above the goal at the start and in the middle of the ranges."""
    found = landscape(situation)
    goal = LEAST_E if situation.goal is None else situation.goal
    middle = found.E[len(found.axes[0]) // 2, len(found.axes[1]) // 2]
    above = situation.start.E > 4 * goal and middle > goal
    return bool(
        above and situation.start.usable.all() and len(found.local_minima()) == 1 and np.nanmin(found.E) < LEAST_E
    )

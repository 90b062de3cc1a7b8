"""Scenes, starts and methods that are sampled or compared: postures for lessons, and rounds of "Design your own".

Everything is drawn with seeds that are passed in, so a page that is written again has the same samples.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace as changed
from functools import cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from viewimit.assets import ROOT

from viewimit.loop.settings import Settings
from viewimit.simulation.scene import Head
from viewimit.simulation.world import World

from .records import degrees_off, landscape, plain
from .situation import Situation, replace

Array = NDArray[np.float64]
# Demonstrator postures off the middle of the sliders, with one minimum of E, which is below LEAST_E: ranges of both
# joints, degrees.
REGIONS = (((10, 25), (-160, -120)), ((65, 80), (-160, -110)), ((65, 80), (-70, -60)))
MAX_TRIED = 200  # postures that are tried for each sample
LEAST_E, MIN_DIFFERENCE_DEG = 2.0, 20.0  # px²; of start and demonstrator, in each joint
RACE_STARTS, RACE_SEED, RACE_GOAL = 16, 5, 3.0  # random starts over which servos are compared; px²
FAR_DEG = 30.0  # of a start in rounds from the demonstrator, the joint that is farthest
ROUNDS, OWN_ROUNDS = 20, 5  # starts in the shipped lesson, and in lessons of others, whose pages are to be written soon
ROUND_MOTIONS, WITHIN_DEG = 30, 1.0  # from each start; an arm within it is there
FAILED_LOOKS = 3  # with too few points, after which a run is given up
SEEN_POSTURES, MAX_TRIES = 64, 100  # postures in which MIN_SEEN points are seen; scenes that are tried
MIN_SEEN = 5
PAGE_CHOICE = Settings().transfer, Settings().servo


def sample_postures(situation: Situation, count: int, seed: int) -> list[Situation]:
    """Sample postures of both arms from which E can be brought below the goal, and whose start is far from it.

    Parameters
    ----------
    situation : Situation
        Its goal is E [px²], if it has one.
    count, seed : int

    Returns
    -------
    list of Situation

    Raises
    ------
    ValueError
        If too few are found, as for a goal that hardly any start is far from.
    """
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
        if np.abs(start - demo).min() < MIN_DIFFERENCE_DEG:
            continue
        sample = situation.with_settings(demonstrator_deg=tuple(demo), start_deg=tuple(start))
        if is_fair(sample):
            found.append(sample)
    return found


def race_starts(situation: Situation) -> list[Situation]:
    """Sample the starts over which servos are compared."""
    return sample_postures(changed(situation, goal=RACE_GOAL, race=()), RACE_STARTS, RACE_SEED)


def is_fair(situation: Situation) -> bool:
    """Whether E has one minimum, below LEAST_E, and is above the goal at the start and in the middle of the ranges."""
    found = landscape(situation)
    goal = LEAST_E if situation.goal is None else situation.goal
    middle = found.E[len(found.axes[0]) // 2, len(found.axes[1]) // 2]
    above = situation.start.E > 4 * goal and middle > goal
    return bool(
        above and situation.start.usable.all() and len(found.local_minima()) == 1 and np.nanmin(found.E) < LEAST_E
    )


def sample_scenes(situation: Situation, count: int, seed: int) -> list[Situation]:
    """Sample scenes in which enough points are seen wherever the arms are.

    Parameters
    ----------
    situation : Situation
        Its ranges are named as fields of `Settings`, or by HEADS.
    count, seed : int

    Returns
    -------
    list of Situation

    Raises
    ------
    ValueError
        If none of MAX_TRIES scenes shows enough points.
    """
    found: list[Situation] = []
    for attempt in range(MAX_TRIES):
        rng = np.random.default_rng([seed, attempt])
        values = {one.name: _stepped(one, float(rng.uniform(one.low, one.high))) for one in situation.randomised}
        head = situation.scene.head
        for name in values.keys() & HEADS.keys():
            head = HEADS[name](head, values[name])
        fields = {name: value for name, value in values.items() if name not in HEADS}
        moved = {"position": list(head.position), "baseline": head.baseline, "toe_in_deg": head.toe_in_deg}
        one = situation.with_scene({**situation.scene_fields, "head": moved}).with_settings(**fields)
        one = changed(one, randomised=())
        if _least_seen(one.world, rng) >= MIN_SEEN:
            found.append(one.with_settings(start_deg=sample_start(one, seed)))
        if len(found) == count:
            return found
    raise ValueError(f"in none of {MAX_TRIES} random scenes are {MIN_SEEN} points in all images, wherever the arms are")


def head_distance(head: Head) -> float:
    """Metres from the head to the middle between its gaze points."""
    return float(np.linalg.norm(_from_gaze(head)))


def _from_gaze(head: Head) -> Array:
    return np.array(head.position) - (np.array(head.gaze_demonstrator) + head.gaze_learner) / 2


def _at(head: Head, metres: float) -> Head:
    away = _from_gaze(head)
    position = np.array(head.position) - away + metres * away / np.linalg.norm(away)
    return replace(head, position=tuple(position.round(6).tolist()))


HEADS: Mapping[str, Any] = {  # values of a head that can be randomised
    "head distance": _at,
    "head baseline": lambda head, metres: replace(head, baseline=metres),
    "head toe-in": lambda head, degrees: replace(head, toe_in_deg=degrees),
}


def sample_start(situation: Situation, seed: int | Sequence[int]) -> tuple[float, ...]:
    """Sample a learner's start in whole degrees, one of whose joints is far from the demonstrator's.

    Raises
    ------
    ValueError
        If the joints' ranges leave no such start.
    """
    rng, (low, high) = np.random.default_rng(seed), np.array(situation.scene.range_deg, float).T
    demo = np.radians(situation.settings.demonstrator_deg or np.degrees(situation.start.theta_demo))
    for _ in range(MAX_TRIED):
        start = rng.uniform(low, high).round()
        if degrees_off(np.radians(start), demo) > FAR_DEG:
            return tuple(start.tolist())
    raise ValueError(f"no start is {FAR_DEG:g}° from the demonstrator's posture: the joints' ranges are too narrow")


def _stepped(one: Any, value: float) -> float:
    return round(one.low + one.step * round((value - one.low) / one.step), 6)


def _least_seen(world: World, rng: np.random.Generator) -> int:
    """Points in all four images at once, the least over postures at random."""
    theta = rng.uniform(world.scene.lower, world.scene.upper, (SEEN_POSTURES, len(world.scene.lower))).T
    visible = np.concatenate([world.demo_images(theta)[1], world.own_images(theta)[1]], -1)
    return int(visible.all(-1).sum(-1).min())


def rounds(situation: Situation, transfer: str, servo: str, starts: Sequence[int]) -> list[tuple[float, int]]:
    """Run a method from random starts: degrees off at the end, of the joint that is farthest, and motions made."""
    made = []
    for k in starts:
        start = sample_start(situation, [situation.settings.seed, k])
        last = situation.session(transfer=transfer, servo=servo, start_deg=start).run(ROUND_MOTIONS, FAILED_LOOKS).last
        made.append((degrees_off(last.theta, last.theta_demo), last.motion))
    return made


def rounds_record(situation: Situation) -> dict[str, Any]:
    """Rounds of every choice that can be made, as the page has them: from the shipped file, or computed."""
    return shipped_rounds().get(situation.digest) or compute_rounds(situation, OWN_ROUNDS)


def compute_rounds(situation: Situation, starts: int) -> dict[str, Any]:
    """Run the method of every choice, and the page's own, from a number of starts: some seconds for each."""
    choices = product(situation.choices.get("transfer", ()), situation.choices.get("servo", ()))
    methods = dict.fromkeys([*choices, PAGE_CHOICE])
    return {
        "starts": starts,
        "motions": ROUND_MOTIONS,
        "withinDeg": WITHIN_DEG,
        "page": "/".join(PAGE_CHOICE),
        "runs": {
            f"{transfer}/{servo}": plain(rounds(situation, transfer, servo, range(starts)), 3)
            for transfer, servo in methods
        },
    }


@cache
def shipped_rounds() -> dict[str, dict[str, Any]]:
    """Read the rounds of the shipped lesson by the digests of its scenes; assets/build_rounds.py writes them."""
    return json.loads(ROOT.joinpath("lessons", "rounds.json").read_bytes())

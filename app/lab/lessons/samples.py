"""Postures that are sampled for lessons, and starts over which servos are compared. Everything is drawn with seeds that
are passed in, so a page that is written again has the same samples."""

from dataclasses import replace as changed

import numpy as np

from .records import landscape
from .situation import Situation

# Demonstrator postures off the middle of the sliders, with one minimum of E, which is below LEAST_E: ranges of both
# joints, degrees.
REGIONS = (((10, 25), (-160, -120)), ((65, 80), (-160, -110)), ((65, 80), (-70, -60)))
MAX_TRIED = 200  # postures that are tried for each sample
LEAST_E, MIN_DIFFERENCE_DEG = 2.0, 20.0  # px²; of start and demonstrator, in each joint
RACE_STARTS, RACE_SEED, RACE_GOAL = 16, 5, 3.0  # random starts over which servos are compared; px²


def sample_postures(situation: Situation, count: int, seed: int) -> list[Situation]:
    """Sample `count` postures of both arms from which E can be brought below the situation's goal, if it has one, and
    whose start is far from it. Raises ValueError if too few are found, as for a goal that hardly any start is far
    from."""
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

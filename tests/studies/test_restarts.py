"""A law that ends where E is large begins again from the same starts as all others, and returns to its best end."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from restarts import Restarts, RestartState, far_postures

from viewimit.servo import Observation, ServoMethod, ServoStatus

LIMIT = np.radians([90.0, 60.0])


def observation(theta, E, motion, noise_px=0.0):
    return Observation(np.zeros((5, 4)), np.ones((5, 2), bool), E, theta, -LIMIT, LIMIT, motion, noise_px)


@dataclass
class State:
    left: int
    status: ServoStatus = ServoStatus.MOVING
    probe: bool = False
    learned: int = 0


@dataclass
class Descends:
    """Makes a number of motions of 1° in each descent, and then rests."""

    motions: int = 2
    at_rest: ServoStatus = ServoStatus.SETTLED
    begun: list = field(default_factory=list)

    def start(self, seen):
        self.begun.append(seen.displacement)
        return State(self.motions)

    def step(self, state, seen, residuals):
        assert np.isfinite(seen.E)
        step = np.radians([1.0, 0.0]) if state.left else np.zeros(2)
        status = ServoStatus.MOVING if state.left else self.at_rest
        return State(state.left - 1, status, state.left == self.motions, state.learned + 1), step


def driven(law, E_at, max_motions=100, noise_px=0.0, seed=(0, 1), **given):
    """Ends as the loop does: postures, and the last state."""
    servo = Restarts(ServoMethod(servo=law), seed, max_motions, **given)
    theta, state, been = np.zeros(2), None, [np.zeros(2)]
    for motion in range(max_motions):
        seen = observation(theta, E_at(theta), motion, noise_px)
        state = servo.start(seen) if state is None else state
        state, step = servo.step(state, seen, None)
        if not step.any():
            break
        theta = theta + step
        assert (np.abs(theta) <= LIMIT + 0.1).all()
        been.append(theta)
    return been, state


def test_where_e_is_small_it_ends_as_the_law_does():
    law = Descends()
    been, state = driven(law, lambda theta: 0.001)
    assert len(been) == 3 and state.status == "settled" and len(law.begun) == 1


@pytest.mark.parametrize("status", ["settled", "no-progress", "unobservable"])
def test_where_e_stays_large_it_begins_at_every_start_and_returns_to_the_end_with_the_smallest_e(status):
    aim = np.radians([40.0, -30.0])
    law, E_at = Descends(at_rest=ServoStatus(status)), lambda theta: 1.0 + np.degrees(np.abs(theta - aim)).sum()
    been, state = driven(law, E_at)
    starts = far_postures(observation(np.zeros(2), 1.0, 0), 4, np.random.default_rng([0, 1, 2]))
    np.testing.assert_allclose(law.begun[1:], starts)
    ends = [np.add(begun, np.radians([2.0, 0.0])) for begun in law.begun]
    assert len(law.begun) == 5 and state.status == "no-progress" and not state.probe
    np.testing.assert_allclose(been[-1], min(ends, key=E_at))
    # two motions each descent, one to each start, and one back unless the last end is the best
    assert len(been) - 1 == 5 * 2 + 4 + (min(ends, key=E_at) is not ends[-1])


def test_starts_are_the_same_for_all_laws_and_far_from_each_other():
    seen = observation(np.radians([80.0, 50.0]), 1.0, 0)
    first = Restarts(ServoMethod(servo=Descends()), (4, 7), 50).start(seen)
    other = Restarts(ServoMethod(servo=Descends(9)), (4, 7), 99).start(seen)
    np.testing.assert_array_equal(first.starts, other.starts)
    assert (np.array(Restarts(ServoMethod(servo=Descends()), (4, 8), 50).start(seen).starts) != first.starts).any()
    among = np.array([seen.displacement, *first.starts])
    apart = np.abs(among[:, None] - among).max(-1)[np.triu_indices(5, 1)]
    assert (np.abs(among) <= LIMIT).all() and apart.min() > np.radians(30.0)
    assert isinstance(first, RestartState) and len(first.starts) == 4

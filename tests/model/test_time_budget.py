"""What one hostile tab may take of the others' time; a person loses nothing by it."""

from dataclasses import dataclass

import numpy as np
import pytest
from page_fakes import call, quiet_model
from viewimit.app.commands import COMMANDS
from viewimit.app.model.queue import JITTER_ALLOWANCE, MIN_REPEAT_INTERVAL, CommandQueue, Queued
from viewimit.app.model.services import LoadShedding
from viewimit.app.page.loop import AT_ONCE, MAX_DEBT_S, SHARE, CommandLoop, TimeBudget

from viewimit.loop.settings import Settings

TICK = 0.05


class Clock:
    """s, as the test has it."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


def passed(rate: float, seconds: float, late: float = 0.0) -> int:
    """Equal actions that pass of those that are put at this rate, each up to `late` s late."""
    clock, step, rng = Clock(), call("step"), np.random.default_rng(1)
    queue = CommandQueue(COMMANDS, clock)
    sent = np.arange(0, seconds, 1 / rate)
    taken = 0
    for clock.now in np.sort(sent + rng.uniform(0, late, len(sent))):
        queue.put(step)
        taken += len(queue.take())
    return taken


@pytest.mark.parametrize("late", [0.0, JITTER_ALLOWANCE / 2])
def test_fifteen_equal_actions_a_second_pass_and_a_flood_of_them_is_as_many_as_there_are_ticks(late):
    assert passed(15, 10, late) == 150
    assert passed(140, 10, late) <= 10 / MIN_REPEAT_INTERVAL + JITTER_ALLOWANCE / MIN_REPEAT_INTERVAL + 1


def test_other_actions_are_not_merged_and_values_between_make_no_difference():
    queue, step, reset = CommandQueue(COMMANDS, Clock()), call("step"), call("reset")
    for _ in range(20):
        queue.put(step)
        queue.put(reset)
    assert queue.take() == [step, reset] * 20


@dataclass(frozen=True)
class Costly(Queued):
    """Takes so many s of the clock."""

    number: int
    clock: Clock
    seconds: float
    done: list

    def apply(self, model, now):
        self.clock.now += self.seconds
        self.done.append(self.number)


@pytest.mark.parametrize("cost", [0.002, 0.008, 0.06])
def test_a_page_has_a_share_of_the_time_and_what_is_beyond_waits_in_its_order(cost):
    clock, done = Clock(), []
    model, _ = quiet_model(Settings.paper())
    queue = CommandQueue(COMMANDS, clock)
    loop = CommandLoop(model, queue, LoadShedding(TICK), lambda now: None, TimeBudget(clock))
    for k in range(150):
        queue.put(Costly(k, clock, cost, done))
    spent, began = [], clock.now
    while len(done) < 150:
        before = clock.now
        loop.tick(clock.now)
        spent.append(clock.now - before)
        clock.now += max(TICK - spent[-1], 0.001)
    assert done == list(range(150))
    assert spent[0] <= AT_ONCE / (1 - SHARE) + 2 * cost
    assert sum(spent) <= AT_ONCE + SHARE * (clock.now - began) + cost
    assert max(spent[1:]) <= max(2 * SHARE * TICK + cost, 1.3 * cost)


@pytest.mark.parametrize("seconds", [0.5, 2.0, 60.0])
def test_a_page_makes_up_for_a_long_command_but_for_no_more_than_a_second_of_it(seconds):
    clock = Clock()
    budget = TimeBudget(clock)

    def work():
        clock.now += seconds

    budget.spend(work)
    ended, waits = clock.now, min((1 - SHARE) * seconds - AT_ONCE, MAX_DEBT_S) / SHARE
    clock.now = ended + 0.99 * waits
    assert not budget.left
    clock.now = ended + 1.01 * waits
    assert budget.left

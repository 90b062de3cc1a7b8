"""A duel is two runs side by side: neither knows of the other, both of every change."""

import msgspec
import numpy as np
import pytest
from page_fakes import Hands, quiet_model
from viewimit.app.model.player import ARRIVED_DEG

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings


@pytest.fixture
def race():
    """A visitor at the start of a duel: session, player, duel, visitor."""
    model, _ = quiet_model(Settings(noise_px=0.1))
    visitor = Hands(model)
    visitor.act("duel", 0.0)
    return model.session, model.player, model.duel, visitor


def alone(settings, motions):
    session = Session(settings)
    for _ in range(motions):
        session.step()
    return [moment.theta.tolist() for moment in session.history]


def test_each_moves_as_it_would_alone(race):
    session, player, duel, visitor = race
    for _ in range(9):
        visitor.act("step", 0.0)
    for racer in (session, duel.opponent):
        assert [moment.theta.tolist() for moment in racer.history] == alone(racer.settings, 9)
    own, other = msgspec.structs.asdict(session.settings), msgspec.structs.asdict(duel.opponent.settings)
    assert {name for name in own if own[name] != other[name]} == {"transfer", "servo"}


@pytest.mark.parametrize("speed", [0.0, 10.0])
def test_one_that_rests_waits_for_the_other(race, speed):
    session, player, duel, _ = race
    player.speed = speed
    for tick in range(100):
        player.advance(0.05 * tick)
    assert session.snapshot.status == "converged"
    assert duel.opponent.snapshot.motion > session.snapshot.motion
    assert player.cursor == duel.opponent.cursor and player.last == len(duel.opponent.history) - 1


def test_undo_and_scrub_keep_them_together(race):
    session, player, duel, visitor = race
    for _ in range(5):
        visitor.act("step", 0.0)
    visitor.act("undo", 0.0)
    assert session.cursor == duel.opponent.cursor == 4
    visitor.set("history", 1)
    assert session.cursor == duel.opponent.cursor == 1 and player.last == 5
    duel.opponent.step()
    duel.opponent.step()
    visitor.set("history", 3)
    assert (session.cursor, duel.opponent.cursor) == (3, 3)
    for beyond in (-1, 6):
        visitor.set("history", beyond)
        assert (session.cursor, duel.opponent.cursor) == (3, 3)


@pytest.mark.parametrize(
    "name, value", [("joint0", 61.0), ("noise_px", 0.3), ("frames", 5), ("gain_error", 10), ("encoder_step_deg", 1.0)]
)
def test_what_changes_for_the_learner_changes_for_its_opponent(race, name, value):
    session, _, duel, visitor = race
    visitor.act("step", 0.0)
    visitor.set(name, value)
    expected = msgspec.structs.replace(session.settings, transfer=duel.transfer, servo=duel.servo)
    assert duel.opponent.settings == expected and duel.opponent.snapshot.motion == 1
    assert np.array_equal(duel.opponent.snapshot.theta_demo, session.snapshot.theta_demo)


def test_arrival_is_the_first_motion_within_a_degree_of_where_the_demonstrator_is_now(race):
    session, _, duel, visitor = race
    for _ in range(8):
        visitor.act("step", 0.0)
    errors = [np.degrees(np.abs(moment.theta - moment.theta_demo)).max() for moment in session.history]
    own, other = duel.standings
    assert list(own.errors_deg) == pytest.approx(errors) and other.arrived is None
    assert own.arrived == next(k for k, error in enumerate(errors) if error < ARRIVED_DEG)
    visitor.set("joint0", 80.0)
    assert duel.standings[0].arrived is None
    for _ in range(12):
        visitor.act("step", 0.0)
    assert duel.standings[0].arrived > own.arrived

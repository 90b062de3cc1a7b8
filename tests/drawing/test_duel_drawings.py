"""Drawings of a duel, of all transfers and of what noise costs say what the arrays say, and stay small."""

import re
from dataclasses import replace

import numpy as np
import pytest
from drawn import parsed, words
from viewimit.app.drawing import duel as duel_drawing
from viewimit.app.drawing import landscapes
from viewimit.app.model.player import Duel, Player

from viewimit.analysis.minima import study_transfer
from viewimit.drawing import landscape
from viewimit.drawing.landscape import SMALL_WIDTH
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

SEVEN = Settings.paper(joints=tuple(range(1, 8)), points=16, demonstrator_deg=(10, 40, -10, -80, 15, 100, 30))


def raced(settings, motions, transfer="epipolar", servo="gradient"):
    session = Session(settings)
    player = Player(session)
    duel = Duel(session, player)
    duel.transfer, duel.servo = transfer, servo
    duel.toggle()
    for motion in range(motions):
        player.step(float(motion))
    return session, duel


@pytest.fixture(scope="module")
def race():
    return raced(Settings(), 8)


@pytest.fixture(scope="module")
def studied():
    session = Session(Settings())
    return session, [study_transfer(session.world, session.snapshot, transfer) for transfer in TRANSFERS]


def draw_race(session, duel):
    return duel_drawing.draw_race(session.scene, (session, duel.opponent), duel.standings)


def compared(session, found):
    drawn = [landscapes.draw_compared(session.scene, one, session.snapshot.theta_demo) for one in found]
    return landscapes.draw_together(drawn)


class TestTransfers:
    def test_nothing_stands_outside_its_column(self, studied):
        session, found = studied
        root = parsed(compared(session, found))
        for column in root.iter("g"):
            for text in column.findall("text"):
                assert float(text.get("x")) + 5.6 * len(text.text) < SMALL_WIDTH + landscapes.GAP


def drawings(race, studied):
    session, found = studied
    seven = raced(SEVEN, 1)
    yield from (
        draw_race(*race),
        draw_race(*seven),
        duel_drawing.draw_empty(),
        duel_drawing.draw_errors_alone(race[1].standings),
    )
    yield duel_drawing.draw_ground(session.scene, [], session.snapshot.theta_demo)
    yield duel_drawing.draw_ground(session.scene, [one.landscape for one in found[:2]], session.snapshot.theta_demo)
    yield compared(session, found)
    costs = [landscapes.draw_costs((1, 2), "rank3", spread) for spread in (np.ones(2), None)]
    yield landscapes.draw_together(costs)
    blind = replace(found[0].landscape, E=np.full((91, 181), np.nan))
    yield duel_drawing.draw_ground(session.scene, [blind, blind], session.snapshot.theta_demo)
    yield landscape.draw_observability((1, 2, 3), np.array([1.0, 9.0, np.inf]))


def test_drawings_are_valid_and_write_a_real_minus(race, studied):
    for drawing in drawings(race, studied):
        text = words(drawing)
        assert not re.search(r"-\d|nan", text)

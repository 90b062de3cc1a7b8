"""Drawings of a duel, of all transfers and of what noise costs say what the arrays say, and stay small."""

import re
from dataclasses import replace

import numpy as np
import pytest
from drawn import (
    LAYOUT_ONLY_OF_DUELS,
    LEARNERS_PATH,
    OPPONENTS_PATH,
    css,
    numbers,
    parsed,
    path,
    used,
    words,
)
from viewimit.app.drawing import duel as duel_drawing
from viewimit.app.drawing import landscapes
from viewimit.app.model.player import Duel, Player
from viewimit.app.static import stylesheet

from viewimit.analysis.minima import study_transfer
from viewimit.drawing import landscape
from viewimit.drawing.landscape import SMALL_WIDTH, small_plane
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

PAGE_CSS = stylesheet()
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


class TestDuel:
    def test_paths_run_through_the_postures_of_each(self, race):
        session, duel = race
        plane, root = small_plane(session.scene, duel_drawing.MAX_HEIGHT), parsed(draw_race(session, duel))
        for racer, kind in ((session, LEARNERS_PATH), (duel.opponent, OPPONENTS_PATH)):
            line = path(root, kind)
            expected = plane.place(np.degrees([moment.theta for moment in racer.history]))
            assert numbers(line).reshape(-1, 2) == pytest.approx(expected, abs=0.06)


class TestTransfers:
    def test_each_cross_is_a_minimum_between_the_grids_points(self, studied):
        session, found = studied
        for one in found:
            lowest, grid = one.minima.theta[0], one.landscape
            assert one.minima.E[0] <= np.nanmin(grid.E) and np.abs(lowest - grid.minimum).max() < np.radians(2.5)
            assert one.bias_deg == pytest.approx(np.degrees(lowest - session.snapshot.theta_demo))
        assert np.abs(found[-1].bias_deg).max() < 0.01 < np.abs(found[0].bias_deg).max()  # projective: none

    def test_nothing_stands_outside_its_column(self, studied):
        session, found = studied
        root = parsed(compared(session, found))
        for column in root.iter("g"):
            for text in column.findall("text"):
                assert float(text.get("x")) + 5.6 * len(text.text) < SMALL_WIDTH + landscapes.GAP


class TestObservability:
    SPREAD = np.radians([2.0, 1.0, 4.0, np.inf, 9.0])

    def test_bars_are_as_long_as_their_costs(self):
        bars = [
            float(bar.get("width"))
            for bar in parsed(landscape.draw_bars((1, 2, 3, 4, 5), self.SPREAD, 424, 20)).iter("rect")
        ]
        assert np.array(bars) / bars[4] == pytest.approx([2 / 9, 1 / 9, 4 / 9, 1, 1], abs=1e-3)


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


def test_drawings_are_valid_name_roles_only_and_write_a_real_minus(race, studied):
    for drawing in drawings(race, studied):
        text = words(drawing)
        assert not re.search(r"-\d|nan", text)
        without_data = re.sub(r'data:[^"]*|url\(#[^)]*\)', "", drawing)
        assert not re.search(r"#[0-9a-fA-F]{3,8}\b|\brgba?\(|(fill|stroke)=\"(?!none|var|url)", without_data)
        names = used(drawing)
        assert all(css(name) in PAGE_CSS for name in names - LAYOUT_ONLY_OF_DUELS), names

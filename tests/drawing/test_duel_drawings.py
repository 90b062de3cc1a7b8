"""Drawings of a duel, of all transfers and of what noise costs say what the arrays say, and stay small."""

import re
from dataclasses import replace

import numpy as np
import pytest
from drawn import (
    JOINT_LABELS,
    LAYOUT_ONLY_OF_DUELS,
    LEARNER_NOW,
    LEARNERS_PATH,
    OPPONENT_NOW,
    OPPONENTS_PATH,
    SMALLEST_E,
    TWO_COLUMNS,
    WEAK_JOINT,
    classes,
    css,
    dashed,
    numbers,
    only,
    parsed,
    path,
    paths,
    used,
    words,
)
from viewimit.app.drawing import duel as duel_drawing
from viewimit.app.drawing import joint_bars, landscapes
from viewimit.app.model.player import Duel, Player
from viewimit.app.static import stylesheet

from viewimit.analysis.landscape import landscape_over
from viewimit.analysis.minima import study_transfer
from viewimit.drawing import curves, landscape
from viewimit.drawing.landscape import SMALL_WIDTH, LandscapePicture, small_plane
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import ServoStatus

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

    def test_the_two_are_told_apart_by_line_and_mark(self, race):
        root = parsed(draw_race(*race))
        assert len(only(root, "circle", LEARNER_NOW)) == 1
        assert len(only(root, "rect", OPPONENT_NOW)) == 1
        assert re.search(re.escape(css(OPPONENTS_PATH)) + r"\{[^}]*stroke-dasharray", PAGE_CSS)
        assert not re.search(re.escape(css(LEARNERS_PATH)) + r"\{[^}]*stroke-dasharray", PAGE_CSS)

    def test_it_says_motions_error_E_and_method_of_each(self, race):
        session, duel = race
        text = words(draw_race(session, duel))
        for racer in (session, duel.opponent):
            error = np.degrees(np.abs(racer.snapshot.theta - racer.snapshot.theta_demo)).max()
            assert f"steps {racer.snapshot.motion} largest error {error:.{2 if error < 10 else 1}f}" in text
        assert "Learner: Projective combination" in text and "Opponent: Epipolar (paper)" in text

    @pytest.mark.parametrize(
        "own, other, states, first, second",
        [
            (None, None, "moving moving", "Neither is within 1°", "3.00° off. Opponent: "),
            (
                None,
                None,
                "no-progress converged",
                "Neither came within 1°",
                "Stuck, 3.00° off. Opponent: Arrived",
            ),
            (6, None, "converged moving", "The learner was first within 1°", "Opponent: Moving, 4.00°"),
            (6, 9, "converged converged", "The learner was first within 1°", "The opponent followed after 9 steps."),
            (9, 6, "converged converged", "The opponent was first within 1°", "The learner followed after 9 steps."),
            (None, 1, "ready converged", "within 1°, after 1 step.", "Learner: Ready, 3.00° off."),
            (7, 7, "converged moving", "A tie: both were within 1° of the demonstrator after 7 steps.", ""),
            (0, None, "ready moving", "The learner was first within 1°, after 0 steps.", "Opp"),
        ],
    )
    def test_the_verdict_names_who_arrived_first(self, race, own, other, states, first, second):
        standings = [
            replace(
                standing,
                arrived=arrived,
                errors_deg=[error],
                snapshot=replace(standing.snapshot, status=ServoStatus(status)),
            )
            for standing, arrived, error, status in zip(
                race[1].standings, (own, other), (3.0, 4.0), states.split(), strict=True
            )
        ]
        said = duel_drawing.verdict(standings)
        assert first in said[0] and second in said[1]

    def test_errors_stand_on_a_log_axis(self, race):
        _, duel = race
        html = duel_drawing.draw_errors(duel.standings)
        for standing, dash in zip(duel.standings, ("solid", "dashed")):
            line = paths(html, dashed(dash))[0]
            x, y = numbers(line).reshape(-1, 2).T
            errors = np.log(np.maximum(standing.errors_deg, duel_drawing.MIN_ERROR_DEG))
            slope = (y[-1] - y[0]) / (errors[-1] - errors[0])
            assert slope < 0 and y == pytest.approx(y[0] + slope * (errors - errors[0]), abs=0.3)
            assert np.diff(x) == pytest.approx(np.diff(x)[0], abs=0.11)

    def test_with_seven_joints_errors_take_the_landscapes_place(self):
        session, duel = raced(SEVEN, 2, "linear", "broyden")
        html = draw_race(session, duel)
        assert "Largest joint error" in html and LEARNERS_PATH not in used(html)

    def test_paths_of_many_motions_stay_small(self, race):
        session, duel = race
        session, duel = raced(Settings.paper(servo="gradient-retuned"), 400)
        assert len(draw_race(session, duel).encode()) < 9_000


class TestTransfers:
    def test_each_cross_is_a_minimum_between_the_grids_points(self, studied):
        session, found = studied
        for one in found:
            lowest, grid = one.minima.theta[0], one.landscape
            assert one.minima.E[0] <= np.nanmin(grid.E) and np.abs(lowest - grid.minimum).max() < np.radians(2.5)
            assert one.bias_deg == pytest.approx(np.degrees(lowest - session.snapshot.theta_demo))
        assert np.abs(found[-1].bias_deg).max() < 0.01 < np.abs(found[0].bias_deg).max()  # projective: none

    def test_the_drawing_says_bias_minima_and_basin_of_each(self, studied):
        session, found = studied
        html = compared(session, found)
        text = words(html)
        for one in found:
            bias = np.abs(one.bias_deg).max()
            assert f"bias {bias:.1f}° · 1 minimum · basin {100 * one.basin:.0f} %" in text
        root = parsed(html)
        crosses = only(root, "path", SMALLEST_E)
        plane = small_plane(session.scene, landscapes.MAX_HEIGHT)
        for one, cross in zip(found, crosses, strict=True):
            x, y, half = numbers(cross.get("d"))[:3]
            assert (x + half / 2, y) == pytest.approx(plane.place(np.degrees(one.minima.theta[0])), abs=0.11)
        assert len(html.encode()) < 45_000

    def test_minima_are_counted_in_words(self, studied):
        one = studied[1][0]
        two = replace(one, minima=replace(one.minima, theta=np.zeros((2, 2)), E=np.ones(2)), basin=0.123)
        assert landscapes.describe_landscape(two).endswith("2 minima · basin 12 %")
        none = replace(one, minima=replace(one.minima, theta=np.empty((0, 2)), E=np.empty(0)))
        assert landscapes.describe_landscape(none) == "no minimum"

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

    @pytest.mark.parametrize("degrees", [20.0, 170.3, np.inf])
    def test_a_cost_that_says_nothing_is_no_number(self, degrees):
        spread = np.radians([2.0, degrees])
        told = landscape.describe_costs((2, 4), spread)
        assert told == "noise of 1 px: θ₂ 2.0°; θ₄ unobservable"
        assert landscape.describe_costs((2, 4), np.radians([25.0, degrees])) == "θ₂, θ₄ unobservable"
        said = landscape.describe_weakness((2, 4), spread)
        assert (
            said[0].startswith("Joint 4 is unobservable")
            and said[1] == "1 px of noise shifts the others by 2.0° at most."
        )
        assert words(landscape.draw_bars((2, 4), spread, 200, 20)) == "θ₂ 2.0° θ₄ unobservable"

    def test_weak_joints_are_named_marked_and_beside_the_rest(self):
        html = landscape.draw_observability((1, 2, 3, 4, 5), self.SPREAD)
        said = words(html)
        assert "Joint 4 is unobservable" in said
        assert "1 px of noise shifts the others by 9.0° at most." in said
        root = parsed(html)
        assert len(only(root, "path", WEAK_JOINT)) == 2
        one = landscape.describe_weakness((2, 4), np.radians([1, 3]))
        assert one == ["Joint 4 is hard to see:", "1 px of noise shifts it by 3.0°, and the others by 1.0° at most."]
        none = landscape.describe_weakness((2, 4), np.radians([1, 1.5]))
        assert none == ["No joint is much harder to see: 1 px of noise shifts each by 1.5° at most."]

    def test_they_take_the_landscapes_place_with_seven_joints_and_its_caption_with_two(self):
        session = Session(SEVEN)
        picture = LandscapePicture(None, session.scene, session.snapshot, "too few", np.radians(np.arange(1.0, 8)))
        assert "Joint error per pixel of noise" in picture.html and "too few" not in picture.html
        assert parsed(picture.draw_path(session.history, 0)).find(".//path") is None
        blind = LandscapePicture(None, session.scene, session.snapshot, "too few points")
        assert "too few points" in blind.html
        session = Session(Settings.paper())
        views = session.snapshot.views
        found = landscape_over(session.world, TRANSFERS["linear"], views.demo, views.visible[:, :2])
        picture = LandscapePicture(found, session.scene, session.snapshot, std_per_px=np.radians([2.2, 1.8]))
        assert "noise of 1 px: θ₂ 2.2°, θ₄ 1.8°" in words(picture.html)


class TestManyJoints:
    @pytest.mark.parametrize("settings, columns", [(Settings.paper(), False), (SEVEN, True)])
    def test_the_learners_bars_stand_in_two_columns_if_many(self, settings, columns):
        session = Session(settings)
        theta, demo = session.snapshot.theta, session.snapshot.theta_demo
        root = parsed(joint_bars.draw_learner(session.scene, theta, demo))
        assert (TWO_COLUMNS in classes(root[0])) == columns
        for row, own, mark, low, high in zip(root[0], theta, demo, session.scene.lower, session.scene.upper):
            left, right = (float(row.find(".//line").get(name)) for name in ("x1", "x2"))
            places = left + (right - left) * (np.array([own, mark]) - low) / (high - low)
            assert float(row.find(".//circle").get("cx")) == pytest.approx(places[0], abs=0.1)
            assert numbers(row.find(".//path").get("d"))[0] == pytest.approx(places[1], abs=0.1)
            assert float(row.find("b").text.replace("−", "-").rstrip("°")) == pytest.approx(np.degrees(own), abs=0.051)

    def test_curves_label_each_joint_once(self):
        session = Session(SEVEN)
        for _ in range(3):
            session.step()
        html = curves.draw_curves(session.history, 3, None, session.scene.moving_joints, 424, [9.0, 4.0, 3.0, 2.0])
        labels = only(parsed(html), "text", JOINT_LABELS)
        heights = sorted(float(t.get("y")) for t in labels)
        assert len(labels) == 7 and min(np.diff(heights)) > 12.9
        assert "2.0° off, rms 3.1° over 3 steps" in words(html)


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

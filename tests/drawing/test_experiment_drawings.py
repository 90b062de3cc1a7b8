"""The experiments' figures say what their results say: whole, in part, and where numbers are missing."""

import re
from dataclasses import replace

import numpy as np
import pytest
from drawn import BIASES_EPIPOLAR, CURVE, OWN_TRACE, SOLID, TRUE, marked, numbers, only, parsed, paths, words

from viewimit.drawing import plots
from viewimit.experiments import EXPERIMENTS
from viewimit.experiments.paper import fig7, fig9, fig10
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene

SCENE = load_scene("panda")


def draw(name, result):
    return EXPERIMENTS[name].figure(result)


@pytest.fixture(scope="module")
def landscape():
    return fig7.run(Settings.paper(), step_deg=15.0, study=(2, 2))


@pytest.fixture(scope="module")
def imitation():
    return fig9.run(Settings.paper(), starts=(1, 1), max_motions=300)


@pytest.fixture(scope="module")
def trajectory():
    return fig10.run(Settings.paper(), max_motions=30)


def lines(html, *seen):
    """Curves, without the legend's samples."""
    return [d for d in paths(html, CURVE, *seen) if "h22" not in d]


def starts(d):
    """Where each subpath begins."""
    return np.array([numbers(part)[:2] for part in d.split("M")[1:]])


class TestFig7:
    def test_what_has_no_number_is_left_out(self, landscape):
        surface = landscape.surfaces["epipolar"]
        bias = landscape.studies["epipolar"].bias_deg.copy()
        bias[1] = np.nan
        studies = {"epipolar": replace(landscape.studies["epipolar"], bias_deg=bias)}
        html = draw("fig7", replace(landscape, studies=studies))
        assert 3 in [d.count("M") for d in paths(html, BIASES_EPIPOLAR)] and "nan" not in html
        blind = replace(surface.landscape, E=np.full_like(surface.landscape.E, np.nan))
        none = replace(surface.minima, theta=np.empty((0, 2)), E=np.empty(0), on_limit=np.empty(0, bool))
        unseen = replace(surface, landscape=blind, minima=none, convexity=None, E_demo=np.nan)
        html = draw("fig7", replace(landscape, surfaces={"epipolar": unseen}, studies={}))
        assert "nowhere are five points seen" in words(html) and "nan" not in html


class TestFig9:
    def test_unknown_E_interrupts_the_line(self, imitation):
        run = imitation.of("broyden")[0]
        E = run.E.copy()
        E[2] = np.nan
        html = draw("fig9", replace(imitation, runs=(replace(run, E=E),), E_demo=np.nan))
        assert "nan" not in html and [d.count("M") for d in lines(html, SOLID)] == [1, 1, 2]


class TestFig10:
    def panels(self, html):
        """Four (own path, true path, words), L and R of each pair."""
        boxes = [box for box in parsed(html).iter("svg") if box.get("width") == str(fig10.PANEL)]
        found = []
        for box in boxes:
            own = [p.get("d") for p in marked(box, "path", OWN_TRACE)]
            true = [p.get("d") for p in only(box, "path", TRUE)]
            found.append((own, true, " ".join(box.itertext())))
        return found

    def test_points_that_are_lost_interrupt_the_paths(self, trajectory):
        run = trajectory.runs[fig10.CONVERGED]
        own = run.own.copy()
        own[40:50] = np.nan
        own[-1] = np.nan
        lost = replace(run, own=own)
        html = draw("fig10", replace(trajectory, runs={fig10.CONVERGED: lost}))
        assert "nan" not in html
        assert self.panels(html)[0][0][0].count("M") == 2 * run.followed.sum()
        gone = replace(run, own=np.full_like(own, np.nan), desired=np.full_like(own, np.nan))
        assert "nan" not in draw("fig10", replace(trajectory, runs={fig10.CONVERGED: gone}))


@pytest.fixture(scope="module")
def drawings(landscape, imitation, trajectory):
    found = {"fig7": landscape, "fig9": imitation, "fig10": trajectory}
    return [
        *(draw(name, result) for name, result in found.items()),
        *(experiment.empty_figure(SCENE) for experiment in EXPERIMENTS.values()),
    ]


class TestAll:
    def test_every_figure_is_as_large_as_the_others_and_valid(self, drawings):
        for drawing in drawings:
            (svg,) = parsed(drawing)
            assert svg.get("viewBox") == f"0 0 {plots.WIDTH} {plots.HEIGHT}"

    def test_writes_a_real_minus(self, drawings):
        for drawing in drawings:
            assert not re.search(r"-\d", words(drawing))

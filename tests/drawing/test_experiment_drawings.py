"""The experiments' figures say what their results say: whole, in part, and where numbers are missing."""

import re
from dataclasses import replace

import numpy as np
import pytest
from drawn import (
    BIASES_EPIPOLAR,
    CURVE,
    DEMONSTRATORS_POSTURE,
    OWN_TRACE,
    PARABOLAS_LEVEL,
    PROGRESS,
    SMALLEST_E,
    SOLID,
    TRUE,
    css,
    line_of,
    marked,
    numbers,
    only,
    parsed,
    paths,
    words,
)
from viewimit.app.jobs.experiments import Run
from viewimit.app.panels.experiments import draw_verdict
from viewimit.app.static import PAGE_CSS

from viewimit.drawing import plots, svg, theme
from viewimit.drawing.plots import decades
from viewimit.drawing.posture_plane import PosturePlane
from viewimit.experiments import EXPERIMENTS
from viewimit.experiments.paper import (
    fig7,
    fig9,
    fig10,
)
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene

MINUS = "−"
SCENE = load_scene("panda")
PAGES_OWN = {  # besides roles: a scale's place and words of now, where its colours change, and the component library's
    *("now", "told", "first", "second"),
    *(f"mantine-{name}" for name in ("color-white", "primary-color-filled", "primary-color-filled-hover")),
    *("mantine-spacing-xs", "mantine-spacing-md"),
}
HOSTILE = '<img src=x onerror="1">&'


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


def vertices(d):
    return numbers(d).reshape(-1, 2)


def starts(d):
    """Where each subpath begins."""
    return np.array([numbers(part)[:2] for part in d.split("M")[1:]])


class TestFig7:
    def place(self, degrees):
        plane = PosturePlane(SCENE, fig7.MAP_WIDTH, fig7.MAP_HIGH)
        return plane.place(np.asarray(degrees, float))

    def test_marks_are_at_the_demonstrator_and_at_the_minimum(self, landscape):
        html = draw("fig7", landscape)
        minimum = np.degrees(landscape.surfaces["epipolar"].minima.theta[0])
        cross = starts(paths(html, SMALLEST_E)[0])
        assert [cross[0, 0] + fig7.CROSS, cross[0, 1]] == pytest.approx(self.place(minimum), abs=0.06)
        diamond = starts(paths(html, DEMONSTRATORS_POSTURE)[0])[0]
        assert diamond == pytest.approx(self.place([45, -90]), abs=0.06)
        off = minimum - (45, -90)
        said = "smallest E (" + ", ".join(f"{angle:.1f}°".replace("-", MINUS) for angle in off) + ") off"
        assert said in words(html)

    def test_the_ellipse_is_a_level_of_the_parabola_as_far_as_it_holds(self, landscape):
        surface = landscape.surfaces["epipolar"]
        scale = PosturePlane(SCENE, fig7.MAP_WIDTH, fig7.MAP_HIGH).scale
        away = vertices(paths(draw("fig7", landscape), PARABOLAS_LEVEL)[0])
        away = (away - self.place(np.degrees(surface.minima.theta[0])))[:, ::-1] * (-1, 1) / scale
        level = np.einsum("ni,ij,nj->n", away, surface.convexity.Q, away)
        assert level == pytest.approx(np.full(len(level), level.mean()), rel=0.05)
        assert np.linalg.norm(away, axis=1).max() == pytest.approx(surface.convexity.holds_to_deg, rel=0.02)

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
    def x(self, motions):
        width = fig9.RIGHT - fig9.LEFT
        return fig9.LEFT + width * np.log1p(motions) / np.log1p(fig9.MAX_MOTIONS)

    def test_motions_are_logarithmic_and_angles_true(self, imitation):
        run = imitation.of("broyden")[0]
        html = draw("fig9", imitation)
        curves = [vertices(d) for d in lines(html, line_of("learner"), SOLID)][-3:]
        top, bottom = fig9.ANGLES
        for curve, angle in zip(curves, run.theta_deg.T):
            np.testing.assert_allclose(curve[:, 0], self.x(np.arange(len(run.E))), atol=0.06)
            np.testing.assert_allclose(curve[:, 1], top + (bottom - top) * (90 - angle) / 270, atol=0.06)
        slope = np.polyfit(np.log10(run.E), curves[2][:, 1], 1)[0]
        low, high = decades(np.concatenate([run.E for run in imitation.runs]), 1, 100)
        top, bottom = fig9.CONFLICT
        assert slope == pytest.approx((top - bottom) / np.log10(high / low), rel=1e-3)

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

    def test_own_and_true_paths_are_as_far_apart_as_in_the_images(self, trajectory):
        panels = self.panels(draw("fig10", trajectory))
        for name, pair in ((fig10.CONVERGED, panels[:2]), (fig10.BEFORE, panels[2:])):
            run, scales = trajectory.runs[name], []
            for k, ((own,), (true,), said) in enumerate(pair):
                assert "LR"[k] in said and own.count("M") == true.count("M") == run.followed.sum()
                kept = svg.thinned(len(run.own), fig10.VERTICES)
                view = slice(2 * k, 2 * k + 2)
                apart = (run.own - run.desired)[kept][:, run.followed, view]
                drawn = (vertices(own.replace("M", " ")) - vertices(true.replace("M", " "))).reshape(
                    run.followed.sum(), -1, 2
                )
                span = np.ptp(run.desired[kept][:, run.followed, view], (0, 1)).max()
                scales.append(np.ptp(vertices(true.replace("M", " ")), 0).max() / span)
                np.testing.assert_allclose(drawn, scales[-1] * np.moveaxis(apart, 1, 0), atol=0.25)
            assert scales[0] == pytest.approx(scales[1], rel=0.02)

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

    def test_names_no_colour_and_no_role_that_does_not_exist(self, drawings):
        page = PAGE_CSS[PAGE_CSS.index(css(PROGRESS)) :]
        for drawing, others in [*((each, ()) for each in (*drawings, theme.DRAWING_CSS)), (page, PAGES_OWN)]:
            without_data = re.sub(r'data:[^"]*|url\(#[^)]*\)', "", drawing)
            assert not re.search(r"#[0-9a-fA-F]{3,8}\b|\brgba?\(|(fill|stroke)=\"(?!none|var|url)", without_data)
            assert set(re.findall(r"var\(--([a-z-]+)", drawing)) <= {*theme.ROLES, *others}

    def test_writes_a_real_minus(self, drawings):
        for drawing in drawings:
            assert not re.search(r"-\d", words(drawing))


class TestVerdict:
    def test_where_nothing_is_found_it_says_why(self):
        assert words(draw_verdict(Run("fig9", "failed", problem=HOSTILE))) == f"Fig. 9 failed: {HOSTILE}"
        assert draw_verdict(None) == draw_verdict(Run("fig9", "running")) == ""

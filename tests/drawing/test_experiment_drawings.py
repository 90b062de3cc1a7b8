"""The experiments' figures say what their results say: whole, in part, and where numbers are missing."""

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from drawn import (
    AXES,
    BIASES_EPIPOLAR,
    BIASES_LINEAR,
    CURVE,
    DEMONSTRATORS_POSTURE,
    LAYOUT_ONLY,
    LEVELS,
    NOT_ARRIVED,
    OWN_TRACE,
    PAPERS_MINIMUM,
    PARABOLAS_LEVEL,
    PROGRESS,
    SCALE_BAR,
    SMALLEST_E,
    SOLID,
    TRUE,
    css,
    dashed,
    line_of,
    marked,
    numbers,
    only,
    parsed,
    paths,
    styled,
    used,
    words,
)
from viewimit.app.jobs.experiments import Run
from viewimit.app.panels.experiments import draw_progress, draw_verdict
from viewimit.app.static import PAGE_CSS

from viewimit.drawing import plots, svg, theme
from viewimit.drawing.plots import Axes, decade_ticks, decades, log10
from viewimit.drawing.posture_plane import PosturePlane
from viewimit.estimation.transfers import TRANSFERS
from viewimit.experiments import EXPERIMENTS
from viewimit.experiments.paper import (
    fig7,
    fig9,
    fig10,
)
from viewimit.experiments.paper.common import Claim
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

    def test_every_other_demonstrators_bias_is_a_dot(self, landscape):
        html = draw("fig7", landscape)
        most = np.ceil(max(5, *(np.abs(study.bias_deg).max() for study in landscape.studies.values())))
        left, top, right, bottom = fig7.BIAS_BOX
        scale = (bottom - top) / (2 * most)
        for transfer, kind in (("epipolar", BIASES_EPIPOLAR), ("linear", BIASES_LINEAR)):
            bias = landscape.studies[transfer].bias_deg
            dots = next(starts(d) for d in paths(html, kind) if d.count("M") == len(bias))
            dots = dots - ((left + right) / 2, (top + bottom) / 2)
            np.testing.assert_allclose(dots, np.stack([bias[:, 1], -bias[:, 0]], -1) * scale, atol=0.06)

    def test_the_error_of_the_parabola_is_drawn_over_the_radius(self, landscape):
        html = draw("fig7", landscape)
        worst = 100 * landscape.surfaces["epipolar"].convexity.worst
        drawn = vertices(lines(html, line_of("learner"))[0])
        assert len(drawn) == np.isfinite(worst).sum()
        assert drawn[[0, -1], 0] == pytest.approx([fig7.VALIDITY_BOX[0], fig7.VALIDITY_BOX[2]], abs=0.06)
        heights = np.log10(worst[np.isfinite(worst)])
        assert np.corrcoef(heights, drawn[:, 1])[0, 1] == pytest.approx(-1, abs=1e-3)

    def test_parts_of_it_are_drawn_too(self, landscape):
        nothing = replace(landscape, surfaces={}, studies={})
        assert "computing" in words(draw("fig7", nothing))
        first = replace(nothing, surfaces={"epipolar": landscape.surfaces["epipolar"]})
        assert paths(draw("fig7", first), LEVELS) and len(lines(draw("fig7", first))) == 1
        some = replace(landscape.studies["epipolar"], bias_deg=landscape.studies["epipolar"].bias_deg[:3])
        html = draw("fig7", replace(landscape, studies={"epipolar": some}))
        assert 3 in [d.count("M") for d in paths(html, BIASES_EPIPOLAR)]

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

    def test_the_papers_minimum_is_shown_for_the_papers_demonstrator_only(self, landscape):
        elsewhere = replace(landscape, demonstrator_deg=(60.0, -60.0))
        marks = [len(paths(draw("fig7", found), PAPERS_MINIMUM)) for found in (landscape, elsewhere)]
        assert marks == [2, 1]  # in the legend, too


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

    def test_what_does_not_arrive_ends_in_crosses_and_says_so(self, imitation):
        html = draw("fig9", imitation)
        stuck = imitation.of("gradient")[0]
        late = [run for run in (imitation.of(law)[0] for law in imitation.laws) if run.error_deg[-1] > 3]
        crosses = [starts(d)[:, 0] for d in paths(html, NOT_ARRIVED)]
        assert stuck in late and len(crosses) == len(late) < 3
        for x, run in zip(crosses, late):
            np.testing.assert_allclose(x, self.x(len(run.E) - 1), atol=0.06)
        best = min(run.error_deg[-1] for run in imitation.of("gradient"))
        assert f"0 of 2, best {best:.0f}° off" in words(html)
        broyden = imitation.of("broyden")
        median = np.median([run.motions_until(3.0) for run in broyden])
        assert f"2 of 2, median {median:.0f}" in words(html)
        arrived = replace(stuck, theta_deg=stuck.theta_deg * 0 + stuck.demonstrator_deg)
        assert not paths(draw("fig9", replace(imitation, runs=(arrived,))), NOT_ARRIVED)

    def test_the_demonstrators_angles_and_E_are_broken_lines(self, imitation):
        levels = [vertices(d)[:, 1] for d in paths(draw("fig9", imitation), TRUE)]
        top, bottom = fig9.ANGLES
        expected = [top + (bottom - top) * (90 - angle) / 270 for angle in (45, -90)]
        assert [level[0] for level in levels[:2]] == pytest.approx(expected, abs=0.06)
        assert all(level[0] == level[1] for level in levels) and len(levels) == 3

    def test_a_long_run_stays_light_and_keeps_its_end(self):
        count = 3001
        theta = np.stack([np.linspace(25, 60, count), np.linspace(-25, -80, count)], -1)
        probe = np.zeros(count, bool)
        run = fig9.Run(
            "gradient", (25.0, -25.0), (45.0, -90.0), theta, np.geomspace(200, 3, count), probe, "no-progress"
        )
        settings = Settings.paper(demonstrator_deg=(45.0, -90.0), start_deg=(25.0, -25.0))
        runs = tuple(replace(run, law=law) for law in fig9.laws_of(settings) for _ in range(7))
        html = draw("fig9", fig9.Fig9(settings, (2, 4), ((25.0, -25.0),) * 7, 1.6, runs))
        assert len(html) < 50_000
        ends = [vertices(d)[-1, 0] for d in lines(html)]
        assert ends and ends == pytest.approx([self.x(3000)] * len(ends), abs=0.06)

    def test_a_conflict_that_nobody_could_see_does_not_stretch_the_axis(self, imitation):
        run = imitation.of("broyden")[0]
        found = replace(imitation, runs=(replace(run, E=run.E * 1e-12),), E_demo=1e-12)
        html = draw("fig9", found)
        assert "E < 0.01 px²" in words(html) and "1e-" not in words(html)
        bottom = vertices(lines(html, SOLID)[2])[-1, 1]
        assert bottom == pytest.approx(fig9.CONFLICT[1], abs=0.06)

    def test_parts_of_it_are_drawn_too(self, imitation):
        for count in range(len(imitation.runs)):
            part = replace(imitation, runs=imitation.runs[:count])
            html = draw("fig9", part)
            assert len(lines(html)) == 3 * count

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

    def test_the_bar_tells_the_scale(self, trajectory):
        html = draw("fig10", trajectory)
        run = trajectory.runs[fig10.CONVERGED]
        own = vertices(self.panels(html)[1][0][0].replace("M", " "))
        scale = np.ptp(own, 0)[1] / np.ptp(run.own[:, run.followed, 3])
        x, _, end = numbers(paths(html, SCALE_BAR)[0])
        said = float(re.search(r"(\d+) px", self.panels(html)[1][2])[1])
        assert (end - x) / said == pytest.approx(scale, rel=0.03)

    def test_errors_of_all_runs_are_drawn(self, trajectory):
        html = draw("fig10", trajectory)
        styles = [("learner", "solid"), ("recovered", "dash-dot"), ("residual", "dashed"), ("ink", "dotted")]
        low, high = decades(np.concatenate([1e3 * run.hand_m for run in trajectory.runs.values()]), 1, 1000)
        top, bottom = fig10.PLOT_TOP, fig10.PLOT_BOTTOM
        for run, (role, dash) in zip(trajectory.runs.values(), styles):
            curve = vertices(lines(html, line_of(role), dashed(dash))[1])
            y = bottom - (bottom - top) * np.log10(1e3 * run.hand_m[[0, -1]] / low) / np.log10(high / low)
            assert curve[[0, -1], 1] == pytest.approx(y, abs=0.06)
        assert "5.95 s" in words(html) and "sinusoid" in words(html)

    def test_parts_of_it_are_drawn_too(self, trajectory):
        for count in range(4):
            part = replace(trajectory, runs=dict(list(trajectory.runs.items())[:count]))
            html = draw("fig10", part)
            assert sum(bool(own) for own, *_ in self.panels(html)) == (0, 2, 2, 4)[count]
            assert len(lines(html)) == 2 * count

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

    def test_an_error_that_nobody_could_see_does_not_stretch_the_axes(self, trajectory):
        run = trajectory.runs[fig10.CONVERGED]
        exact = replace(run, theta=run.theta_demo, hand_m=run.hand_m * 1e-12)
        html = draw("fig10", replace(trajectory, runs={fig10.CONVERGED: exact}))
        for curve in lines(html, SOLID):
            np.testing.assert_allclose(vertices(curve)[:, 1], fig10.PLOT_BOTTOM, atol=0.06)
        assert "0.01" in words(html) and "0.001" not in words(html)

    def test_a_motions_name_is_escaped(self, trajectory):
        named = msgspec.structs.replace(trajectory.motion, name=HOSTILE)
        html = draw("fig10", replace(trajectory, motion=named))
        assert "<img" not in html and parsed(html)


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

    def test_each_says_of_what_it_was_made_and_an_empty_one_what_it_shows(self, drawings):
        for drawing in drawings[:3]:
            assert f"Demonstrator (45.0°, {MINUS}90.0°) · epipolar transfer · panda, 10 points" in words(drawing)
        for drawing, module in zip(drawings[3:], (fig7, fig9, fig10)):
            assert "Demonstrator (" not in drawing and all(line in words(drawing) for line in module.SENTENCE)
            assert paths(drawing, AXES)

    def test_disturbances_are_among_what_it_was_made_of(self):
        settings = Settings.paper(demonstrator_deg=(45.0, -90.0), noise_px=0.5, missing=0.1, transfer="linear")
        assert plots.describe_settings(settings).endswith(
            "linear transfer · panda, 10 points · noise 0.5 px, missing 10%"
        )
        assert "<img" not in plots.figure(msgspec.structs.replace(settings, scene=HOSTILE), "")

    def test_seven_joints_are_drawn_too(self, trajectory):
        scene = load_scene("panda", None, (1, 2, 3, 4, 5, 6, 7))
        for experiment in EXPERIMENTS.values():
            assert parsed(experiment.empty_figure(scene))
        settings = Settings.paper(
            joints=(1, 2, 3, 4, 5, 6, 7), demonstrator_deg=(0.0, 45.0, 0.0, -90.0, 0.0, 90.0, 45.0)
        )
        (caption,) = parsed(plots.figure(settings, "", " · a motion of a very long name")).iter("text")
        assert caption.get("textLength") == str(plots.WIDTH) and len(caption.text) <= plots.MAX_CAPTION
        assert caption.text.startswith(f"Demonstrator (0°, 45°, 0°, {MINUS}90°, 0°, 90°, 45°) · epipolar")
        assert "two joints must move" in words(EXPERIMENTS["fig7"].empty_figure(scene))

    def test_names_no_colour_and_no_role_that_does_not_exist(self, drawings):
        page = PAGE_CSS[PAGE_CSS.index(css(PROGRESS)) :]
        for drawing, others in [*((each, ()) for each in (*drawings, theme.DRAWING_CSS)), (page, PAGES_OWN)]:
            without_data = re.sub(r'data:[^"]*|url\(#[^)]*\)', "", drawing)
            assert not re.search(r"#[0-9a-fA-F]{3,8}\b|\brgba?\(|(fill|stroke)=\"(?!none|var|url)", without_data)
            assert set(re.findall(r"var\(--([a-z-]+)", drawing)) <= {*theme.ROLES, *others}

    def test_every_class_is_styled(self, drawings):
        assert used("".join(drawings)) - styled(theme.DRAWING_CSS) <= LAYOUT_ONLY

    def test_writes_a_real_minus(self, drawings):
        for drawing in drawings:
            assert not re.search(r"-\d", words(drawing))

    @pytest.mark.parametrize("scene", ["iiwa", "panda-facing"])
    def test_other_scenes_are_drawn_empty(self, scene):
        for experiment in EXPERIMENTS.values():
            assert parsed(experiment.empty_figure(load_scene(scene)))

    def test_transfers_and_laws_have_styles_of_their_own(self):
        for names in (list(TRANSFERS), list(fig9.laws_of(Settings.paper())), list(fig10.RUNS)):
            assert len({plots.style_of(name, names) for name in names}) == len(names)
            assert len({(style.dash, style.mark) for style in plots.STYLES}) == len(plots.STYLES)


class TestPlot:
    def test_places(self):
        plot = Axes((10, 20, 110, 220), (0, 10), (1, 100), up=log10)
        np.testing.assert_allclose(plot.place([0, 5, 10], [1, 10, 100]), [[10, 220], [60, 120], [110, 20]])
        assert np.isnan(plot.place([1, 1, np.nan], [0, -3, 5])).all()

    def test_decades(self):
        assert decades(np.array([0.3, 20, np.nan, -1]), 1, 10) == (0.1, 100)
        assert decades(np.empty(0), 1, 100) == (1, 100) == decades(np.array([1.0, 100.0]), 1, 100)
        assert [value for value, _ in decade_ticks(0.01, 1000, 3)] == [0.01, 1, 100]


CLAIMS = (
    Claim("Fig. 9: broyden, came within 3°", "converges", "7 of 7 starts", "≥ 80% of starts", True, "broyden"),
    Claim("Eq. (11): E convex", "nearby", HOSTILE, "–", None, "E convex"),
    Claim("Fig. 9: broyden, smallest E", "0", "5 px²", "≤ 1.64 px²", False, HOSTILE),
)


class TestVerdict:
    def test_rows_are_judged_by_shape_colour_and_word(self):
        html = draw_verdict(Run("fig9", "done", claims=CLAIMS))
        rows = list(parsed(html).iter("tr"))[1:]
        assert [row[0].text for row in rows] == ["broyden, came within 3°", "Eq. (11): E convex", "broyden, smallest E"]
        assert ["".join(row[4].itertext()) for row in rows] == ["pass", "–", "miss"]
        assert [len(list(row.iter("circle"))) for row in rows] == [1, 0, 0]
        assert [len(list(row.iter("rect"))) for row in rows] == [0, 0, 1]
        assert rows[1][2].text == HOSTILE
        assert parsed(html).find(".//p/b").text == f"1 of 2 holds; {HOSTILE} does not"

    def test_where_nothing_is_found_it_says_why(self):
        assert words(draw_verdict(Run("fig9", "failed", problem=HOSTILE))) == f"Fig. 9 failed: {HOSTILE}"
        assert draw_verdict(None) == draw_verdict(Run("fig9", "running")) == ""

    @pytest.mark.parametrize(
        "run, said, percent",
        [
            (None, "not run yet", 0),
            (Run("fig9", "waiting"), "waiting for its turn", 0),
            (Run("fig9", "running", share=0.428), "43 %", 43),
            (Run("fig7", "running", share=0.5), "Fig. 7: 50 %", 50),
            (Run("fig9", "writing", share=1.0), "writing the files …", 100),
            (
                Run("fig9", "done", share=1.0, claims=CLAIMS, seconds=5.2),
                f"done: 1 of 2 holds; {HOSTILE} does not",
                100,
            ),
            (Run("fig9", "done", share=1.0, claims=CLAIMS[1:2], seconds=5.2), "done in 5 s", 100),
            (Run("fig9", "cancelled", share=0.31), "cancelled at 31 %", 31),
            (Run("fig9", "failed", problem=HOSTILE), f"failed: {HOSTILE}", 0),
        ],
        ids=str,
    )
    def test_progress(self, run, said, percent):
        root = parsed(draw_progress(run, "fig9"))
        bar = next(box for box in root.iter("div") if box.get("role") == "progressbar")
        assert "".join(root.itertext()) == said and bar.get("aria-valuenow") == str(percent)
        assert bar.get("aria-label") == ("experiment" if run is None else EXPERIMENTS[run.name].short_title)
        assert bar[0].get("style") == f"width:{percent}%"

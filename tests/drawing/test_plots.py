"""Plots as text: numbers, thinned paths, ticks and labels, and the words around the plane of two joints."""

import itertools
import re

import msgspec
import numpy as np
import pytest
from drawn import CENTRED, TO_THE_LEFT, marked, parsed

from viewimit.drawing import svg
from viewimit.drawing.labels import CHARACTER
from viewimit.drawing.plots import LABEL_SPACING, Axes, angle_ticks, linear_ticks, spread_heights
from viewimit.drawing.posture_plane import MAX_HEIGHT, WIDTH, PosturePlane
from viewimit.simulation.scene import load_scene


@pytest.mark.parametrize("low, high", [(0, 640), (-3.2, 4.1), (291.3, 297.9), (0.01, 0.052), (-1e4, 3e4)])
def test_linear_ticks_are_round_and_inside(low, high):
    values = np.array([value for value, _ in linear_ticks(low, high)])
    assert 2 <= len(values) <= 5 and low <= values[0] and values[-1] <= high + 1e-9
    step = np.diff(values)[0]
    assert np.diff(values) == pytest.approx(step) and values / step == pytest.approx(np.round(values / step))
    assert f"{step:.0e}"[0] in "125"
    said = [float(words.replace("−", "-")) for _, words in linear_ticks(low, high)]
    assert said == pytest.approx(values)


def test_angles_have_ticks_at_usual_degrees():
    assert angle_ticks(-180, 0) == [(-180, "−180°"), (-135, "−135°"), (-90, "−90°"), (-45, "−45°"), (0, "0°")]
    assert [value for value, _ in angle_ticks(-20, 20)] == [-15, 0, 15]


def test_labels_do_not_overlap_and_stay_inside():
    placed = spread_heights([10, 11, 50, 99, 100], 0, 100)
    assert min(np.diff(placed)) >= LABEL_SPACING and placed[-1] <= 100 and placed[0] == 10 and placed[2] == 50
    assert spread_heights([], 0, 100) == []


def test_a_scale_may_run_downwards_as_pixels_do():
    axes = Axes((0, 0, 100, 50), (0, 640), (240, 0))
    np.testing.assert_allclose(axes.place([0, 640], [0, 240]), [[0, 0], [100, 50]])


@pytest.mark.parametrize("nothing", [-0.0, 0.0, -0.04])
def test_zero_is_always_written_the_same(nothing):
    assert svg.filled("%s", np.array([nothing])) == "0.0"
    assert svg.filled("%s %s", np.array([nothing, 1e6])) == "0.0 1000000.0"


def test_numbers_are_the_nearest_tenths_near_and_far_and_not_a_number_too():
    values = np.random.default_rng(0).uniform(-5000, 5000, 500)
    for value, written in zip(values, svg.filled("%s " * len(values), values).split()):
        assert written.partition(".")[2].isdigit() and len(written.partition(".")[2]) == 1
        assert abs(float(written) - value) <= 0.05 + 1e-9
    assert svg.filled("%s", np.array([np.nan])) == "nan"


@pytest.mark.parametrize("count, keep", [(5, 2), (180, 179), (181, 180), (4887, 4886), (4887, 3000), (100_000, 0)])
def test_a_long_path_is_followed_where_it_begins_and_where_it_is_now(count, keep):
    """At most `limit`, the gaps no more than a share of the way to the nearer of both."""
    limit = 180
    kept = np.array(svg.thinned_between(count, limit, keep))
    assert len(kept) <= limit and (np.diff(kept) > 0).all() and {0, keep, count - 1} <= set(kept.tolist())
    gaps, middle = np.diff(kept), (kept[1:] + kept[:-1]) / 2
    assert (gaps <= 1 + 0.35 * np.minimum(middle, np.abs(middle - keep))).all()
    assert {0, 1, keep, max(keep - 1, 0)} <= set(kept.tolist())


HIGH = 9  # px of a letter over its line
NOTES = ("", "noise of 1 px: θ₂ 2.0°, θ₄ 2.0°", "noise of 1 px: θ₁₂ 19.9°; θ₁₀ unobservable")
SPANS = [
    (90, 180),
    (90, 150),
    (90, 90),
    (90, 60),
    (60, 90),
    (45, 90),
    (30, 90),
    (90, 30),
    (180, 20),
    (360, 90),
    (12, 80),
]
ANCHORS = {TO_THE_LEFT: 1.0, CENTRED: 0.5}


def boxes(html):
    """By text, with its place: left, top, right, bottom px, as wide as it is at most drawn."""
    found = {}
    for text in marked(parsed(html), "text", ""):
        before = sum(share for name, share in ANCHORS.items() if name in text.get("class", "").split())
        x, y, width = float(text.get("x")), float(text.get("y")), CHARACTER * len(text.text)
        found[text.text, x, y] = x - before * width, y - HIGH, x + (1 - before) * width, y
    return found


def assert_no_overlap(html, height):
    placed = boxes(html)
    for (left, top, right, bottom), (a, b, c, d) in itertools.combinations(placed.values(), 2):
        assert right <= a or c <= left or bottom <= b or d <= top, (placed, (left, top, right, bottom), (a, b, c, d))
    for words, (left, top, right, bottom) in placed.items():
        assert left >= -CHARACTER and top >= 0 and right <= WIDTH + CHARACTER and bottom <= height, words


@pytest.mark.parametrize("note", NOTES)
def test_words_at_the_axes_do_not_overlap_for_any_ranges(note):
    scenes = [load_scene(name) for name in ("panda", "iiwa")]
    spans = [((low, low + up), (-60.0, across - 60.0)) for low in (0, -75) for up, across in SPANS]
    scenes += [msgspec.structs.replace(scenes[0], range_deg=span) for span in spans]
    for scene in scenes:
        plane = PosturePlane(scene)
        html = plane.axes(note)
        assert_no_overlap(plane.wrap(html), plane.height)
        assert [words for words, *_ in boxes(plane.wrap(html))].count("θ₄") == 1
        assert len(re.findall("<text", html)) >= 5 + bool(note)


def test_the_axis_name_stands_in_the_middle_where_it_can():
    plane = PosturePlane(load_scene("panda"))
    left, _, width, high = plane.box
    assert high <= MAX_HEIGHT
    middle = next(place for place in boxes(plane.wrap(plane.axes())) if place[0] == "θ₄")
    assert middle[1] == pytest.approx(left + width / 2, abs=0.1)

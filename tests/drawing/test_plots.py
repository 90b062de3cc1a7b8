"""Plots as text: numbers, thinned paths, ticks and labels, and the words around the plane of two joints."""

import itertools
import re

import msgspec
import numpy as np
import pytest
from drawn import CENTRED, TO_THE_LEFT, marked, parsed

from viewimit.drawing.labels import CHARACTER
from viewimit.drawing.plots import linear_ticks
from viewimit.drawing.posture_plane import WIDTH, PosturePlane
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

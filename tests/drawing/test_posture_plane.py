"""Around the plane of two joints' angles: no word or number is written over another one or out of the drawing."""

import itertools
import re

import msgspec
import pytest
from drawn import CENTRED, TO_THE_LEFT, marked, parsed

from viewimit.drawing.labels import CHARACTER
from viewimit.drawing.posture_plane import MAX_HEIGHT, WIDTH, PosturePlane
from viewimit.simulation.scene import load_scene

HIGH = 9  # px of a letter over its line
NOTES = ("", "1 px costs θ₂ 2.0°, θ₄ 2.0°", "1 px costs θ₁₂ 19.9°; θ₁₀ not observable")
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


def assert_apart(html, height):
    placed = boxes(html)
    for (left, top, right, bottom), (a, b, c, d) in itertools.combinations(placed.values(), 2):
        assert right <= a or c <= left or bottom <= b or d <= top, (placed, (left, top, right, bottom), (a, b, c, d))
    for words, (left, top, right, bottom) in placed.items():
        assert left >= -CHARACTER and top >= 0 and right <= WIDTH + CHARACTER and bottom <= height, words


@pytest.mark.parametrize("note", NOTES)
def test_words_at_the_axes_keep_off_each_other_whatever_the_ranges(note):
    scenes = [load_scene(name) for name in ("panda", "iiwa")]
    spans = [((low, low + up), (-60.0, across - 60.0)) for low in (0, -75) for up, across in SPANS]
    scenes += [msgspec.structs.replace(scenes[0], range_deg=span) for span in spans]
    for scene in scenes:
        plane = PosturePlane(scene)
        html = plane.axes(note)
        assert_apart(plane.wrap(html), plane.height)
        assert [words for words, *_ in boxes(plane.wrap(html))].count("θ₄") == 1
        assert len(re.findall("<text", html)) >= 5 + bool(note)


def test_the_axis_name_stands_in_the_middle_where_it_can():
    plane = PosturePlane(load_scene("panda"))
    left, _, width, high = plane.box
    assert high <= MAX_HEIGHT
    middle = next(place for place in boxes(plane.wrap(plane.axes())) if place[0] == "θ₄")
    assert middle[1] == pytest.approx(left + width / 2, abs=0.1)

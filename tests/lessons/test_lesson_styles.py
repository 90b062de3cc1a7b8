"""What a lesson writes can be read, in light and dark: by the contrast of its colours (WCAG 2.2, 1.4.3)."""

import re

import pytest
from viewimit.app import static

from viewimit.drawing.theme import ROLES

CSS = static.stylesheet()
LESSON = CSS[CSS.index("/* A lesson stands in place") :]
RULES = re.findall(r"([^{}]+)\{([^{}]*)\}", re.sub(r"/\*.*?\*/", "", LESSON, flags=re.S))
WORDS = re.compile(r"words|huge|giant|of-found|unit|failed")  # of drawings, in classes that colour text
READ = sorted(
    {role for where, what in RULES for role in re.findall(r"(?<![-\w])color:var\(--([\w-]+)\)", what)}
    | {role for where, what in RULES if WORDS.search(where) for role in re.findall(r"fill:var\(--([\w-]+)\)", what)}
)
SURFACES = {"paper": {"ink"}}  # what is written in paper's colour, on what


def contrast(one, other):
    """Of two colours, #rrggbb."""

    def luminance(colour):
        channels = [int(pair, 16) / 255 for pair in re.findall("..", colour[1:])]
        r, g, b = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def declared(selector, name):
    """The colour that a rule of exactly this selector has."""
    found = [re.search(rf"(?<![-\w]){name}:([^;]+)", what) for where, what in RULES if where.strip() == selector]
    return next(one[1].strip() for one in found if one)


def test_contrast_is_known_of_black_and_white():
    assert contrast("#000000", "#ffffff") == pytest.approx(21) and contrast("#777777", "#ffffff") < 4.5


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("role", READ)
def test_words_can_be_read(role, dark):
    assert {"ink", "learner", "secondary"} <= set(READ)
    for ground in SURFACES.get(role, {"paper", "card"}):
        assert contrast(ROLES[role][dark], ROLES[ground][dark]) >= 4.5


def test_filled_buttons_can_be_read():
    for selector in (".vi-filled", ':root[data-mantine-color-scheme="dark"] .vi-filled'):
        assert contrast("#ffffff", declared(selector, "background")) >= 4.5
    assert declared(".vi-filled", "color") == "#fff"


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_what_is_chosen_right_and_wrong_is_seen_apart_from_its_ground(dark):
    """Borders, 1.4.11; right and wrong have a sign as well."""
    for role in ("learner", "recovered", "residual"):
        assert contrast(ROLES[role][dark], ROLES["paper"][dark]) >= 3


def test_what_is_touched_is_large_enough():
    """44 px: sliders, and on a phone answers and the way out."""
    assert declared(".vi-guide-sliders input", "height") == "44px"
    assert declared(".vi-guide-sliders label", "min-height") == "44px"
